#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ecorche::model {

/// What a length in a project file or in a mesh file is counted in. Inside the program everything
/// is metres.
enum class Unit { Metre, Decimetre, Centimetre, Millimetre, Inch };

[[nodiscard]] double metresPer(Unit unit);
/// "m", "dm", "cm", "mm" or "in".
[[nodiscard]] std::string_view symbol(Unit unit);
[[nodiscard]] std::optional<Unit> unitFrom(std::string_view symbol);

/// Shortest decimal text that reads back as exactly this double. JSON syntax. @param value finite
[[nodiscard]] std::string numberText(double value);
/// The whole text as a double; nothing where it is not one finite number. Underflow gives zero.
[[nodiscard]] std::optional<double> numberFrom(std::string_view text);

/// A length for a file in `unit`, and back. The decimal units only shift the exponent of the
/// decimal text, so that writing and reading gives the same metres to the last bit; in inches that
/// holds from the second writing on.
[[nodiscard]] std::string lengthText(double metres, Unit unit);
[[nodiscard]] std::optional<double> lengthFrom(std::string_view text, Unit unit);

/// An angle in degrees for a file, radians inside; the same holds as for inches.
[[nodiscard]] std::string angleTextDeg(double radians);
[[nodiscard]] std::optional<double> angleFromDeg(std::string_view text);

}  // namespace ecorche::model
