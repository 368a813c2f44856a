#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/solve_tissues.h>
#include <ecorche/tissue/tissue_solver.h>

namespace ecorche::tissue {

Result<SolvedTissues> solveTissues(const domain::Domain& domain,
                                   const std::vector<CurveTissue>& tissues,
                                   const TissueOptions& options, RunContext& run) {
  auto cores = traceCurves(domain, tissues, options, run);
  if (!cores) return passOn(cores);
  auto fields = solveTissueFields(domain, *cores, tissues, options, run);
  if (!fields) return passOn(fields);
  return SolvedTissues{std::move(*cores), std::move(*fields)};
}

}  // namespace ecorche::tissue
