#pragma once

#include <ecorche/engine/live_engine.h>
#include <ecorche/render/scene.h>
#include <ecorche/studio/display.h>

#include <vector>

namespace ecorche::studio {

/// The tissues as they are to be drawn, for pictures and for picking; entry i + 1 is that of slot
/// i.
/// @param colours  by place in the project
[[nodiscard]] render::VolumeItem volumeOf(const model::Project& project,
                                          const engine::LiveTissues& tissues,
                                          const Display& display,
                                          const std::vector<render::Rgba>& colours);

}  // namespace ecorche::studio
