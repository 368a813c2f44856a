#pragma once

#include <ecorche/domain/tagged_surface.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
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
  /// A face after a step, with the corners that it will have.
  struct NewFace {
    std::int32_t face = 0;
    std::array<mesh::Vector3, 3> corner;
  };

  /// Corners of the surface, middles of its sides and points between; face f carries those of
  /// row f.
  /// @param spacing  no two neighbours farther apart [m, > 0]
  /// @param limit    how far each may come to lie from its face, by its place [m]
  CarriedSamples(const TaggedSurface& surface, double spacing,
                 const std::function<double(const mesh::Vector3&)>& limit);

  /// Hands everything that the faces of `before` carry to the nearest of `after`, where none comes
  /// to lie farther than its limit, or farther than it lies already; otherwise changes nothing.
  /// Faces may stand in both lists.
  /// @return  whether it was done
  bool hand(std::span<const std::int32_t> before, std::span<const NewFace> after);

  /// The same without a limit: for steps that have to be.
  void handAnyway(std::span<const std::int32_t> before, std::span<const NewFace> after);

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
  bool nearest(std::span<const std::int32_t> before, std::span<const NewFace> after, bool limited);
  void apply(std::span<const std::int32_t> before, std::span<const NewFace> after);
  std::vector<std::int32_t>& of(std::int32_t face);

  std::vector<Sample> samples_;
  std::vector<std::vector<std::int32_t>> ofFace_;
  std::vector<Move> moves_;  // of the step that is being looked at
};

}  // namespace ecorche::domain
