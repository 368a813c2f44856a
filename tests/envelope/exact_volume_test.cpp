#include <ecorche/envelope/envelope.h>
#include <ecorche/envelope/tied_point.h>
#include <gmpxx.h>

#include <catch2/catch.hpp>
#include <vector>

#include "support/cases.h"
#include "support/generated_anatomy.h"

using namespace ecorche;

// The same volumes a second way: every tet clipped by f_i ≥ f_j for all j, in rational numbers,
// tets cut into tets. No names, no tables, no order of vertices.

namespace {

using Weights = std::array<mpq_class, 4>;  // of the parent's corners
using Piece = std::array<Weights, 4>;

mpq_class determinant(const Piece& p) {
  mpq_class sum = 0;
  std::array<int, 4> order{0, 1, 2, 3};
  do {
    int inversions = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) inversions += order[std::size_t(i)] > order[std::size_t(j)];
    }
    mpq_class product = inversions % 2 ? -1 : 1;
    for (int i = 0; i < 4; ++i) product *= p[std::size_t(i)][std::size_t(order[std::size_t(i)])];
    sum += product;
  } while (std::ranges::next_permutation(order).found);
  return abs(sum);
}

Weights between(const Weights& in, const mpq_class& valueIn, const Weights& out,
                const mpq_class& valueOut) {
  const mpq_class t = valueIn / (valueIn - valueOut);
  Weights w;
  for (std::size_t c = 0; c < 4; ++c) w[c] = (1 - t) * in[c] + t * out[c];
  return w;
}

/// The part of the piece where the linear function, given at the parent's corners, is not negative.
void clip(const Piece& piece, const Weights& function, std::vector<Piece>& out) {
  std::array<mpq_class, 4> value;
  std::vector<std::size_t> in, outside;
  for (std::size_t v = 0; v < 4; ++v) {
    value[v] = 0;
    for (std::size_t c = 0; c < 4; ++c) value[v] += piece[v][c] * function[c];
    (value[v] >= 0 ? in : outside).push_back(v);
  }
  const auto cut = [&](std::size_t a, std::size_t b) {
    return between(piece[a], value[a], piece[b], value[b]);
  };
  const auto prism = [&](const Weights& a, const Weights& b, const Weights& c, const Weights& d,
                         const Weights& e, const Weights& f) {
    out.push_back({a, b, c, d});
    out.push_back({b, c, d, e});
    out.push_back({c, d, e, f});
  };
  if (outside.empty()) out.push_back(piece);
  if (in.size() == 1) {
    out.push_back(
        {piece[in[0]], cut(in[0], outside[0]), cut(in[0], outside[1]), cut(in[0], outside[2])});
  }
  if (in.size() == 2) {
    prism(piece[in[0]], cut(in[0], outside[0]), cut(in[0], outside[1]), piece[in[1]],
          cut(in[1], outside[0]), cut(in[1], outside[1]));
  }
  if (in.size() == 3) {
    prism(piece[in[0]], piece[in[1]], piece[in[2]], cut(in[0], outside[0]), cut(in[1], outside[0]),
          cut(in[2], outside[0]));
  }
}

/// Share of a tet that column i owns.
double shareOf(const mesh::Tets& T, Eigen::Index t, const tissue::FieldMatrix& fields,
               std::int32_t first, std::int32_t i) {
  Piece whole;
  for (std::size_t v = 0; v < 4; ++v) {
    for (std::size_t c = 0; c < 4; ++c) whole[v][c] = v == c ? 1 : 0;
  }
  std::vector<Piece> pieces{whole};
  for (std::int32_t j = first; j < fields.cols(); ++j) {
    if (j == i) continue;
    Weights difference;
    bool same = true;
    for (std::size_t c = 0; c < 4; ++c) {
      const std::int32_t v = T(t, static_cast<Eigen::Index>(c));
      difference[c] = mpq_class(fields(v, i)) - mpq_class(fields(v, j));
      same &= difference[c] == 0;
    }
    if (same) {
      if (envelope::tieRank(i) > envelope::tieRank(j)) return 0.0;
      continue;
    }
    std::vector<Piece> next;
    for (const Piece& p : pieces) clip(p, difference, next);
    pieces.clear();
    for (const Piece& p : next) {
      if (determinant(p) != 0) pieces.push_back(p);
    }
  }
  mpq_class share = 0;
  for (const Piece& p : pieces) share += determinant(p);
  return share.get_d();
}

std::vector<double> volumesByClipping(const domain::Domain& domain,
                                      const tissue::TissueFields& fields) {
  const auto columns = static_cast<std::int32_t>(fields.values.cols());
  const std::int32_t first = fields.fatIsCandidate ? 0 : 1;
  std::vector<double> volume(static_cast<std::size_t>(columns), 0.0);
  for (Eigen::Index t = 0; t < domain.mesh.T.rows(); ++t) {
    for (std::int32_t i = first; i < columns; ++i) {
      volume[static_cast<std::size_t>(i)] +=
          shareOf(domain.mesh.T, t, fields.values, first, i) * mesh::signedVolume(domain.mesh, t);
    }
  }
  return volume;
}

std::vector<double> volumesByEnvelope(const domain::Domain& domain,
                                      const tissue::TissueFields& fields, bool exact) {
  RunContext run;
  const auto cut = envelope::computeEnvelope(
      domain.mesh, domain.neighbours, fields.values,
      {.exact = exact, .fatIsCandidate = fields.fatIsCandidate, .strikeIslands = false}, run);
  REQUIRE(cut);
  std::vector<double> volume(static_cast<std::size_t>(fields.values.cols()), 0.0);
  for (Eigen::Index t = 0; t < cut->mesh.T.rows(); ++t) {
    volume[static_cast<std::size_t>(cut->label[static_cast<std::size_t>(t)].value - 1)] +=
        mesh::signedVolume(cut->mesh, t);
  }
  return volume;
}

}  // namespace

TEST_CASE("tissue volumes agree with clipping in rational numbers") {
  const std::size_t most = test::casesHere(40).size();
  std::size_t cases = 0;
  for (const std::uint64_t seed : test::casesHere(252)) {
    if (cases == most) break;
    test::GeneratedAnatomy c = test::generatedAnatomy(seed);
    if (c.domain.mesh.T.rows() > 420 || c.fields.values.cols() > 5) continue;
    if (seed % test::kFieldKindCount == static_cast<std::uint64_t>(test::FieldKind::WildScales))
      continue;
    ++cases;
    INFO(c.name);
    const auto expected = volumesByClipping(c.domain, c.fields);
    const auto exact = volumesByEnvelope(c.domain, c.fields, true);
    const auto clamped = volumesByEnvelope(c.domain, c.fields, false);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK(std::abs(exact[i] - expected[i]) <= 1e-9 * c.domain.volume);
      if (c.smooth) CHECK(std::abs(clamped[i] - expected[i]) <= 2e-3 * c.domain.volume);
    }
  }
  CHECK(cases >= most / 2);
}
