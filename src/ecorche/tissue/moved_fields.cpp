#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/moved_fields.h>
#include <ecorche/tissue/near_curves.h>
#include <ecorche/tissue/sample_targets.h>
#include <ecorche/tissue/segmentation.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace ecorche::tissue {

namespace {

constexpr std::int64_t kTellGrain = 512;
// Of a field that goes along with others, over the largest value: less is not worth a picture's
// time
constexpr double kTold = 1e-5;

// A row that something near it corrects: by which sample, of the settled ones or of the moved
struct Correction {
  std::int32_t vertex;
  const NearCurve* near;
  const CoreSample* sample;
  double target;
};

}  // namespace

struct MovedFields::Impl {
  const domain::Domain& domain;
  const CoreSamples& cores;
  TissueFields& fields;
  std::vector<TissueId>& owner;
  std::unique_ptr<CurveDrag> drag;

  std::vector<NearCurve> others;            // of curves that stay, by vertex
  std::vector<double> target;               // #samples of cores
  std::vector<std::int32_t> wereNear;       // vertices near where the moved curves were
  std::vector<std::int32_t> uncorrectedAt;  // #V, row of fields.uncorrected; −1

  // What was settled, of every vertex that was written over
  std::vector<std::int32_t> savedAt;  // #V; −1: as it was
  std::vector<std::int32_t> savedVertex;
  std::vector<double> saved;  // rows, one after another
  std::vector<TissueId> savedOwner;
  std::vector<double> told;  // the same rows as Told last told of them

  std::vector<std::int32_t> changed;  // vertices that differ from settled now
  std::vector<std::int32_t> changedFields;
  std::vector<std::int32_t> inFrame;       // #V, row of the frame's change; −1
  std::vector<std::int32_t> placeOfField;  // #fields, column of the frame's change; −1
  std::vector<std::uint8_t> near;    // #V, 1: where the moved curves were, 2: are, 4: had been
  std::vector<std::int32_t> moving;  // columns, all that are not frozen

  Impl(const domain::Domain& d, const CoreSamples& c, TissueFields& f, std::vector<TissueId>& o)
      : domain(d), cores(c), fields(f), owner(o) {}

  [[nodiscard]] Eigen::Index width() const { return fields.values.cols(); }
  // Rows as they were settled, as drawn and as the equations gave them
  [[nodiscard]] const double* settled(std::int32_t v) const {
    const std::int32_t at = savedAt[static_cast<std::size_t>(v)];
    return at < 0 ? fields.values.row(v).data() : saved.data() + at * width();
  }
  [[nodiscard]] const double* raw(std::int32_t v) const {
    const std::int32_t at = uncorrectedAt[static_cast<std::size_t>(v)];
    return at < 0 ? settled(v) : fields.uncorrected.values.row(at).data();
  }
  // values[i] += times · raw value of columns[i] now
  void addRaw(std::int32_t v, const CurveDrag::Frame& frame,
              const std::vector<std::int32_t>& columns, double times, double* values) const {
    const double* settledRow = raw(v);
    const std::int32_t at = inFrame[static_cast<std::size_t>(v)];
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::int32_t j = columns[i];
      double f = settledRow[j];
      const std::int32_t c = placeOfField[static_cast<std::size_t>(j)];
      if (at >= 0 && c >= 0) f += static_cast<double>(frame.change(at, c));
      values[i] += times * f;
    }
  }
  // Ascending
  [[nodiscard]] std::vector<std::int32_t> touched(const CurveDrag::Frame& frame) const {
    std::vector<std::uint64_t> bits((savedAt.size() + 63) / 64, 0);
    const auto mark = [&](std::int32_t v) {
      const auto i = static_cast<std::size_t>(v);
      bits[i / 64] |= std::uint64_t(1) << (i % 64);
    };
    for (const std::int32_t v : frame.vertices) mark(v);
    for (const std::int32_t v : wereNear) mark(v);
    for (const NearCurve& near : frame.nearCurves) mark(near.vertex);
    std::vector<std::int32_t> out;
    for (std::size_t word = 0; word < bits.size(); ++word) {
      for (std::uint64_t left = bits[word]; left != 0; left &= left - 1)
        out.push_back(static_cast<std::int32_t>(64 * word) + std::countr_zero(left));
    }
    return out;
  }
  void save(std::int32_t v) {
    std::int32_t& at = savedAt[static_cast<std::size_t>(v)];
    if (at >= 0) return;
    at = static_cast<std::int32_t>(savedVertex.size());
    savedVertex.push_back(v);
    const auto row = fields.values.row(v);
    saved.insert(saved.end(), row.data(), row.data() + width());
    told.insert(told.end(), row.data(), row.data() + width());
    savedOwner.push_back(owner[static_cast<std::size_t>(v)]);
  }
  [[nodiscard]] double* toldRow(std::int32_t v) {
    return told.data() + savedAt[static_cast<std::size_t>(v)] * width();
  }
  void putBack(std::int32_t v) {
    const auto at = static_cast<std::size_t>(savedAt[static_cast<std::size_t>(v)]);
    fields.values.row(v) = Eigen::Map<const Eigen::RowVectorXd>(settled(v), width());
    owner[static_cast<std::size_t>(v)] = savedOwner[at];
  }
};

MovedFields::MovedFields(const domain::Domain& domain, DragGrounds grounds,
                         const CurveWalker& walker, const CoreSamples& cores,
                         const std::vector<CurveTissue>& tissues, const TissueOptions& options,
                         std::vector<CurveRef> moved, TissueFields& fields,
                         std::vector<TissueId>& owner)
    : impl_(std::make_unique<Impl>(domain, cores, fields, owner)) {
  Impl& I = *impl_;
  const auto vertexCount = static_cast<std::size_t>(fields.values.rows());
  I.savedAt.assign(vertexCount, -1);
  I.inFrame.assign(vertexCount, -1);
  I.uncorrectedAt.assign(vertexCount, -1);
  for (std::size_t k = 0; k < fields.uncorrected.vertex.size(); ++k)
    I.uncorrectedAt[static_cast<std::size_t>(fields.uncorrected.vertex[k])] =
        static_cast<std::int32_t>(k);
  I.target = sampleTargets(cores.samples, tissues);
  I.near.assign(vertexCount, 0);
  I.placeOfField.assign(static_cast<std::size_t>(fields.values.cols()), -1);
  for (const NearCurve& near : cores.nearCurves) {
    const CoreSample& s = cores.samples[static_cast<std::size_t>(near.sample)];
    const CurveRef of{static_cast<std::size_t>(s.tissue.value - kFirstMuscle.value), s.curve};
    if (std::ranges::find(moved, of) == moved.end()) {
      I.others.push_back(near);
    } else {
      I.wereNear.push_back(near.vertex);
      I.near[static_cast<std::size_t>(near.vertex)] = 1;
    }
  }
  std::ranges::stable_sort(I.others, {}, &NearCurve::vertex);
  I.drag = std::make_unique<CurveDrag>(
      domain, std::move(grounds), walker, cores, tissues, options, std::move(moved),
      [impl = impl_.get()](std::int32_t v) { return impl->raw(v); });
  for (std::int32_t j = 0; j < fields.values.cols(); ++j) {
    if (!std::ranges::binary_search(I.drag->frozen(), j)) I.moving.push_back(j);
  }
}
MovedFields::~MovedFields() = default;

const std::vector<CurveRef>& MovedFields::moved() const { return impl_->drag->moved(); }

MovedFields::Told MovedFields::move(std::span<const mesh::Spline> splines) {
  Impl& I = *impl_;
  CurveDrag::Frame frame = I.drag->move(splines);

  // Beside what changed: where a correction came or went
  for (std::size_t i = 0; i < frame.vertices.size(); ++i)
    I.inFrame[static_cast<std::size_t>(frame.vertices[i])] = static_cast<std::int32_t>(i);
  const std::vector<std::int32_t> vertices = I.touched(frame);
  for (const std::int32_t v : vertices) I.save(v);

  std::vector<Correction> corrections;
  {
    auto here = vertices.begin();
    for (const NearCurve& near : I.others) {
      here = std::lower_bound(here, vertices.end(), near.vertex);
      if (here == vertices.end()) break;
      if (*here != near.vertex) continue;
      const auto s = static_cast<std::size_t>(near.sample);
      corrections.push_back({near.vertex, &near, &I.cores.samples[s], I.target[s]});
    }
    for (const NearCurve& near : frame.nearCurves) {
      const auto s = static_cast<std::size_t>(near.sample);
      corrections.push_back({near.vertex, &near, &frame.samples[s], frame.targets[s]});
    }
    std::ranges::stable_sort(corrections, {}, &Correction::vertex);
  }

  // Beside them: what this frame no longer changes
  std::vector<std::int32_t> all;
  std::ranges::set_union(vertices, I.changed, std::back_inserter(all));
  std::vector<std::int32_t> columns;
  std::vector<std::int32_t> changing = frame.fields;
  std::ranges::sort(changing);
  std::ranges::set_union(changing, I.changedFields, std::back_inserter(columns));
  for (std::size_t i = 0; i < frame.fields.size(); ++i)
    I.placeOfField[static_cast<std::size_t>(frame.fields[i])] = static_cast<std::int32_t>(i);
  for (const NearCurve& n : frame.nearCurves) I.near[static_cast<std::size_t>(n.vertex)] |= 2;
  const auto write = [&](std::int32_t v) {
    // Beside moved curves all fields are corrected, and must not stay so
    const std::vector<std::int32_t>& written =
        I.near[static_cast<std::size_t>(v)] != 0 ? I.moving : columns;
    thread_local std::vector<double> f;
    thread_local std::vector<double> q;
    f.assign(written.size(), 0.0);
    I.addRaw(v, frame, written, 1.0, f.data());
    for (auto c = std::ranges::lower_bound(corrections, v, {}, &Correction::vertex);
         c != corrections.end() && c->vertex == v; ++c) {
      // Flux into every field: W/ℓ (δ D − B f)
      q.assign(written.size(), 0.0);
      for (int k = 0; k < 4; ++k)
        I.addRaw(I.domain.mesh.T(c->sample->tet, k), frame, written, -c->sample->barycentric[k],
                 q.data());
      const auto own = static_cast<std::int32_t>(c->sample->tissue.value - kFat.value);
      const double w = c->sample->weight / c->sample->length;
      for (std::size_t i = 0; i < written.size(); ++i) {
        const bool isOwn = written[i] == own;
        const double flux = w * (q[i] + (isOwn ? c->target : 0.0));
        f[i] = correctedNearCurve(f[i], c->near->error * flux, isOwn, c->target);
      }
    }
    auto row = I.fields.values.row(v);
    for (std::size_t i = 0; i < written.size(); ++i) row[written[i]] = f[i];
    I.owner[static_cast<std::size_t>(v)] = ownerOf(row, I.fields.fatIsCandidate);
  };
  std::vector<std::uint8_t> tell(all.size(), 0);  // 1: the field is another one, 2: so is the owner
  parallelFor(
      std::ssize(all),
      [&](std::int64_t i) {
        const std::int32_t v = all[static_cast<std::size_t>(i)];
        const TissueId before = I.owner[static_cast<std::size_t>(v)];
        if (std::ranges::binary_search(vertices, v)) {
          write(v);
        } else {
          I.putBack(v);
        }
        const double* f = I.fields.values.row(v).data();
        const double* told = I.toldRow(v);
        double most = 0.0;
        for (const std::int32_t j : columns) most = std::max(most, std::abs(f[j] - told[j]));
        if (I.owner[static_cast<std::size_t>(v)] != before) {
          tell[static_cast<std::size_t>(i)] = 2;
        } else if (most > kToldMoved * I.fields.maxValue) {
          tell[static_cast<std::size_t>(i)] = 1;
        }
      },
      kTellGrain);
  for (const std::int32_t v : frame.vertices) I.inFrame[static_cast<std::size_t>(v)] = -1;
  for (const std::int32_t j : frame.fields) I.placeOfField[static_cast<std::size_t>(j)] = -1;
  for (const std::int32_t v : all) I.near[static_cast<std::size_t>(v)] &= 1;
  for (const NearCurve& n : frame.nearCurves) I.near[static_cast<std::size_t>(n.vertex)] |= 4;

  Told out;
  std::vector<std::uint8_t> toldField(static_cast<std::size_t>(I.width()), 0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (tell[i] == 0) continue;
    const std::int32_t v = all[i];
    out.vertices.push_back(v);
    out.owners += tell[i] == 2;
    const double* f = I.fields.values.row(v).data();
    const double* told = I.toldRow(v);
    for (const std::int32_t j : columns) {
      if (std::abs(f[j] - told[j]) > kTold * I.fields.maxValue)
        toldField[static_cast<std::size_t>(j)] = 1;
    }
  }
  for (const std::int32_t j : columns) {
    if (toldField[static_cast<std::size_t>(j)] != 0) out.fields.push_back(j);
  }
  for (const std::int32_t v : out.vertices) {
    const double* f = I.fields.values.row(v).data();
    for (const std::int32_t j : out.fields) I.toldRow(v)[j] = f[j];
  }
  out.error = frame.lastStep;
  I.changed = vertices;
  I.changedFields = std::move(changing);
  return out;
}

MovedFields::Told MovedFields::restore() {
  Told out;
  for (const std::int32_t v : impl_->changed) impl_->putBack(v);
  out.vertices = std::exchange(impl_->changed, {});
  out.fields = std::exchange(impl_->changedFields, {});
  return out;
}

}  // namespace ecorche::tissue
