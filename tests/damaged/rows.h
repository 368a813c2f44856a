#pragma once

#include <ecorche/domain/build_domain.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "damaged/damage.h"

namespace ecorche::test {

/// What a domain is made from, and what it should be like.
struct Made {
  domain::DomainInput input;  ///< damaged
  domain::DomainInput truth;  ///< what was meant: closed, outward meshes that may overlap
  Findings asked;             ///< of repairs that were asked for beforehand
};

/// One damaged input and what has to become of it.
struct Row {
  std::string name;
  std::function<Made()> make;
  std::optional<ErrorCode> error;  ///< the exact code; unset: a valid domain
  std::vector<std::string> told;   ///< kinds of all findings, in any order, each once
  /// What nobody can know of the volume besides the stated deviation [m³].
  double slack = 0.0;
  double sizeRel = 1.0;  ///< of the whole thing against a limb of 30 cm
};

/// Rows in the making.
struct RowList {
  std::vector<Row> rows;

  /// One that becomes a valid domain.
  void add(std::string name, std::function<Made()> make, std::vector<std::string> told = {},
           double slack = 0.0, double sizeRel = 1.0) {
    rows.push_back(
        {std::move(name), std::move(make), std::nullopt, std::move(told), slack, sizeRel});
  }
  /// One that ends in an error.
  void refuse(std::string name, std::function<Made()> make, ErrorCode code) {
    rows.push_back({std::move(name), std::move(make), code, {}});
  }
};

// The limb that is damaged: an egg of 10 × 9 × 30 cm around two bones, one above the other.
[[nodiscard]] SurfaceMesh goodSkin();
[[nodiscard]] SurfaceMesh goodHumerus();
[[nodiscard]] SurfaceMesh goodUlna();
[[nodiscard]] domain::DomainInput goodLimb();

/// The good limb with another skin; the truth stays the good one unless given.
[[nodiscard]] Made withSkin(SurfaceMesh skin);
[[nodiscard]] Made withSkin(SurfaceMesh skin, SurfaceMesh meant);
/// The good limb with other bones; meant defaults to the same.
[[nodiscard]] Made withBones(std::vector<SurfaceMesh> bones);
[[nodiscard]] Made withBones(std::vector<SurfaceMesh> bones, std::vector<SurfaceMesh> meant);

[[nodiscard]] std::vector<Row> skinRows();
[[nodiscard]] std::vector<Row> boneRows();
[[nodiscard]] std::vector<Row> togetherRows();

}  // namespace ecorche::test
