#include <ecorche/core/contract.h>
#include <ecorche/model/units.h>

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

namespace ecorche::model {

namespace {

struct UnitRow {
  Unit unit;
  std::string_view symbol;
  double metres;
  int decimals;  // power of ten, where it is one
};
constexpr std::array<UnitRow, 5> kUnits = {{{Unit::Metre, "m", 1.0, 0},
                                            {Unit::Decimetre, "dm", 0.1, -1},
                                            {Unit::Centimetre, "cm", 0.01, -2},
                                            {Unit::Millimetre, "mm", 0.001, -3},
                                            {Unit::Inch, "in", 0.0254, 0}}};

const UnitRow& row(Unit unit) { return kUnits[static_cast<std::size_t>(unit)]; }

// Shortest digits of a double, times ten to the power of `shift`, laid out as people write numbers.
std::string shiftedText(double value, int shift) {
  EC_REQUIRE(std::isfinite(value));
  if (value == 0.0) return "0";
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), std::abs(value),
                                 std::chars_format::scientific);
  const std::string_view text(buffer.data(), static_cast<std::size_t>(end.ptr - buffer.data()));
  const std::size_t e = text.find('e');
  std::string digits;
  for (char c : text.substr(0, e)) {
    if (c != '.') digits += c;
  }
  int exponent = std::stoi(std::string(text.substr(e + 1))) + shift;

  const int count = static_cast<int>(digits.size());
  std::string out = value < 0.0 ? "-" : "";
  if (exponent < -5 || exponent > 15) {  // 1.25e-07
    out += digits.substr(0, 1);
    if (count > 1) out += "." + digits.substr(1);
    return out + "e" + std::to_string(exponent);
  }
  if (exponent < 0)
    return out + "0." + std::string(static_cast<std::size_t>(-exponent - 1), '0') + digits;
  if (count <= exponent + 1) {
    return out + digits + std::string(static_cast<std::size_t>(exponent + 1 - count), '0');
  }
  return out + digits.substr(0, static_cast<std::size_t>(exponent) + 1) + "." +
         digits.substr(static_cast<std::size_t>(exponent) + 1);
}

// The shortest x with scale(x) == value, where there is one; else the nearest double.
template <class Scale>
std::string preimageText(double value, double guess, const Scale& scale) {
  if (value == 0.0) return "0";
  for (int digits = 1; digits <= 17; ++digits) {
    std::array<char, 40> buffer{};
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), guess,
                                   std::chars_format::scientific, digits - 1);
    double rounded = 0.0;
    std::from_chars(buffer.data(), end.ptr, rounded);
    if (scale(rounded) == value) return numberText(rounded);
  }
  for (double x : {std::nextafter(guess, -HUGE_VAL), std::nextafter(guess, HUGE_VAL)}) {
    if (scale(x) == value) return numberText(x);
  }
  return numberText(guess);
}

double radians(double degrees) { return degrees * (std::numbers::pi / 180.0); }

}  // namespace

double metresPer(Unit unit) { return row(unit).metres; }
std::string_view symbol(Unit unit) { return row(unit).symbol; }

std::optional<Unit> unitFrom(std::string_view text) {
  for (const UnitRow& known : kUnits) {
    if (known.symbol == text) return known.unit;
  }
  return std::nullopt;
}

std::string numberText(double value) { return shiftedText(value, 0); }

std::optional<double> numberFrom(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || end != text.data() + text.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    // Too large or too small? The exponent's sign tells
    const std::size_t e = text.find_first_of("eE");
    const bool tiny =
        e == std::string_view::npos ? text.find("0.") < 2 : text.substr(e + 1).starts_with('-');
    return tiny ? std::optional(0.0) : std::nullopt;
  }
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::string lengthText(double metres, Unit unit) {
  if (unit == Unit::Inch) {
    return preimageText(metres, metres / metresPer(unit), [](double x) { return x * 0.0254; });
  }
  return shiftedText(metres, -row(unit).decimals);
}

std::optional<double> lengthFrom(std::string_view text, Unit unit) {
  const std::optional<double> plain = numberFrom(text);
  if (!plain || *plain == 0.0 || unit == Unit::Metre) return plain;
  if (unit == Unit::Inch) {
    const double metres = *plain * 0.0254;
    return std::isfinite(metres) ? std::optional(metres) : std::nullopt;
  }
  const std::size_t e = text.find_first_of("eE");
  int exponent = 0;
  if (e != std::string_view::npos) {
    const std::size_t first = e + (text[e + 1] == '+' ? 2 : 1);
    std::from_chars(text.data() + first, text.data() + text.size(), exponent);
  }
  return numberFrom(std::string(text.substr(0, e)) + "e" +
                    std::to_string(exponent + row(unit).decimals));
}

std::string angleTextDeg(double angle) {
  return preimageText(angle, angle * (180.0 / std::numbers::pi), radians);
}

std::optional<double> angleFromDeg(std::string_view text) {
  const std::optional<double> degrees = numberFrom(text);
  return degrees ? std::optional(radians(*degrees)) : std::nullopt;
}

}  // namespace ecorche::model
