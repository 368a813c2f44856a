#pragma once

#include <ecorche/tissue/value_fields.h>

#include <vector>

namespace ecorche::tissue {

/// Volume of a tissue as its fields have it [m³].
[[nodiscard]] double volumeOf(const ValueFields& fields, std::size_t tissue);

/// Values that give a tissue a volume: what it has now times one factor, so that it keeps its
/// shape.
///
/// @param fields  edited while looking, and put back
/// @param volume  [m³, > 0]
/// @return  a list per curve, a value per control point; the volume they give is within a
/// thousandth of what was asked for
/// @errors  ValueOutOfRange (the space between its neighbours, skin and bones does not hold so
/// much, or its curve alone takes more; with the volume that is possible), those of
/// ValueFields::setValues
[[nodiscard]] Result<std::vector<std::vector<double>>> valuesForVolume(ValueFields& fields,
                                                                       std::size_t tissue,
                                                                       double volume,
                                                                       RunContext& run);

}  // namespace ecorche::tissue
