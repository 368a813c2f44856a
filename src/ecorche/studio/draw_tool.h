#pragma once

#include <ecorche/studio/new_muscle.h>
#include <ecorche/studio/tool.h>

namespace ecorche::studio {

/// A muscle by a stroke from bone to bone: the ends lie where the stroke begins and ends over bone,
/// what is between gets its depth from them and from the flesh along the lines of sight
/// (authoring/stroke_depth.h) and keeps clear of bones and skin.
class DrawTool : public Tool {
  Q_OBJECT

 public:
  explicit DrawTool(View view) : Tool(view) {}

  void hover(const Touch& touch) override;
  bool press(const Touch& touch) override;
  void drag(const Touch& touch) override;
  void release(const Touch& touch) override;
  bool cancel() override;
  [[nodiscard]] QString hint() const override;

  /// The next stroke becomes another head of the selected muscle.
  void setAddHead(bool on) { addHead_ = on; }
  [[nodiscard]] bool addsHead() const { return addHead_; }
  /// Ends may also sit on cut planes, or on other muscles' curves.
  void setEndsOnPlanes(bool on) { onPlanes_ = on; }
  void setEndsOnMuscles(bool on) { onMuscles_ = on; }

 private:
  struct Sample {
    Eigen::Vector2d pixel;
    double pressure = 0.0;
  };
  bool addHead_ = false;
  bool onPlanes_ = false;
  bool onMuscles_ = false;
  std::optional<CurveTip> from_;
  std::vector<Sample> samples_;
  bool pen_ = false;
  QString over_;  // what the hand is over that a muscle may sit on

  [[nodiscard]] std::optional<CurveTip> tipAt(const Eigen::Vector2d& pixel) const;
  [[nodiscard]] std::vector<authoring::SightRay> sights() const;
  void draw(const CurveTip& to);
};

}  // namespace ecorche::studio
