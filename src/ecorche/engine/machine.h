#pragma once

#include <ecorche/exchange/report.h>

namespace ecorche::engine {

/// What figures of time depend on: processor, cores, threads in use, BLAS.
[[nodiscard]] exchange::MachineFigures thisMachine();

}  // namespace ecorche::engine
