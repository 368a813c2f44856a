#include <ecorche/render/peeling.h>

#include <catch2/catch.hpp>

#include "render/volumes.h"
#include "support/generated_domain.h"

using namespace ecorche;

TEST_CASE("muscles are peeled from outside in") {
  // A box like an onion: tissue 2 around 3 around 4, and 5 a plate on one side, under nothing
  const auto domain =
      test::boxDomain({.cells = {16, 16, 16}, .lo = {-1.0, -1.0, -1.0}, .hi = {1.0, 1.0, 1.0}});
  tissue::FieldMatrix f(domain.mesh.V.rows(), 5);
  for (Eigen::Index v = 0; v < f.rows(); ++v) {
    const double r = domain.mesh.V.row(v).cwiseAbs().maxCoeff();
    f.row(v) << 0.0, 1.0, 2.6 - 2.0 * r, 3.9 - 5.0 * r, 10.0 * (domain.mesh.V(v, 0) - 0.85);
  }
  const auto item = test::volumeItem(domain, f, true);
  CHECK(render::layersFromOutside(item) == std::vector<int>{-1, 0, 1, 2, 0});
  // Without the outermost the next one takes its place
  CHECK(render::layersFromOutside(item, {false, true, false, false, false}) ==
        std::vector<int>{-1, -1, 0, 1, 0});
}
