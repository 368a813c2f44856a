#pragma once

#include <ecorche/engine/live_engine.h>
#include <ecorche/render/scene.h>
#include <ecorche/studio/display.h>
#include <ecorche/studio/kept_surfaces.h>
#include <ecorche/studio/session.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace ecorche::studio {

/// Colours of the view around the model.
struct SceneColours {
  render::Rgba background{0.05f, 0.052f, 0.058f, 1.0f};
  render::Rgba accent{1.0f, 0.42f, 0.06f, 1.0f};  ///< the selected curve
  render::Rgba curve{0.85f, 0.85f, 0.82f, 1.0f};  ///< the others
};

/// What a session has to show, made into a picture's scene. Keeps what has not changed, so that
/// nothing is prepared for drawing twice.
class SceneBuilder {
 public:
  struct Input {
    const model::Project& project;
    std::shared_ptr<const engine::LiveMeshes> meshes;    ///< may be null
    std::shared_ptr<const domain::DomainBuild> domain;   ///< may be null
    std::shared_ptr<const engine::LiveTissues> tissues;  ///< may be null
    Session::FieldEdits edits;                           ///< of the tissues' fields
    std::shared_ptr<const mesh::Directions> flow;        ///< of fibres; null: none to be shown
    const Display& display;
    const Selection& selection;
    Selection hovered;                               ///< what the hand would take hold of
    std::vector<mesh::Vector3> stroke;               ///< being drawn
    std::vector<mesh::Vector3> marks;                ///< places to show: where a stroke would begin
    std::vector<std::vector<mesh::Vector3>> guides;  ///< lines of handles
    /// Pixels of this picture over those of the window: what is so many pixels wide is that there.
    double pixelScale = 1.0;
  };
  [[nodiscard]] render::Scene build(const Input& input, const SceneColours& colours);

  /// Colour of every tissue by its place in the project; grey while it has none.
  [[nodiscard]] const std::vector<render::Rgba>& tissueColours(
      const model::Project& project, const std::shared_ptr<const engine::LiveTissues>& tissues,
      render::Palette palette);

 private:
  // Of what the surfaces at hand are
  std::shared_ptr<const engine::LiveMeshes> meshesSeen_;
  std::shared_ptr<const domain::DomainBuild> domainSeen_;
  std::vector<model::CutPlane> planesSeen_;
  KeptSurfaces kept_;

  // Curves, and the lines made of them
  struct CurvesShown {
    std::vector<std::vector<mesh::Vector3>> others, own;  // their control points
    double spacing = 0.0;                                 // [m]
    double pixelScale = 1.0;                              // of their width
    render::Rgba colour{}, accent{};
    bool operator==(const CurvesShown&) const = default;
  };
  CurvesShown curvesShown_;
  std::vector<render::LineItem> lines_;

  // What colours were last chosen for
  std::shared_ptr<const engine::LiveTissues> colouredFor_;
  std::vector<std::string> colouredNames_;
  std::vector<std::optional<model::Colour>> colouredFixed_;
  render::Palette colouredPalette_ = render::Palette::Anatomical;
  std::vector<render::Rgba> colours_;

  void takeMeshes(const Input& input);
  void addVolume(const Input& input, render::Scene& scene);
  void addLines(const Input& input, const SceneColours& colours, render::Scene& scene);
  static void addPoints(const Input& input, const SceneColours& colours, render::Scene& scene);
};

}  // namespace ecorche::studio
