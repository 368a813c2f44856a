#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/exchange/anatomy_file.h>

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::exchange {

/// One truth that was tested, on figures or on files.
struct Check {
  std::string name;  ///< stable, lower case with dashes: "tets-positive"
  bool pass = true;
  double value = 0.0;                    ///< what was measured, the worst where there are many
  double limit = 0.0;                    ///< what it may be
  std::string detail;                    ///< a sentence for people: how many, how much, which
  std::string object;                    ///< muscle, bone or file at fault; empty if none
  std::optional<Eigen::Vector3d> point;  ///< where the worst is [m]
};

/// Where a tissue meets a bone or plane.
struct AttachmentFigures {
  std::string role;  ///< "origin", "insertion" or empty for a contact that is neither
  std::string on;    ///< "bone", "cut-plane", "tissue" or "free"
  std::string name;  ///< of the bone, plane or tissue
  double areaCm2 = 0.0;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< [m]
};

struct FiberFigures {
  double lengthCm = 0.0;              ///< mean of the traced fibres
  double lengthSdCm = 0.0;            ///< standard deviation
  std::int64_t traced = 0;            ///< how many
  double angleToCurveDeg = 0.0;       ///< mean over tets on the curves
  double interiorExtremaShare = 0.0;  ///< of the muscle's vertices
  double spreadShare = 0.0;           ///< of the volume: directions taken from neighbours
};

struct TissueFigures {
  std::int32_t id = 0;
  std::string name;
  std::string kind;   ///< "fat", "muscle" or "filler"
  std::string side;   ///< as in the project; may be empty
  std::string group;  ///< as in the project; may be empty
  std::string file;   ///< surface, relative to the report; empty where none was written
  double volumeCm3 = 0.0;
  double areaCm2 = 0.0;
  std::int64_t components = 0;
  std::int64_t tets = 0;
  std::vector<AttachmentFigures> attachments;
  std::optional<FiberFigures> fibers;
};

struct QualityFigures {
  double minDihedralDeg = 0.0;
  double maxDihedralDeg = 0.0;
  /// Tets by smallest dihedral angle: below 1, 5, 10, 20, 30 degrees and above.
  std::vector<std::int64_t> minDihedralHistogram;
  double smallestVolume = 0.0;  ///< [m³]
};

/// What cutting along the largest field did to get there.
struct EnvelopeFigures {
  std::int64_t newVertices = 0;
  std::int64_t clampedVertices = 0;   ///< kept from the ends of their edges and the rims of faces
  std::int64_t repairedVertices = 0;  ///< moved further, for volume
  std::int64_t rebuiltTets = 0;       ///< of the domain, cut anew because moving was not enough
  std::int64_t nonPositiveAt32Bits = 0;  ///< tets without volume if coordinates are rounded so
  std::int64_t offLabelTets = 0;         ///< another field is the largest at the centroid
  double offLabelShare = 0.0;            ///< of the volume
  std::int64_t offLabelUnexplained = 0;  ///< neither clamped, repaired nor an island's
  std::int64_t islands = 0;              ///< given to their neighbours
  double islandShare = 0.0;              ///< of the volume
  std::int64_t fatPockets = 0;           ///< pieces of fat beyond the first
};

struct MachineFigures {
  std::string processor;
  std::int64_t cores = 0;
  std::int64_t threads = 0;
  std::string blas;
};

/// Everything that report.json says.
struct Report {
  std::string program;  ///< "ecorche 0.1.0"
  std::string project;
  std::string sourceUnit;  ///< of the project; the report itself is in the units that its keys name
  double skinDiagonal = 0.0;  ///< [m]
  double domainVolumeCm3 = 0.0;
  std::int64_t domainTets = 0;
  std::int64_t domainVertices = 0;
  std::int64_t freeVertices = 0;
  std::int64_t tets = 0;
  std::int64_t vertices = 0;
  std::vector<TissueFigures> tissues;
  /// Share of the domain's tets that hold 1, 2, 3 … tissues.
  std::vector<double> tissuesPerTet;
  EnvelopeFigures envelope;
  QualityFigures quality;
  std::vector<Check> checks;
  std::vector<FaceReference> references;  ///< of the triangles in anatomy.mesh
  Findings findings;
  std::vector<RunContext::StageTime> stages;
  double totalSeconds = 0.0;  ///< wall time from files to files; stages may hold stages
  std::int64_t peakMemoryBytes = 0;
  std::int64_t peakWorkerMemoryBytes = 0;
  MachineFigures machine;
};

/// JSON text, two spaces of indentation, ending in a line break; numbers read back to the same
/// bits.
[[nodiscard]] std::string printReport(const Report& report);
/// @param file  for the place in errors only
/// @errors FileSyntax, MissingKey, WrongType
[[nodiscard]] Result<Report> parseReport(const std::string& json, const std::string& file);

/// @errors FileNotWritable
[[nodiscard]] Result<void> writeReport(const std::filesystem::path& file, const Report& report);
/// @errors FileMissing, FileNotReadable, FileEmpty and those of parseReport
[[nodiscard]] Result<Report> readReport(const std::filesystem::path& file);

/// What the terminal shows: muscles, quality, checks, stages, findings. UTF-8, lines of at most 120
/// columns or so.
[[nodiscard]] std::string reportTable(const Report& report);
/// The lines of the checks alone.
[[nodiscard]] std::string checkTable(const std::vector<Check>& checks);

}  // namespace ecorche::exchange
