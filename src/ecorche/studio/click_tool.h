#pragma once

#include <ecorche/studio/new_muscle.h>
#include <ecorche/studio/tool.h>

namespace ecorche::studio {

/// A muscle by clicks: on one bone, then on another; with Shift, or beside bones, the clicks
/// between are places that the curve passes.
class ClickTool : public Tool {
  Q_OBJECT

 public:
  explicit ClickTool(View view) : Tool(view) {}

  void hover(const Touch& touch) override;
  bool press(const Touch& touch) override;
  bool cancel() override;
  [[nodiscard]] QString hint() const override;

 private:
  std::optional<CurveTip> from_;
  std::vector<Eigen::Vector2d> pixels_;  // of the clicks so far, the first on bone
  QString over_;

  [[nodiscard]] std::optional<CurveTip> tipAt(const Eigen::Vector2d& pixel) const;
  [[nodiscard]] std::vector<authoring::SightRay> sightsTo(const Eigen::Vector2d& pixel) const;
  void showPath(const Touch& touch, const std::optional<CurveTip>& tip);
};

}  // namespace ecorche::studio
