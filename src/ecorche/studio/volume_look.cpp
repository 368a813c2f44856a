#include <ecorche/engine/live_parts.h>
#include <ecorche/render/anatomy_scene.h>
#include <ecorche/studio/volume_look.h>

namespace ecorche::studio {

namespace {

constexpr float kXray = 0.12f;  // opacity of what one looks through

// Of its curves' control points
mesh::Vector3 middleOf(const model::Tissue& tissue) {
  mesh::Vector3 sum = mesh::Vector3::Zero();
  double count = 0.0;
  for (const model::Curve& curve : tissue.curves) {
    for (const auto& point : curve.points) {
      sum += point.at;
      count += 1.0;
    }
  }
  return count > 0.0 ? mesh::Vector3(sum / count) : sum;
}

}  // namespace

render::VolumeItem volumeOf(const model::Project& project, const engine::LiveTissues& tissues,
                            const Display& display, const std::vector<render::Rgba>& colours) {
  render::VolumeItem out;
  out.geometry = tissues.geometry;
  out.fields = {tissues.fields, &tissues.fields->fields().values};
  out.fatIsCandidate = tissues.fields->fields().fatIsCandidate;
  out.tissues.resize(tissues.slotOf.size() + 1);
  out.tissues[0] = {.colour = render::tint::fat(), .visible = false, .inCut = true};
  const mesh::Box& box = tissues.geometry->box();
  const mesh::Vector3 middle = 0.5 * (box.lo + box.hi);
  const auto places = engine::liveTissuePlaces(project);
  for (std::size_t i = 0; i < tissues.slotOf.size(); ++i) {
    render::VolumeTissue& look = out.tissues[i + 1];
    look.visible = false;
    if (tissues.slotOf[i] >= places.size()) continue;
    const model::Tissue& tissue = project.tissues[places[tissues.slotOf[i]]];
    if (places[tissues.slotOf[i]] < colours.size())
      look.colour = colours[places[tissues.slotOf[i]]];
    const bool peeled = display.peelAbove && tissue.layer && *tissue.layer > *display.peelAbove;
    look.visible = display.showsTissue(tissue.name) && !peeled;
    if (display.xray && *display.xray != tissue.name) look.opacity = kXray;
    if (display.explode > 0.0) look.shift = display.explode * (middleOf(tissue) - middle);
  }
  return out;
}

}  // namespace ecorche::studio
