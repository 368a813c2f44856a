#pragma once

#include <ecorche/domain/surface_step.h>
#include <ecorche/domain/tagged_surface.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace ecorche::domain {

/// Points of a surface that is being replaced face by face, each carried along by the face that
/// lies nearest to it, so that a step which would take the new surface away from them is seen
/// before it is done [after Ciampalini, Cignoni, Montani & Scopigno 1997].
///
/// Only faces that take part in a step are asked: two walls of a narrow gap do not speak for each
/// other.
class CarriedSamples {
 public:
  /// Corners of the surface, middles of its sides and points between; face f carries those of
  /// row f.
  /// @param spacing  no two neighbours farther apart [m, > 0]
  /// @param limit    how far each may come to lie from its face, by its place [m]
  CarriedSamples(const TaggedSurface& surface, double spacing,
                 const std::function<double(const mesh::Vector3&)>& limit);

  /// Whether everything that the faces before carry finds a nearest face after that is no farther
  /// than its limit, or than it lies already.
  [[nodiscard]] bool allows(const SurfaceStep& step);
  /// Hands over as allows(), the call before this one and with the same step, has found.
  void follow(const SurfaceStep& step);
  /// The same without a limit, and without asking: for steps that have to be.
  void followAnyway(const SurfaceStep& step);

 private:
  struct Sample {
    mesh::Vector3 at;
    double limit2 = 0.0;     // [m²]
    double distance2 = 0.0;  // of the face that carries it [m²]
  };
  struct Move {
    std::int32_t sample;
    std::int32_t face;
    double distance2;
  };
  bool nearest(const SurfaceStep& step, bool limited);
  std::vector<std::int32_t>& of(std::int32_t face);

  std::vector<Sample> samples_;
  std::vector<std::vector<std::int32_t>> ofFace_;
  std::vector<Move> moves_;  // of the step that allows() has looked at
};

}  // namespace ecorche::domain
