// SPDX-License-Identifier: AGPL-3.0-or-later

#include <ecorche/core/files.h>
#include <ecorche/domain/tet_files.h>
#include <fmt/format.h>
#include <tetgen.h>

#include <vector>

#include "worker.h"

namespace ecorche::worker {

namespace {

// TetGen throws numbers
std::string reasonOf(int code) {
  switch (code) {
    case 1:
      return "out of memory";
    case 2:
      return "a bug of its own";
    case 3:
      return "the surface intersects itself";
    case 4:
      return "a feature of the surface is too small";
    case 5:
      return "two facets nearly coincide";
    case 10:
      return "wrong input";
    default:
      return fmt::format("code {}", code);
  }
}

// TetGen frees what its lists point to; facets share one array of polygons, which is ours.
struct Input {
  tetgenio io;
  std::vector<tetgenio::facet> facets;
  std::vector<tetgenio::polygon> polygons;
  ~Input() {
    io.facetlist = nullptr;
    io.numberoffacets = 0;
  }
};

void fill(Input& input, domain::TetRequest& request) {
  tetgenio& io = input.io;
  const auto surfaceCount = request.surface.V.rows();
  io.firstnumber = 0;
  io.numberofpoints = static_cast<int>(surfaceCount + request.points.rows());
  io.pointlist = new REAL[static_cast<std::size_t>(io.numberofpoints) * 3];
  std::copy_n(request.surface.V.data(), surfaceCount * 3, io.pointlist);
  std::copy_n(request.points.data(), request.points.rows() * 3, io.pointlist + surfaceCount * 3);

  const auto faceCount = static_cast<std::size_t>(request.surface.F.rows());
  input.facets.resize(faceCount);
  input.polygons.resize(faceCount);
  io.numberoffacets = static_cast<int>(faceCount);
  io.facetlist = input.facets.data();
  io.facetmarkerlist = new int[faceCount];
  for (std::size_t f = 0; f < faceCount; ++f) {
    input.polygons[f].vertexlist = request.surface.F.data() + 3 * f;
    input.polygons[f].numberofvertices = 3;
    tetgenio::init(&input.facets[f]);
    input.facets[f].polygonlist = &input.polygons[f];
    input.facets[f].numberofpolygons = 1;
    // 0 would mean "no marker"; the face's number finds its tag again
    io.facetmarkerlist[f] = static_cast<int>(f) + 1;
  }
  io.numberofholes = static_cast<int>(request.holes.rows());
  if (io.numberofholes > 0) {
    io.holelist = new REAL[static_cast<std::size_t>(io.numberofholes) * 3];
    std::copy_n(request.holes.data(), request.holes.size(), io.holelist);
  }
}

}  // namespace

Result<void> tetrahedralizeSurface(const Arguments& arguments) {
  if (arguments.size() != 2) return fail(ErrorCode::Internal, "usage: tetrahedralize INPUT OUTPUT");
  auto bytes = readFile(arguments[0]);
  if (!bytes) return passOn(bytes);
  auto request = domain::decodeTetRequest(*bytes);
  if (!request) return passOn(request);

  Input input;
  fill(input, *request);
  tetgenio out;
  try {
    std::string switches = request->switches;
    ::tetrahedralize(switches.data(), &input.io, &out);
  } catch (const int code) {
    return fail(code == 1 ? ErrorCode::OutOfMemory : ErrorCode::MeshingFailed,
                fmt::format("TetGen gave up: {}", reasonOf(code)));
  }

  domain::TetAnswer answer;
  answer.V = Eigen::Map<const mesh::Positions>(out.pointlist, out.numberofpoints, 3);
  answer.T = Eigen::Map<const mesh::Tets>(out.tetrahedronlist, out.numberoftetrahedra, 4);
  answer.F = Eigen::Map<const mesh::Triangles>(out.trifacelist, out.numberoftrifaces, 3);
  for (int f = 0; f < out.numberoftrifaces; ++f) {
    const int marker = out.trifacemarkerlist[f];
    answer.tag.push_back(marker > 0 && marker <= request->surface.F.rows()
                             ? request->surface.tag[static_cast<std::size_t>(marker - 1)]
                             : -1);
  }
  return writeFileWhole(arguments[1], domain::encodeTetAnswer(answer));
}

}  // namespace ecorche::worker
