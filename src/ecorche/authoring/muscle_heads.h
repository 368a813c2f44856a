#pragma once

#include <ecorche/authoring/attachments.h>
#include <ecorche/authoring/seats.h>
#include <ecorche/core/finding.h>

#include <string>
#include <string_view>
#include <vector>

namespace ecorche::authoring {

/// One curve to be drawn, in places of a list of sites.
struct HeadPlan {
  std::size_t from = 0;            ///< origin
  std::size_t to = 0;              ///< insertion
  std::vector<std::size_t> along;  ///< sites that it passes on its way, in order
};

/// Which sites of a muscle its curves run between.
///
/// Sites fall into two ends: by their roles where the table tells both, else by the kinds of bones
/// that they name (ribs, neck vertebrae, humerus ...), so that no bone has both ends if that can
/// be, and the two ends lie as far apart as they can. An end whose sites follow one another towards
/// the other end is a chain: the curve starts at its far end and passes the others. One whose sites
/// lie side by side is a fan: two or three curves leave from it. Of two ends the one nearer to
/// `centre` is the origin.
///
/// @param seats  of the sites; mirroring seats and centre mirrors the plan
/// @return  empty where no two sites are apart
[[nodiscard]] std::vector<HeadPlan> planHeads(const std::vector<AttachmentSite>& sites,
                                              const std::vector<Seat>& seats,
                                              const mesh::Vector3& centre);

/// The table with muscles that are two under one name parted (a flexor of the fingers and one of
/// the toes): those whose two ends have several kinds of bones each, at distances that are not much
/// less than the one between the ends. The second is called as the first with "_2" behind it.
/// @param findings  a note on each
[[nodiscard]] std::vector<MuscleSites> partedMuscles(const std::vector<MuscleSites>& table,
                                                     double diagonal, Findings& findings);

/// What kind of bone a site's bone is: its name in small letters without numbers and sides.
/// "Rib_L_3" and "Rib_R_12" are both "rib"; a name of nothing else stays as it is.
[[nodiscard]] std::string boneKind(std::string_view bone);

}  // namespace ecorche::authoring
