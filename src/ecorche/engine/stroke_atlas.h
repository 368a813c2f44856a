#pragma once

#include <ecorche/authoring/snap.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_query.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace ecorche::engine {

/// A muscle that somebody modelled, from one attachment to another.
struct KnownMuscle {
  std::string name;
  std::string from, to;                   ///< bones
  int fromBone = -1, toBone = -1;         ///< places in the atlas' bones
  mesh::Vector3 origin, insertion;        ///< on these bones, nearest to the patches' centres [m]
  std::vector<mesh::Vector3> centreline;  ///< centrelineOf [m]
  double length = 0.0;                    ///< of the centreline [m]
  bool single = false;                    ///< its only way: one origin and one insertion
};

/// A body with its muscles as somebody modelled them.
struct StrokeAtlas {
  std::shared_ptr<const mesh::SurfaceQuery> skin;
  std::vector<authoring::BoneSurface> bones;
  double diagonal = 0.0;  ///< of the skin [m]
  std::vector<KnownMuscle> muscles;
  std::vector<std::string> leftOut;  ///< muscles or heads, and why
};

/// Reads SKINbody.stl, bones/, muscles/, sites/ and attachment_sites.csv [m]; muscles of the right
/// side, which mirror the left one's, are not taken. Which attachments belong together is
/// authoring::planHeads' choice, as for `new`. Left out are ways that end on no bone, or within
/// bone or skin, and sheets so curved that their centreline does not lie in them.
/// @errors  those of readMesh and readAttachments; FileMissing; Cancelled
[[nodiscard]] Result<StrokeAtlas> readStrokeAtlas(const std::filesystem::path& folder,
                                                  RunContext& run);

}  // namespace ecorche::engine
