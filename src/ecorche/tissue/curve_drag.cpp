#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/curve_drag.h>
#include <ecorche/tissue/own_drag.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace ecorche::tissue {

namespace {

TissueId idOf(std::size_t tissue) {
  return TissueId(kFirstMuscle.value + static_cast<std::int64_t>(tissue));
}

// Equations of an anisotropic tissue whose curves stay, got ready when a moved one comes near its
// field
struct Own {
  std::int32_t field = 0;
  std::shared_ptr<const OwnGround> ground;
  std::optional<DragSystem> system;
};

}  // namespace

struct CurveDrag::Impl {
  const domain::Domain& domain;
  const CurveWalker& walker;
  std::vector<CurveTissue> tissues;
  TissueOptions options;
  std::vector<CurveRef> moved;
  RawRow raw;
  DragOptions how;
  double maxValue = 0.0;

  std::shared_ptr<const DragGround> ground;
  PiecedRows old;
  std::vector<std::int32_t> fields;  // of the shared equations
  std::vector<OwnDrag> ownDrags;     // whose spreads are their last columns
  std::optional<DragSystem> shared;
  std::vector<Own> own;
  std::vector<std::int32_t> frozen;
  std::vector<std::int32_t> place;  // #V, row of the frame in the making; −1

  Impl(const domain::Domain& d, const CurveWalker& w) : domain(d), walker(w) {}

  [[nodiscard]] DragSystem::Targets sharedTargets(const PiecedRows& rows) const;
  [[nodiscard]] DragSystem::Part moveOwnDrag(OwnDrag& it, std::size_t which, const PiecedRows& now,
                                             const std::vector<DragSystem::Part>& shared) const;
  [[nodiscard]] bool isNear(const Own& it, const PiecedRows& rows) const;
  std::vector<DragSystem::Part> moveOwn(Own& it, const PiecedRows& now);
};

CurveDrag::~CurveDrag() = default;
CurveDrag::CurveDrag(CurveDrag&&) noexcept = default;
CurveDrag& CurveDrag::operator=(CurveDrag&&) noexcept = default;
const std::vector<CurveRef>& CurveDrag::moved() const { return impl_->moved; }
const std::vector<std::int32_t>& CurveDrag::frozen() const { return impl_->frozen; }

CurveDrag::CurveDrag(const domain::Domain& domain, DragGrounds grounds, const CurveWalker& walker,
                     const CoreSamples& cores, const std::vector<CurveTissue>& tissues,
                     const TissueOptions& options, std::vector<CurveRef> moved, RawRow raw,
                     DragOptions how)
    : impl_(std::make_unique<Impl>(domain, walker)) {
  Impl& I = *impl_;
  I.tissues = tissues;
  I.options = options;
  I.moved = std::move(moved);
  I.raw = std::move(raw);
  I.how = how;
  I.maxValue = options.fat;
  I.ground = std::move(grounds.shared);
  EC_REQUIRE(!I.moved.empty());
  I.fields = {0};
  for (std::size_t t = 0; t < tissues.size(); ++t) {
    const auto field = static_cast<std::int32_t>(t) + 1;
    if (tissues[t].anisotropy.isIsotropic()) {
      I.fields.push_back(field);
    } else if (std::ranges::find(grounds.own, t, &OwnEquations::tissue) == grounds.own.end()) {
      I.frozen.push_back(field);
    }
    I.maxValue = std::max(I.maxValue, tissues[t].largestValue());
  }
  for (const CurveRef& ref : I.moved) {
    std::vector<CoreSample> samples;
    std::ranges::copy_if(cores.samples, std::back_inserter(samples), [&](const CoreSample& s) {
      return s.tissue == idOf(ref.tissue) && s.curve == ref.curve;
    });
    addPieces(tissues[ref.tissue], samples, I.old);
  }
  I.place.assign(static_cast<std::size_t>(domain.mesh.V.rows()), -1);
  std::vector<CoreSample> staying;
  std::ranges::copy_if(cores.samples, std::back_inserter(staying), [&](const CoreSample& s) {
    return std::ranges::none_of(I.moved, [&](const CurveRef& ref) {
      return s.tissue == idOf(ref.tissue) && s.curve == ref.curve;
    });
  });
  for (OwnEquations& equations : grounds.own) {
    if (std::ranges::find(I.moved, equations.tissue, &CurveRef::tissue) != I.moved.end()) {
      I.ownDrags.emplace_back(domain, I.ground, std::move(equations.ground),
                              tissues[equations.tissue], idOf(equations.tissue), staying, I.raw,
                              I.maxValue);
    } else {
      I.own.push_back({.field = static_cast<std::int32_t>(equations.tissue) + 1,
                       .ground = std::move(equations.ground),
                       .system = {}});
    }
  }
  I.shared.emplace(
      I.ground, domain.mesh, I.old, I.sharedTargets(I.old),
      [&I](std::int32_t v, double* values) {
        const double* all = I.raw(v);
        for (const std::int32_t field : I.fields) *values++ = all[field];
        for (const OwnDrag& own : I.ownDrags) {
          own.settledSpread(v, values);
          values += OwnDrag::kSpread;
        }
      },
      I.maxValue, how);
  // What is near where the curves are settled is wanted in the first frame
  for (Own& it : I.own) {
    if (I.isNear(it, I.old)) (void)I.moveOwn(it, I.old);
  }
}

// Those of the fields, then those of what own drags spread.
DragSystem::Targets CurveDrag::Impl::sharedTargets(const PiecedRows& rows) const {
  const Eigen::Index ownColumns = OwnDrag::kSpread * std::ssize(ownDrags);
  DragSystem::Targets out(std::ssize(rows.samples), std::ssize(fields) + ownColumns);
  out.leftCols(std::ssize(fields)) = DragSystem::tissueTargets(rows, fields);
  for (std::size_t i = 0; i < ownDrags.size(); ++i)
    out.middleCols(std::ssize(fields) + OwnDrag::kSpread * static_cast<Eigen::Index>(i),
                   OwnDrag::kSpread) = ownDrags[i].spreadTargets(rows);
  return out;
}

DragSystem::Part CurveDrag::Impl::moveOwnDrag(OwnDrag& it, std::size_t which, const PiecedRows& now,
                                              const std::vector<DragSystem::Part>& shared) const {
  std::vector<OwnDrag::SpreadChange> spread;
  for (const DragSystem::Part& part : shared) {
    OwnDrag::SpreadChange& change = spread.emplace_back();
    change.row = part.row;
    change.change = &part.change;
    for (int k = 0; k < OwnDrag::kSpread; ++k) {
      const auto column = static_cast<std::int32_t>(fields.size()) +
                          OwnDrag::kSpread * static_cast<std::int32_t>(which) + k;
      const auto at = std::ranges::lower_bound(part.fields, column);
      change.column.push_back(at != part.fields.end() && *at == column ? at - part.fields.begin()
                                                                       : -1);
    }
  }
  return it.move(now, spread);
}

// Whether rows miss the field by more than what is left out.
bool CurveDrag::Impl::isNear(const Own& it, const PiecedRows& rows) const {
  for (const RowPiece& piece : rows.pieces) {
    for (std::int32_t i = piece.first; i < piece.first + piece.count; ++i) {
      const CoreSample& s = rows.samples[static_cast<std::size_t>(i)];
      double miss = s.tissue.value - kFat.value == it.field ? piece.target : 0.0;
      for (int k = 0; k < 4; ++k) miss -= s.barycentric[k] * raw(domain.mesh.T(s.tet, k))[it.field];
      if (std::abs(miss) > how.tolerance * maxValue) return true;
    }
  }
  return false;
}

std::vector<DragSystem::Part> CurveDrag::Impl::moveOwn(Own& it, const PiecedRows& now) {
  // Rows of other tissues: they ask for nothing here
  const auto nothing = [](const PiecedRows& rows) {
    return DragSystem::Targets(DragSystem::Targets::Zero(std::ssize(rows.samples), 1));
  };
  if (!it.system) {
    if (!isNear(it, now)) return {};
    const PiecedRows before = it.ground->rowsOf(old);
    it.system.emplace(
        it.ground->ground, it.ground->region->mesh, before, nothing(before),
        [this, field = it.field, region = it.ground->region](std::int32_t v, double* value) {
          *value = raw(region->vertex[static_cast<std::size_t>(v)])[field];
        },
        maxValue, how);
  }
  const PiecedRows here = it.ground->rowsOf(now);
  std::vector<DragSystem::Part> out = it.system->move(here, nothing(here));
  for (DragSystem::Part& part : out) part.fields = {it.field};
  return out;
}

CurveDrag::Frame CurveDrag::move(std::span<const mesh::Spline> splines) {
  Impl& I = *impl_;
  EC_REQUIRE_EQ(splines.size(), I.moved.size());
  PiecedRows now;
  for (std::size_t m = 0; m < I.moved.size(); ++m) {
    const CurveRef& ref = I.moved[m];
    addDragged(I.walker, I.domain, I.tissues[ref.tissue], idOf(ref.tissue), ref.curve, splines[m],
               I.options, now);
    for (OwnDrag& own : I.ownDrags) {
      if (own.field() == static_cast<std::int32_t>(ref.tissue) + 1)
        own.setCurve(ref.curve, splines[m]);
    }
  }
  std::vector<DragSystem::Part> parts = I.shared->move(now, I.sharedTargets(now));
  std::vector<std::vector<DragSystem::Part>> ofOwn(I.own.size());
  std::vector<DragSystem::Part> ofOwnDrag(I.ownDrags.size());
  parallelFor(
      std::ssize(I.own) + std::ssize(I.ownDrags),
      [&](std::int64_t i) {
        if (i < std::ssize(I.ownDrags)) {
          const auto k = static_cast<std::size_t>(i);
          ofOwnDrag[k] = I.moveOwnDrag(I.ownDrags[k], k, now, parts);
        } else {
          const auto k = static_cast<std::size_t>(i - std::ssize(I.ownDrags));
          ofOwn[k] = I.moveOwn(I.own[k], now);
        }
      },
      1);

  // Columns to fields; those of spreads have served
  for (DragSystem::Part& part : parts) {
    std::erase_if(part.fields, [&](std::int32_t c) { return c >= std::ssize(I.fields); });
    part.change.conservativeResize(Eigen::NoChange, std::ssize(part.fields));
    for (std::int32_t& field : part.fields) field = I.fields[static_cast<std::size_t>(field)];
  }
  std::erase_if(parts, [](const DragSystem::Part& part) { return part.fields.empty(); });
  std::ranges::move(ofOwnDrag, std::back_inserter(parts));

  // Rows to vertices; then all parts side by side, where any is something
  const auto rename = [](DragSystem::Part& part, const auto& vertexOf) {
    for (std::int32_t& r : part.row) r = vertexOf(static_cast<std::size_t>(r));
  };
  for (DragSystem::Part& part : parts)
    rename(part, [&](std::size_t r) { return I.ground->pattern->vertex[r]; });
  for (std::size_t k = 0; k < I.own.size(); ++k) {
    const FieldRegion& region = *I.own[k].ground->region;
    for (DragSystem::Part& part : ofOwn[k]) {
      rename(part, [&](std::size_t r) {
        return region.vertex[static_cast<std::size_t>(region.pattern->vertex[r])];
      });
      parts.push_back(std::move(part));
    }
  }
  Frame out;
  for (const DragSystem::Part& part : parts) {
    for (const std::int32_t v : part.row) {
      std::int32_t& at = I.place[static_cast<std::size_t>(v)];
      if (at >= 0) continue;
      at = static_cast<std::int32_t>(out.vertices.size());
      out.vertices.push_back(v);
    }
    out.fields.insert(out.fields.end(), part.fields.begin(), part.fields.end());
    out.lastStep = std::max(out.lastStep, part.lastStep / I.maxValue);
  }
  out.change = TubeBlock::Zero(std::ssize(out.vertices), std::ssize(out.fields));
  Eigen::Index column = 0;
  for (const DragSystem::Part& part : parts) {
    for (std::size_t i = 0; i < part.row.size(); ++i)
      out.change.row(I.place[static_cast<std::size_t>(part.row[i])])
          .segment(column, part.change.cols()) = part.change.row(static_cast<Eigen::Index>(i));
    column += part.change.cols();
  }
  for (const std::int32_t v : out.vertices) I.place[static_cast<std::size_t>(v)] = -1;
  out.targets.resize(now.samples.size());
  for (const RowPiece& piece : now.pieces)
    std::fill_n(out.targets.begin() + piece.first, piece.count, piece.target);
  out.samples = std::move(now.samples);
  out.nearCurves = std::move(now.nearCurves);
  return out;
}

}  // namespace ecorche::tissue
