// libFuzzer's way in; ECORCHE_FUZZ_TARGET names the target that this program runs, of
// ECORCHE_FUZZ_TABLE.

#include <cstddef>
#include <cstdint>

#include "fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto run = [] {
    for (const auto& target : ecorche::test::ECORCHE_FUZZ_TABLE()) {
      if (target.name == ECORCHE_FUZZ_TARGET) return target.run;
    }
    __builtin_trap();
  }();
  run({reinterpret_cast<const char*>(data), size});
  return 0;
}
