#pragma once

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace ecorche {

/// Says that what this thread did so far comes before whatever follows takeOver of the same place
/// on another, for ThreadSanitizer, which does not see into libraries that were not compiled for it
/// (TBB's). Nothing elsewhere: it orders nothing that is not ordered already.
inline void handOver([[maybe_unused]] const void* place) {
#ifdef __SANITIZE_THREAD__
  __tsan_release(const_cast<void*>(place));
#endif
}
inline void takeOver([[maybe_unused]] const void* place) {
#ifdef __SANITIZE_THREAD__
  __tsan_acquire(const_cast<void*>(place));
#endif
}

}  // namespace ecorche
