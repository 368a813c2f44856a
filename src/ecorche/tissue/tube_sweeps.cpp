#include <ecorche/tissue/tube_sweeps.h>

#include <algorithm>

namespace ecorche::tissue {

double sweepTube(const DragGround& ground, const std::vector<double>& K,
                 std::span<const std::int32_t> rows, const TubeBlock& force,
                 std::span<const std::int32_t> place, int sweeps, TubeBlock& x) {
  if (sweeps == 0 || rows.empty() || x.cols() == 0) return 0.0;
  const mesh::StiffnessPattern& pattern = *ground.pattern;

  // Row by row, off the diagonal; values that are nothing and stay so are left out
  struct Entry {
    std::int32_t value;
    float k;
  };
  std::vector<std::int32_t> first{0};
  std::vector<Entry> entries;
  std::vector<float> inverse;
  std::vector<std::int32_t> own;
  entries.reserve(16 * rows.size());
  for (const std::int32_t row : rows) {
    const auto r = static_cast<std::size_t>(row);
    for (auto e = static_cast<std::size_t>(ground.rows->first[r]);
         e < static_cast<std::size_t>(ground.rows->first[r + 1]); ++e) {
      const std::int32_t at = place[static_cast<std::size_t>(ground.rows->neighbour[e])];
      if (at >= 0)
        entries.push_back(
            {at, static_cast<float>(K[static_cast<std::size_t>(ground.rows->slot[e])])});
    }
    first.push_back(static_cast<std::int32_t>(entries.size()));
    inverse.push_back(static_cast<float>(1.0 / K[static_cast<std::size_t>(pattern.diagonal(row))]));
    own.push_back(place[r]);
  }

  double lastStep = 0.0;
  Eigen::RowVectorXf value(x.cols());
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    float step = 0.0F;
    for (std::size_t q = 0; q < rows.size(); ++q) {
      const std::size_t i = sweep % 2 == 0 ? q : rows.size() - 1 - q;
      value = force.row(static_cast<Eigen::Index>(i));
      for (auto e = static_cast<std::size_t>(first[i]); e < static_cast<std::size_t>(first[i + 1]);
           ++e)
        value -= entries[e].k * x.row(entries[e].value);
      value *= inverse[i];
      auto here = x.row(own[i]);
      step = std::max(step, (value - here).cwiseAbs().maxCoeff());
      here = value;
    }
    lastStep = static_cast<double>(step);
  }
  return lastStep;
}

std::vector<std::int32_t> rowsAround(const DragGround& ground, std::span<const std::int32_t> rows,
                                     int edges) {
  std::vector<std::uint8_t> in(ground.rows->first.size() - 1, 0);
  std::vector<std::int32_t> out;
  const auto take = [&](std::int32_t r) {
    if (in[static_cast<std::size_t>(r)] != 0) return;
    in[static_cast<std::size_t>(r)] = 1;
    out.push_back(r);
  };
  for (const std::int32_t r : rows) take(r);
  std::size_t begin = 0;
  for (int ring = 0; ring < edges; ++ring) {
    const std::size_t end = out.size();
    for (; begin < end; ++begin) {
      const auto r = static_cast<std::size_t>(out[begin]);
      for (auto i = static_cast<std::size_t>(ground.rows->first[r]);
           i < static_cast<std::size_t>(ground.rows->first[r + 1]); ++i)
        take(ground.rows->neighbour[i]);
    }
  }
  std::ranges::sort(out);
  return out;
}

}  // namespace ecorche::tissue
