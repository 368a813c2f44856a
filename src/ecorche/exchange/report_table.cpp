#include <ecorche/exchange/report.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace ecorche::exchange {

namespace {

enum class Align { Left, Right };

struct Column {
  std::string title;
  Align align = Align::Right;
};

// Columns on a terminal: bytes that continue a character take no room.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t to, Align align) {
  const std::string blanks(to - std::min(to, width(text)), ' ');
  return align == Align::Left ? text + blanks : blanks + text;
}

std::string table(const std::vector<Column>& columns,
                  const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const Column& c : columns) widths.push_back(width(c.title));
  for (const auto& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], width(row[k]));
  }
  std::string out;
  const auto line = [&](const auto& cell) {
    std::string text;
    for (std::size_t k = 0; k < columns.size(); ++k)
      text += "  " + padded(cell(k), widths[k], columns[k].align);
    text.erase(text.find_last_not_of(' ') + 1);
    out += text + "\n";
  };
  line([&](std::size_t k) { return columns[k].title; });
  for (const auto& row : rows)
    line([&](std::size_t k) { return k < row.size() ? row[k] : std::string(); });
  return out;
}

// 1234567 → "1,234,567"
std::string grouped(std::int64_t x) {
  std::string digits = std::to_string(x);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > (x < 0 ? 1 : 0); at -= 3) {
    digits.insert(static_cast<std::size_t>(at), ",");
  }
  return digits;
}

std::string attachmentsText(const std::vector<AttachmentFigures>& attachments) {
  std::string out;
  for (const AttachmentFigures& a : attachments) {
    if (a.areaCm2 <= 0.0) continue;
    if (!out.empty()) out += ", ";
    out += a.areaCm2 < 0.1 ? fmt::format("{} <0.1", a.name)
                           : fmt::format("{} {:.1f}", a.name, a.areaCm2);
  }
  return out;
}

std::string tissueTable(const Report& report) {
  std::vector<std::vector<std::string>> rows;
  for (const TissueFigures& t : report.tissues) {
    std::string fiber;
    if (t.fibers && t.fibers->traced > 0) {
      fiber = fmt::format("{:.1f} ± {:.1f}", t.fibers->lengthCm, t.fibers->lengthSdCm);
    }
    rows.push_back({std::to_string(t.id), t.name, fmt::format("{:.2f}", t.volumeCm3),
                    fmt::format("{:.1f}", t.areaCm2), std::to_string(t.components), grouped(t.tets),
                    fiber, attachmentsText(t.attachments)});
  }
  return table({{"id"},
                {"tissue", Align::Left},
                {"cm³"},
                {"cm²"},
                {"pieces"},
                {"tets"},
                {"fibres cm"},
                {"attached to, cm²", Align::Left}},
               rows);
}

std::string qualityText(const Report& report) {
  const QualityFigures& q = report.quality;
  std::string out =
      fmt::format("  dihedral angles {:.3g}° … {:.4g}°", q.minDihedralDeg, q.maxDihedralDeg);
  static constexpr std::array<const char*, 6> kBins{"<1°", "<5°", "<10°", "<20°", "<30°", "more"};
  for (std::size_t k = 0; k < q.minDihedralHistogram.size() && k < kBins.size(); ++k) {
    out += fmt::format("{} {} {}", k == 0 ? "; smallest angle" : ",", kBins[k],
                       grouped(q.minDihedralHistogram[k]));
  }
  out += "\n";
  if (!report.tissuesPerTet.empty()) {
    out += "  domain tets by number of tissues:";
    for (std::size_t k = 0; k < report.tissuesPerTet.size(); ++k) {
      out +=
          fmt::format("{} {}: {:.2f} %", k == 0 ? "" : ",", k + 1, 100.0 * report.tissuesPerTet[k]);
    }
    out += "\n";
  }
  return out;
}

std::string findingsText(const Findings& findings) {
  std::string out;
  for (const Finding& f : findings) {
    if (f.severity == Severity::Note) continue;
    out += fmt::format("  {:8}  {}\n", name(f.severity), f.message);
  }
  const auto notes = std::ranges::count(findings, Severity::Note, &Finding::severity);
  if (notes > 0)
    out += fmt::format("  and {} note{} in report.json\n", notes, notes == 1 ? "" : "s");
  return out;
}

std::string stagesText(const Report& report) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& s : report.stages) {
    const auto indent = static_cast<std::size_t>(2 * s.level);
    rows.push_back({std::string(indent, ' ') + s.stage,
                    std::string(indent, ' ') + fmt::format("{:.2f}", s.seconds)});
  }
  rows.push_back({"in all", fmt::format("{:.2f}", report.totalSeconds)});
  std::string out = table({{"stage", Align::Left}, {"s"}}, rows);
  out += fmt::format("  peak memory {:.0f} MB, worker {:.0f} MB; {}, {} of {} cores{}\n",
                     static_cast<double>(report.peakMemoryBytes) / 1e6,
                     static_cast<double>(report.peakWorkerMemoryBytes) / 1e6,
                     report.machine.processor, report.machine.threads, report.machine.cores,
                     report.machine.blas.empty() ? "" : ", " + report.machine.blas);
  return out;
}

}  // namespace

std::string checkTable(const std::vector<Check>& checks) {
  std::vector<std::vector<std::string>> rows;
  for (const Check& c : checks) {
    rows.push_back({c.pass ? "ok" : "FAILED", c.name, fmt::format("{:.4g}", c.value),
                    fmt::format("{:.4g}", c.limit), c.detail});
  }
  return table({{"", Align::Left}, {"check", Align::Left}, {"value"}, {"limit"}, {"", Align::Left}},
               rows);
}

std::string reportTable(const Report& report) {
  std::string out =
      fmt::format("{}: {} tets ({} free vertices) in, {} tets out, {:.1f} cm³\n\n", report.project,
                  grouped(report.domainTets), grouped(report.freeVertices), grouped(report.tets),
                  report.domainVolumeCm3);
  out += tissueTable(report) + "\n" + qualityText(report) + "\n";
  if (!report.checks.empty()) out += checkTable(report.checks) + "\n";
  const std::string findings = findingsText(report.findings);
  if (!findings.empty()) out += findings + "\n";
  return out + stagesText(report);
}

}  // namespace ecorche::exchange
