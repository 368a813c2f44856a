#pragma once

#include <spdlog/spdlog.h>

namespace ecorche {

/// Our log: standard error, so that standard output stays free for tables and JSON.
/// Level from ECORCHE_LOG (trace, debug, info, warn, error, off); warn where that is unset.
[[nodiscard]] spdlog::logger& logger();

}  // namespace ecorche
