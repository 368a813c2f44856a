#include <ecorche/exchange/file_names.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <string_view>

namespace ecorche::exchange {

namespace {

std::string lowered(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool isReserved(const std::string& name) {
  static constexpr std::array<std::string_view, 4> kDevices{"con", "prn", "aux", "nul"};
  const std::string stem = lowered(name.substr(0, name.find('.')));
  if (std::ranges::find(kDevices, stem) != kDevices.end()) return true;
  return stem.size() == 4 && (stem.starts_with("com") || stem.starts_with("lpt")) &&
         std::isdigit(static_cast<unsigned char>(stem[3])) != 0;
}

std::string sanitised(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte < 128 && (std::isalnum(byte) != 0 || c == '-' || c == '_' || c == '.');
    // One underscore for a character of several bytes
    const bool continued = (byte & 0xC0) == 0x80;
    if (plain) {
      out += c;
    } else if (!continued) {
      out += '_';
    }
  }
  if (out.size() > 100) out.resize(100);
  while (!out.empty() && out.back() == '.') out.pop_back();
  if (out.empty() || out.front() == '.' || out.front() == '-' || isReserved(out)) out = "_" + out;
  return out;
}

}  // namespace

std::vector<std::string> fileNames(const std::vector<std::string>& names) {
  std::set<std::string> taken;
  std::vector<std::string> out;
  for (const std::string& name : names) {
    const std::string base = sanitised(name);
    std::string candidate = base;
    for (int k = 2; !taken.insert(lowered(candidate)).second; ++k)
      candidate = fmt::format("{}-{}", base, k);
    out.push_back(std::move(candidate));
  }
  return out;
}

}  // namespace ecorche::exchange
