#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/curve_hats.h>
#include <ecorche/tissue/drag_system.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

// Letters: K the settled system, B rows, W weights, d targets; o rows as they were, n as they are.
// ρ = d − B f of settled fields f: by how much they miss a row. With x the change of a field,
//   K x = −B_oᵀ W_o (ρ_o − B_o x) + B_nᵀ W_n (ρ_n − B_n x).
// Along curves B_o x and the flux W_n (ρ_n − B_n x) / ℓ are smooth: P_o z and P_n η of a few hats
// (curve_hats.h). G = L⁻¹ K's columns, all of which go down the elimination tree alone.

namespace ecorche::tissue {

namespace {

using Tree = mesh::TreeSolver<float>;
using RowMajor = DragSystem::Targets;

// The tube that is swept is so many edges wide around rows that curves touch
constexpr int kTubeRings = 2;

}  // namespace

struct DragSystem::Impl {
  std::shared_ptr<const DragGround> ground;
  const mesh::TetMesh& mesh;
  Eigen::Index fieldCount = 0;
  Settled settled;
  double maxValue = 0.0;
  DragOptions how;

  // Where the curves were
  PiecedRows old;
  RowMajor missOld;  // ρ_o, #samples×#fields
  Eigen::RowVectorXd largestMissOld;
  std::vector<std::int32_t> touchedOld;
  Tree::Path pathOld;
  Tree::Block Zo;                       // L⁻¹ B_oᵀ W_o P_o
  Tree::Block Zf;                       // L⁻¹ of −B_oᵀ W_o ρ_o, all fields
  Eigen::LLT<Eigen::MatrixXd> lessOld;  // P_oᵀ W_o P_o − Zoᵀ Zo
  Eigen::MatrixXd Gof;                  // Zoᵀ Zf
  std::vector<double> K;                // without the old rows

  // Fields are worked on by two threads, half of them each
  struct Half {
    std::vector<std::int32_t> place;  // #rows of K, in x; −1
    Tree::Workspace workspace;
    std::vector<std::int32_t> row;  // of x
    TubeBlock x;
    double lastStep = 0.0;
  };
  std::array<Half, 2> halves;

  struct Moment {
    const PiecedRows& now;
    std::vector<Eigen::Index> act;  // of `fields`, those that change
    RowMajor miss;                  // ρ_n, all fields
    Tree::Path path;
    Tree::Block g;  // what goes back up the tree, #path×#act
    std::vector<std::int32_t> tube;
  };

  Impl(std::shared_ptr<const DragGround> g, const mesh::TetMesh& m)
      : ground(std::move(g)), mesh(m) {}

  [[nodiscard]] std::int32_t row(const CoreSample& s, int k) const {
    return ground->pattern->row[static_cast<std::size_t>(mesh.T(s.tet, k))];
  }
  // body(row of K, share) for every free corner of a sample's tet
  template <class Body>
  void forCorners(const CoreSample& s, const Body& body) const {
    for (int k = 0; k < 4; ++k) {
      if (const std::int32_t r = row(s, k); r >= 0) body(r, s.barycentric[k]);
    }
  }

  [[nodiscard]] RowMajor missed(const PiecedRows& rows, const Targets& targets) const;
  [[nodiscard]] std::vector<std::int32_t> touched(const PiecedRows& rows) const;
  [[nodiscard]] mesh::SparseColumns columnsOf(const PiecedRows& rows, const CurveHats& hats,
                                              double CoreSample::*worth) const;
  void begin(const Targets& targets);
  void solveAlong(Moment& moment) const;
  void workOn(std::int64_t half, const Moment& moment);
};

DragSystem::~DragSystem() = default;
DragSystem::DragSystem(DragSystem&&) noexcept = default;
DragSystem& DragSystem::operator=(DragSystem&&) noexcept = default;

DragSystem::DragSystem(std::shared_ptr<const DragGround> ground, const mesh::TetMesh& mesh,
                       PiecedRows old, Targets targets, Settled settled, double maxValue,
                       DragOptions how) {
  EC_REQUIRE(how.knots >= 2 && how.sweeps >= 0 && how.tolerance >= 0.0);
  impl_ = std::make_unique<Impl>(std::move(ground), mesh);
  Impl& I = *impl_;
  I.old = std::move(old);
  I.fieldCount = targets.cols();
  I.settled = std::move(settled);
  I.maxValue = maxValue;
  I.how = how;
  I.begin(targets);
}

DragSystem::Targets DragSystem::tissueTargets(const PiecedRows& rows,
                                              const std::vector<std::int32_t>& fields) {
  Targets out = Targets::Zero(std::ssize(rows.samples), std::ssize(fields));
  for (const RowPiece& piece : rows.pieces) {
    for (std::int32_t i = piece.first; i < piece.first + piece.count; ++i) {
      const auto own = static_cast<std::int32_t>(
          rows.samples[static_cast<std::size_t>(i)].tissue.value - kFat.value);
      const auto at = std::ranges::lower_bound(fields, own);
      if (at != fields.end() && *at == own) out(i, at - fields.begin()) = piece.target;
    }
  }
  return out;
}

// ρ = d − B f, settled
RowMajor DragSystem::Impl::missed(const PiecedRows& rows, const Targets& targets) const {
  EC_REQUIRE_EQ(targets.rows(), std::ssize(rows.samples));
  EC_REQUIRE_EQ(targets.cols(), fieldCount);
  RowMajor out = targets;
  Eigen::RowVectorXd corner(fieldCount);
  for (std::size_t i = 0; i < rows.samples.size(); ++i) {
    const CoreSample& s = rows.samples[i];
    for (int k = 0; k < 4; ++k) {
      settled(mesh.T(s.tet, k), corner.data());
      out.row(static_cast<Eigen::Index>(i)) -= s.barycentric[k] * corner;
    }
  }
  return out;
}

std::vector<std::int32_t> DragSystem::Impl::touched(const PiecedRows& rows) const {
  std::vector<std::int32_t> out;
  for (const CoreSample& s : rows.samples)
    forCorners(s, [&](std::int32_t r, double) { out.push_back(r); });
  std::ranges::sort(out);
  out.erase(std::ranges::unique(out).begin(), out.end());
  return out;
}

// Bᵀ times what every sample is worth times hats
mesh::SparseColumns DragSystem::Impl::columnsOf(const PiecedRows& rows, const CurveHats& hats,
                                                double CoreSample::*worth) const {
  std::vector<std::vector<std::pair<std::size_t, double>>> pieces(
      static_cast<std::size_t>(hats.count()));
  for (std::size_t p = 0; p < rows.pieces.size(); ++p) {
    const CurveHats::At& at = hats[p];
    pieces[static_cast<std::size_t>(at.column)].emplace_back(p, at.here);
    if (at.next != 0.0) pieces[static_cast<std::size_t>(at.column) + 1].emplace_back(p, at.next);
  }
  mesh::SparseColumns out;
  for (const auto& column : pieces) {
    for (const auto& [p, share] : column) {
      const RowPiece& piece = rows.pieces[p];
      for (std::int32_t i = piece.first; i < piece.first + piece.count; ++i) {
        const CoreSample& s = rows.samples[static_cast<std::size_t>(i)];
        const double v = share * s.*worth;
        forCorners(s, [&](std::int32_t r, double corner) { out.add(r, v * corner); });
      }
    }
    out.endColumn();
  }
  return out;
}

void DragSystem::Impl::begin(const Targets& targets) {
  const Tree& tree = ground->tree;
  missOld = missed(old, targets);
  largestMissOld = Eigen::RowVectorXd::Zero(fieldCount);
  if (missOld.rows() > 0) largestMissOld = missOld.cwiseAbs().colwise().maxCoeff();
  touchedOld = touched(old);
  pathOld = tree.pathOf(touchedOld);
  K = ground->K;
  addRows(mesh, *ground->pattern, old.samples, -1.0, K);
  for (Half& half : halves)
    half.place.assign(static_cast<std::size_t>(ground->pattern->rowCount()), -1);

  const CurveHats hats(old, how.knots);
  Zo = tree.forward(pathOld, columnsOf(old, hats, &CoreSample::weight));
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(std::ssize(old.pieces));
  mesh::SparseColumns force;
  for (std::size_t p = 0; p < old.pieces.size(); ++p) {
    const RowPiece& piece = old.pieces[p];
    for (std::int32_t i = piece.first; i < piece.first + piece.count; ++i)
      weight[static_cast<Eigen::Index>(p)] += old.samples[static_cast<std::size_t>(i)].weight;
  }
  for (Eigen::Index j = 0; j < fieldCount; ++j) {
    for (std::size_t i = 0; i < old.samples.size(); ++i) {
      const double pull = -old.samples[i].weight * missOld(static_cast<Eigen::Index>(i), j);
      forCorners(old.samples[i],
                 [&](std::int32_t r, double corner) { force.add(r, pull * corner); });
    }
    force.endColumn();
  }
  Zf = tree.forward(pathOld, force);
  Gof = tree.product(pathOld, Zo, pathOld, Zf);
  Eigen::MatrixXd less = Eigen::MatrixXd::Zero(hats.count(), hats.count());
  hats.addSquare(weight, less);
  // Knots with hardly a piece between them would be alike but for rounding
  const Eigen::VectorXd some = 1e-5 * less.diagonal().array() + 1e-6 * less.diagonal().mean();
  less -= tree.product(pathOld, Zo, pathOld, Zo);
  less.diagonal() += some;
  lessOld.compute(less);
}

// Finds z and η, and from them what goes back up the tree.
void DragSystem::Impl::solveAlong(Moment& moment) const {
  const Tree& tree = ground->tree;
  const PiecedRows& now = moment.now;
  const CurveHats hats(now, how.knots);
  const Tree::Path pathNew = tree.pathOf(touched(now));
  const Tree::Block Zn = tree.forward(pathNew, columnsOf(now, hats, &CoreSample::length));
  const Tree::Block ZfAct = Zf(Eigen::all, moment.act);
  Eigen::MatrixXd Gon;
  Eigen::MatrixXd Gnf;
  Eigen::MatrixXd B;  // P_nᵀ (ℓ²/W) P_n + Znᵀ Zn
  parallelFor(
      3,
      [&](std::int64_t part) {
        if (part == 0) B = tree.product(pathNew, Zn, pathNew, Zn);
        if (part == 1) Gon = tree.product(pathOld, Zo, pathNew, Zn);
        if (part == 2) Gnf = tree.product(pathNew, Zn, pathOld, ZfAct);
      },
      1);
  Eigen::VectorXd resistance = Eigen::VectorXd::Zero(std::ssize(now.pieces));
  Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(std::ssize(now.pieces), std::ssize(moment.act));
  for (std::size_t p = 0; p < now.pieces.size(); ++p) {
    const RowPiece& piece = now.pieces[p];
    for (std::int32_t i = piece.first; i < piece.first + piece.count; ++i) {
      const CoreSample& s = now.samples[static_cast<std::size_t>(i)];
      resistance[static_cast<Eigen::Index>(p)] += s.length * s.length / s.weight;
      pull.row(static_cast<Eigen::Index>(p)) += s.length * moment.miss(i, moment.act);
    }
  }
  hats.addSquare(resistance, B);
  if (B.size() > 0) B.diagonal().array() += 1e-6 * B.diagonal().mean();
  Eigen::MatrixXd right = hats.project(pull) - Gnf;

  // [−A G; Gᵀ B] [z; η] = [−Gof; right], A = P_oᵀ W_o P_o − Zoᵀ Zo
  // Eigen takes the first number of what it solves for, also where there is none: a curve may be
  // out of the skin, or no field may change
  const auto solve = [](const Eigen::LLT<Eigen::MatrixXd>& factor, const Eigen::MatrixXd& b) {
    return b.size() > 0 ? Eigen::MatrixXd(factor.solve(b)) : b;
  };
  const Eigen::MatrixXd AG = solve(lessOld, Gon);
  const Eigen::MatrixXd Af = solve(lessOld, Gof(Eigen::all, moment.act));
  B.noalias() += Gon.transpose() * AG;
  right.noalias() -= Gon.transpose() * Af;
  const Eigen::MatrixXd flux = solve(B.llt(), right);
  const Eigen::MatrixXd z = Af + AG * flux;

  moment.path = tree.join(pathOld, pathNew);
  moment.g = Tree::Block::Zero(moment.path.rowCount(), std::ssize(moment.act));
  tree.accumulate(pathOld, Zo, z, moment.path, moment.g);
  tree.accumulate(pathOld, ZfAct, Eigen::MatrixXd::Identity(z.cols(), z.cols()), moment.path,
                  moment.g);
  tree.accumulate(pathNew, Zn, flux, moment.path, moment.g);
}

// Half of the fields: back up the tree, then over the tube
void DragSystem::Impl::workOn(std::int64_t which, const Moment& moment) {
  Half& half = halves[static_cast<std::size_t>(which)];
  const Eigen::Index middle = (moment.g.cols() + 1) / 2;
  const Eigen::Index begin = which == 0 ? 0 : middle;
  const Eigen::Index count = which == 0 ? middle : moment.g.cols() - middle;
  Tree::Answer answer = ground->tree.backward(moment.path, moment.g.middleCols(begin, count),
                                              how.tolerance * maxValue, half.workspace);
  half.row = std::move(answer.row);
  for (std::size_t i = 0; i < half.row.size(); ++i)
    half.place[static_cast<std::size_t>(half.row[i])] = static_cast<std::int32_t>(i);
  for (const std::int32_t r : moment.tube) {
    std::int32_t& at = half.place[static_cast<std::size_t>(r)];
    if (at >= 0) continue;
    at = static_cast<std::int32_t>(half.row.size());
    half.row.push_back(r);
  }
  half.x = TubeBlock::Zero(std::ssize(half.row), count);
  half.x.topRows(answer.value.rows()) = answer.value;

  const std::vector<Eigen::Index> act(moment.act.begin() + begin,
                                      moment.act.begin() + begin + count);
  TubeBlock force = TubeBlock::Zero(std::ssize(moment.tube), count);
  const auto push = [&](const PiecedRows& rows, const RowMajor& miss, double times) {
    for (std::size_t i = 0; i < rows.samples.size(); ++i) {
      const CoreSample& s = rows.samples[i];
      const Eigen::RowVectorXf pull =
          (times * s.weight * miss(static_cast<Eigen::Index>(i), act)).cast<float>();
      forCorners(s, [&](std::int32_t r, double corner) {
        const auto at = std::ranges::lower_bound(moment.tube, r) - moment.tube.begin();
        force.row(at) += static_cast<float>(corner) * pull;
      });
    }
  };
  push(old, missOld, -1.0);
  push(moment.now, moment.miss, 1.0);
  half.lastStep = sweepTube(*ground, K, moment.tube, force, half.place, how.sweeps, half.x);
}

std::vector<DragSystem::Part> DragSystem::move(const PiecedRows& now, const Targets& targets) {
  Impl& I = *impl_;
  Impl::Moment moment{.now = now, .act = {}, .miss = {}, .path = {}, .g = {}, .tube = {}};
  moment.miss = I.missed(now, targets);
  for (Eigen::Index j = 0; j < I.fieldCount; ++j) {
    const double largest = moment.miss.rows() > 0 ? moment.miss.col(j).cwiseAbs().maxCoeff() : 0.0;
    if (std::max(I.largestMissOld[j], largest) > I.how.tolerance * I.maxValue)
      moment.act.push_back(j);
  }
  if (moment.act.empty()) return {};
  I.solveAlong(moment);
  std::vector<std::int32_t> touched = I.touched(now);
  touched.insert(touched.end(), I.touchedOld.begin(), I.touchedOld.end());
  moment.tube = rowsAround(*I.ground, touched, kTubeRings);
  addRows(I.mesh, *I.ground->pattern, now.samples, 1.0, I.K);
  const std::int64_t parts = std::min<std::int64_t>(2, std::ssize(moment.act));
  parallelFor(
      parts, [&](std::int64_t half) { I.workOn(half, moment); }, 1);
  addRows(I.mesh, *I.ground->pattern, now.samples, -1.0, I.K);

  std::vector<Part> out;
  std::size_t next = 0;
  for (std::int64_t which = 0; which < parts; ++which) {
    Impl::Half& half = I.halves[static_cast<std::size_t>(which)];
    for (const std::int32_t r : half.row) half.place[static_cast<std::size_t>(r)] = -1;
    Part& part = out.emplace_back();
    for (Eigen::Index c = 0; c < half.x.cols(); ++c)
      part.fields.push_back(static_cast<std::int32_t>(moment.act[next++]));
    part.row = std::move(half.row);
    part.change = std::move(half.x);
    part.lastStep = half.lastStep;
  }
  return out;
}

}  // namespace ecorche::tissue
