#pragma once

#include <ecorche/core/result.h>
#include <ecorche/exchange/anatomy_file.h>

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace ecorche::exchange {

/// A tissue's curve as a poly-line, origin first [m].
struct CurveRecord {
  std::string name;
  std::vector<Eigen::Vector3d> points;
};

struct TissueRecord {
  std::int32_t id = 0;
  std::string name;
  std::string kind;  ///< "fat", "muscle" or "filler"
  std::string file;  ///< its surface, relative to the folder; empty where none was written
  std::vector<CurveRecord> curves;
};

struct SurfaceRecord {
  std::string name;
  std::string kind;  ///< "skin", "bone", "obstacle" or "cavity"
  std::string file;  ///< relative to the folder
};

struct PlaneRecord {
  std::string name;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();    // [m]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  // unit, into the kept half
};

/// model.json: what an output folder was made from, in metres, as far as its checks need it.
/// Readable on its own: curves, planes, and which file holds what.
struct ModelRecord {
  double skinDiagonal = 0.0;          ///< [m]
  double surfaceTolerance = 0.001;    ///< share of the diagonal that skin and bones may be off
  std::vector<TissueRecord> tissues;  ///< ascending ids
  std::vector<SurfaceRecord> surfaces;
  std::vector<PlaneRecord> planes;
  std::vector<FaceReference> references;  ///< of the triangles in anatomy.mesh; empty without it
};

[[nodiscard]] std::string printModelRecord(const ModelRecord& record);
/// @errors FileMissing, FileNotReadable, FileEmpty, FileSyntax, MissingKey, WrongType
[[nodiscard]] Result<ModelRecord> readModelRecord(const std::filesystem::path& file);

/// The same from text. @param file  for messages
[[nodiscard]] Result<ModelRecord> parseModelRecord(std::string_view text, const std::string& file);

}  // namespace ecorche::exchange
