#include <ecorche/studio/examples.h>

#include <QCoreApplication>
#include <string>
#include <vector>

namespace ecorche::studio {

Result<std::filesystem::path> exampleFile(const std::filesystem::path& name) {
  const std::filesystem::path here = QCoreApplication::applicationDirPath().toStdString();
  const std::vector<std::filesystem::path> places = {here / "../share/ecorche/examples",
                                                     ECORCHE_EXAMPLES};
  std::string looked;
  for (const auto& place : places) {
    const auto file = (place / name).lexically_normal();
    if (std::filesystem::exists(file)) return file;
    looked += (looked.empty() ? "" : ", ") + file.string();
  }
  return fail(ErrorCode::FileMissing,
              "the example \"" + name.string() + "\" is not there; looked for " + looked);
}

}  // namespace ecorche::studio
