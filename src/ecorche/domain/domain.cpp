#include <ecorche/domain/domain.h>

#include <algorithm>

namespace ecorche::domain {

std::int64_t Domain::freeVertexCount() const { return std::ranges::count(onSkin, std::uint8_t{0}); }

}  // namespace ecorche::domain
