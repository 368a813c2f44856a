#pragma once

#include <ecorche/studio/tool.h>

#include <memory>

namespace ecorche::studio {

class SpreadGizmo;
enum class SpreadPart : int;

/// Takes hold of muscles, curves and control points, and moves points: in the plane of the view,
/// with Shift along the line of sight, with Ctrl onto what lies near. Ends glide over bone.
class SelectTool : public Tool {
  Q_OBJECT

 public:
  explicit SelectTool(View view) : Tool(view) {}

  void hover(const Touch& touch) override;
  bool press(const Touch& touch) override;
  void drag(const Touch& touch) override;
  void release(const Touch& touch) override;
  void doubleClick(const Touch& touch) override;
  bool cancel() override;
  [[nodiscard]] QString hint() const override;

 private:
  struct Held {
    Selection what;
    mesh::Vector3 at = mesh::Vector3::Zero();         // where the point was [m]
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // where the hand took it
    bool moved = false;
    std::shared_ptr<const SpreadGizmo> gizmo;  // as it was when the hand took it
    SpreadPart part{};
  };
  std::optional<Held> held_;

  [[nodiscard]] std::vector<model::Command> moveTo(const Touch& touch) const;
  [[nodiscard]] std::shared_ptr<const SpreadGizmo> gizmo() const;
};

}  // namespace ecorche::studio
