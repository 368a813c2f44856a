#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/mesh/mending.h>
#include <ecorche/mesh/spline.h>
#include <ecorche/mesh/types.h>
#include <ecorche/model/units.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ecorche::model {

using mesh::Vector3;

/// A mesh that the project names but does not hold.
struct MeshRef {
  std::string file;          ///< as written, '/' between folders, relative to Project::folder
  std::string part;          ///< one named part of the file; empty: all of it
  std::optional<Unit> unit;  ///< of the mesh's coordinates. Unset: Project::unit
  mesh::Mending repair = mesh::Mending::None;  ///< asked for, before anything else; not of patches
  bool operator==(const MeshRef&) const = default;
};

struct Bone {
  std::string name;
  MeshRef mesh;
  bool operator==(const Bone&) const = default;
};

/// Keeps the half of everything that the normal points into.
struct CutPlane {
  enum class Kind { Symmetry, Region };
  std::string name;
  Kind kind = Kind::Symmetry;
  Vector3 point = Vector3::Zero();    // [m]
  Vector3 normal = Vector3::UnitY();  // unit
  bool operator==(const CutPlane&) const = default;
};

/// What something sits on. `name` is empty where it is free.
struct Support {
  enum class On { Free, Bone, Plane, Tissue };
  On on = On::Free;
  std::string name;
  bool operator==(const Support&) const = default;
};

struct ControlPoint {
  Vector3 at = Vector3::Zero();  // [m]
  double tissue = 1.0;           ///< tissue value: larger is thicker [unitless, > 0]
  bool operator==(const ControlPoint&) const = default;
};

/// One head of a muscle: a centripetal Catmull–Rom spline from origin to insertion.
struct Curve {
  std::string name;                  ///< "long head"; may be empty
  std::vector<ControlPoint> points;  ///< two or more, neighbours apart
  Support start, end;
  bool operator==(const Curve&) const = default;
};

/// Where a muscle meets a bone, as it is known from elsewhere: a point, a patch of surface, or
/// both.
struct Attachment {
  enum class Role { Unknown, Origin, Insertion };
  Role role = Role::Unknown;
  Support support;
  std::optional<Vector3> at;     // centre [m]
  std::optional<MeshRef> patch;  ///< an open piece of surface
  bool operator==(const Attachment&) const = default;
};

/// As tissue::Anisotropy; kept here because the model knows no solver.
struct Anisotropy {
  double lambda2 = 1.0;   ///< [unitless, > 0]
  double lambda3 = 1.0;   ///< [unitless, > 0]
  double rotation = 0.0;  ///< about the tangent at the first point [rad]
  bool operator==(const Anisotropy&) const = default;
};

enum class Side { Unknown, Left, Right, Median };

struct Colour {
  std::uint8_t red = 0, green = 0, blue = 0;  ///< sRGB
  bool operator==(const Colour&) const = default;
};

struct Tissue {
  /// Muscles and fillers grow from curves, obstacles and cavities are meshes. Fat needs no entry;
  /// one that is there gives it a colour.
  enum class Kind { Muscle, Filler, Obstacle, Cavity, Fat };
  std::string name;
  Kind kind = Kind::Muscle;
  Side side = Side::Unknown;
  std::string group;         ///< "quadriceps"; may be empty
  std::optional<int> layer;  ///< 0 is deepest
  std::optional<Colour> colour;
  bool isProtected = false;  ///< commands that would change its body are refused
  bool keepsTwin = false;    ///< its mirror image follows when it is edited in the window

  std::vector<Curve> curves;         ///< muscles and fillers: at least one in a complete project
  std::optional<double> coreRadius;  ///< [m]. Unset: Settings::coreRadius
  Anisotropy anisotropy;
  std::vector<Attachment> attachments;

  std::optional<MeshRef> mesh;  ///< obstacles and cavities: always; others: never

  [[nodiscard]] bool hasCurves() const { return kind == Kind::Muscle || kind == Kind::Filler; }
  bool operator==(const Tissue&) const = default;
};

struct Settings {
  double fat = 0.3;                  ///< value of the fat field on skin. 0: no fat [unitless]
  std::optional<double> coreRadius;  ///< [m]. Unset: 0.1 % of the diagonal of the uncut skin
  std::optional<double> alpha;  ///< the paper's row weight instead of a core radius, for comparison
  std::optional<std::int64_t>
      tets;  ///< how many to aim at. Unset, and edgeLength too: the program's choice
  std::optional<double> edgeLength;  ///< of tets, instead of a count [m]
  double surfaceTolerance =
      0.001;  ///< how far resampled skin and bones may stray [share of the skin's diagonal]
  bool operator==(const Settings&) const = default;
};

/// Everything that a user says about an anatomy. A value: copy it, compare it, hand it to a thread.
struct Project {
  std::filesystem::path
      folder;  ///< where relative paths start: the project file's folder. Not written.

  std::string name;         ///< may be empty
  Unit unit = Unit::Metre;  ///< of the project file and of meshes that do not say otherwise
  MeshRef skin;
  std::vector<Bone> bones;
  std::vector<CutPlane> cutPlanes;
  Settings settings;
  std::vector<Tissue> tissues;
  bool operator==(const Project&) const = default;
};

/// Where the mesh lies on this disk.
[[nodiscard]] std::filesystem::path meshPath(const Project& project, const MeshRef& mesh);
[[nodiscard]] double metresPerUnit(const Project& project, const MeshRef& mesh);

/// How a mesh file is written in a project in `folder`: relative to it, '/' between folders.
[[nodiscard]] std::string pathFrom(const std::filesystem::path& folder,
                                   const std::filesystem::path& file);
/// The same mesh named from another folder.
[[nodiscard]] MeshRef movedTo(MeshRef mesh, const std::filesystem::path& from,
                              const std::filesystem::path& to);
/// The same project for a file in another folder: relative paths lead to the same meshes as before.
[[nodiscard]] Project movedTo(Project project, const std::filesystem::path& folder);

/// Place in the list; nothing where no such name is.
[[nodiscard]] std::optional<std::size_t> findBone(const Project& project, std::string_view name);
[[nodiscard]] std::optional<std::size_t> findCutPlane(const Project& project,
                                                      std::string_view name);
[[nodiscard]] std::optional<std::size_t> findTissue(const Project& project, std::string_view name);

/// Id of a tissue in every file we write: 1 for fat, from 2 on for muscles and fillers in list
/// order, kNoTissue for obstacles and cavities.
[[nodiscard]] TissueId tissueId(const Project& project, std::size_t tissue);

/// @pre findFault (project_check.h) has nothing to say about the curve
[[nodiscard]] mesh::Spline splineOf(const Curve& curve);
[[nodiscard]] std::vector<double> tissueValuesOf(const Curve& curve);

/// How a curve is called in messages: `"biceps", curve 2 (short head)`.
[[nodiscard]] std::string curveLabel(const Tissue& tissue, std::size_t curve);

/// The words of the project file: "muscle", "symmetry", "bone", "origin", "left"; and back.
[[nodiscard]] std::string_view word(Tissue::Kind kind);
[[nodiscard]] std::string_view word(CutPlane::Kind kind);
[[nodiscard]] std::string_view word(Support::On on);
[[nodiscard]] std::string_view word(Attachment::Role role);  ///< empty: unknown
[[nodiscard]] std::string_view word(Side side);              ///< empty: unknown
template <class Enum>
[[nodiscard]] std::optional<Enum> fromWord(std::string_view word);
/// All words of an enum for messages: "muscle, filler, obstacle, cavity or fat".
template <class Enum>
[[nodiscard]] std::string allWords();

/// "#c0504d", and back; nothing where the text is no colour.
[[nodiscard]] std::string colourText(Colour colour);
[[nodiscard]] std::optional<Colour> colourFrom(std::string_view text);

}  // namespace ecorche::model
