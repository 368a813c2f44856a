#pragma once

#include <ecorche/domain/build_domain.h>
#include <ecorche/tissue/tissue.h>

#include <vector>

namespace ecorche::engine {

/// A guess at the lengths that muscles want, before anything is solved: fields of neighbours meet
/// about midway, so a muscle's radius is half the distance from its curve to the next curve of
/// another tissue, and no more than what lies between the curve and the skin. Eight tets across it.
///
/// @param tissues  muscles and fillers; fillers want nothing, their shape is nobody's concern
/// @param skin     of the uncut body; its vertices stand for it
[[nodiscard]] std::vector<domain::WantedLength> lengthsAlongCurves(
    const std::vector<tissue::CurveTissue>& tissues, const mesh::SurfaceMesh& skin);

/// Where curves of different tissues run so close together that muscles are no guide: eight tets
/// from one to the other, before lengths are scaled to the budget.
[[nodiscard]] std::vector<domain::WantedLength> lengthsBetweenCurves(
    const std::vector<tissue::CurveTissue>& tissues, double diagonal);

}  // namespace ecorche::engine
