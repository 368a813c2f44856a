#include <ecorche/core/contract.h>

namespace ecorche::detail {

void contractBroken(const char* file, int line, const std::string& what) {
  throw ContractError(fmt::format("{}:{}: contract broken: {}", file, line, what));
}

}  // namespace ecorche::detail
