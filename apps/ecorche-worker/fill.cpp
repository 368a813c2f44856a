// SPDX-License-Identifier: AGPL-3.0-or-later

#include <ecorche/core/files.h>
#include <ecorche/domain/fill_mesh_3.h>

#include <filesystem>

#include "worker.h"

namespace ecorche::worker {

Result<void> fillSurface(const Arguments& arguments) {
  if (arguments.size() != 2) return fail(ErrorCode::Internal, "usage: fill INPUT OUTPUT");
  auto bytes = readFile(arguments[0]);
  if (!bytes) return passOn(bytes);
  auto request = domain::decodeFillRequest(*bytes);
  if (!request) return passOn(request);

  // Where CGAL fails it leaves its dump in the working folder: in the scratch folder that is
  const auto output = std::filesystem::absolute(arguments[1]);
  std::error_code ignored;
  std::filesystem::current_path(output.parent_path(), ignored);
  auto answer = domain::fillByMesh3(*request);
  if (!answer) return passOn(answer);
  return writeFileWhole(output, domain::encodeTetAnswer(*answer));
}

}  // namespace ecorche::worker
