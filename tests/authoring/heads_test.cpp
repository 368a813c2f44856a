// Which sites of a muscle its curves run between.

#include <ecorche/authoring/muscle_choice.h>
#include <ecorche/authoring/muscle_heads.h>
#include <ecorche/core/files.h>

#include <catch2/catch.hpp>

#include "support/paths.h"

using namespace ecorche;
using namespace ecorche::authoring;
using mesh::Vector3;
using Role = model::Attachment::Role;

namespace {

/// Sites of one muscle; those on the same bone share its number.
struct Muscle {
  std::vector<AttachmentSite> sites;
  std::vector<Seat> seats;

  Muscle& at(const char* name, const Vector3& p, int bone, Role role = Role::Unknown) {
    sites.push_back({.muscle = "m", .bone = name, .role = role, .at = p, .patchFile = {}});
    seats.push_back({p, {}, bone, true});
    return *this;
  }
  [[nodiscard]] std::vector<HeadPlan> heads() const {
    return planHeads(sites, seats, Vector3::Zero());
  }
};

using Places = std::vector<std::size_t>;

}  // namespace

TEST_CASE("bones of one row are of one kind") {
  CHECK(boneKind("Rib_L_3") == "rib");
  CHECK(boneKind("Rib_R_12") == boneKind("rib-left 1"));
  CHECK(boneKind("Phalanx_distalis_digiti_IV_L") == "phalanxdistalisdigiti");
  CHECK(boneKind("Skull_1L") == "skull");
  CHECK(boneKind("C-1") == "c");
  CHECK(boneKind("-1") == "-1");
}

TEST_CASE("two sites make one curve, from the one nearer to the middle of the body") {
  const auto heads = Muscle().at("tibia", {0, 0, -2}, 0).at("pelvis", {0, 0, -1}, 1).heads();
  REQUIRE(heads.size() == 1);
  CHECK(heads[0].from == 1);
  CHECK(heads[0].to == 0);
  CHECK(Muscle().at("tibia", {0, 0, -2}, 0).heads().empty());
  CHECK(Muscle().at("a", {1, 0, 0}, 0).at("b", {1, 0, 0}, 1).heads().empty());
}

TEST_CASE("roles decide where the table tells them") {
  const auto heads = Muscle()
                         .at("tibia", {0, 0, -2}, 0, Role::Origin)
                         .at("pelvis", {0, 0, -1}, 1, Role::Insertion)
                         .heads();
  REQUIRE(heads.size() == 1);
  CHECK(heads[0].from == 0);
}

TEST_CASE("a row of bones along the way is passed from its far end") {
  // A psoas: loin vertebrae towards the femur, in any order
  const auto heads = Muscle()
                         .at("L_2", {0, 0, 0.1}, 2)
                         .at("femur", {0, 0.02, -0.25}, 0)
                         .at("L_1", {0, 0, 0.2}, 1)
                         .at("L_3", {0, 0, 0.0}, 3)
                         .heads();
  REQUIRE(heads.size() == 1);
  CHECK(heads[0].from == 2);
  CHECK(heads[0].along == Places{0, 3});
  CHECK(heads[0].to == 1);
}

TEST_CASE("a row of bones across the way is a fan") {
  // A serratus: ribs side by side, all to the scapula
  Muscle serratus;
  serratus.at("scapula", {0, 0, 0.2}, 0);
  for (int rib = 0; rib < 5; ++rib) serratus.at("rib_1", {0.1 * (rib - 2), 0, 0}, 1);
  const auto heads = serratus.heads();
  REQUIRE(heads.size() == 3);
  Places ribs;
  for (const HeadPlan& head : heads) {
    CHECK((head.from == 0 || head.to == 0));
    CHECK(head.along.empty());
    ribs.push_back(head.from == 0 ? head.to : head.from);
  }
  std::ranges::sort(ribs);
  CHECK(ribs == Places{1, 3, 5});
}

TEST_CASE("curves between two fans do not cross") {
  Muscle sheet;
  for (int k = 0; k < 3; ++k) sheet.at("rib", {0.1 * k, 0, 0}, 0);
  for (int k = 2; k >= 0; --k) sheet.at("sternum", {0.1 * k, 0, -0.1}, 1);
  const auto heads = sheet.heads();
  REQUIRE(heads.size() == 3);
  for (const HeadPlan& head : heads)
    CHECK(sheet.seats[head.from].at.x() == sheet.seats[head.to].at.x());
}

TEST_CASE("no bone has both ends of a muscle if that can be") {
  // A pectoralis: ribs and sternum are one mesh, and lie farther apart than ribs and humerus
  Muscle pectoralis;
  for (int k = 0; k < 4; ++k) {
    pectoralis.at("rib", {0.1 * k, 0.2, 0}, 0);
    pectoralis.at("sternum", {0.1 * k, 0, 0}, 0);
  }
  pectoralis.at("humerus", {0, 0.25, 0.02}, 1);
  for (const HeadPlan& head : pectoralis.heads()) CHECK((head.from == 8) != (head.to == 8));
}

TEST_CASE("a plan of mirrored sites is the mirrored plan") {
  Muscle left, right;
  const auto both = [&](const char* name, const Vector3& p, int bone) {
    left.at(name, p, bone);
    right.at(name, {p.x(), -p.y(), p.z()}, bone);
  };
  for (int k = 0; k < 4; ++k) both("rib", {0.1 * k, 0.1, 0.03 * k * k}, k);
  both("scapula_1", {0.1, 0.2, 0.3}, 9);
  both("scapula_2", {0.2, 0.2, 0.3}, 9);
  const auto a = left.heads(), b = right.heads();
  REQUIRE(a.size() == b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    CHECK(a[k].from == b[k].from);
    CHECK(a[k].to == b[k].to);
    CHECK(a[k].along == b[k].along);
  }
}

TEST_CASE("two muscles under one name are parted, one with wide ends is not") {
  const auto muscle = [](std::initializer_list<std::pair<const char*, Vector3>> sites) {
    MuscleSites out{"flexor_L", {}};
    for (const auto& [bone, at] : sites)
      out.sites.push_back({.muscle = "flexor_L", .bone = bone, .at = at, .patchFile = {}});
    return out;
  };
  const MuscleSites two = muscle({{"humerus", {0.5, 0, 0}},
                                  {"tibia", {-0.5, 0, 0}},
                                  {"finger_1", {0.5, 0, -0.5}},
                                  {"toe_1", {-0.5, 0, -0.5}}});
  Findings findings;
  const auto parted = partedMuscles({two}, 1.5, findings);
  REQUIRE(parted.size() == 2);
  REQUIRE(findings.size() == 1);
  CHECK(findings[0].kind == "two-muscles");
  CHECK(parted[0].muscle == "flexor_L");
  CHECK(parted[1].muscle == "flexor_L_2");
  for (const MuscleSites& each : parted) {
    REQUIRE(each.sites.size() == 2);
    CHECK(each.sites[0].at.x() == each.sites[1].at.x());
  }

  const MuscleSites one = muscle({{"humerus", {0, 0, 0}},
                                  {"ulna", {0.02, 0, -0.05}},
                                  {"finger_1", {0, 0, -0.5}},
                                  {"carpal", {0, 0.02, -0.45}}});
  CHECK(partedMuscles({one}, 1.5, findings).size() == 1);
}

TEST_CASE("muscles are chosen by name, on both sides where none is told") {
  const std::vector<MuscleSites> table = {
      {"sartorius_L", {}}, {"gracilis_L", {}}, {"sartorius_R", {}}, {"brachiocephalicus", {}}};
  const auto names = [&](const std::vector<std::string>& wanted) {
    std::vector<std::string> out;
    const auto chosen = chosenMuscles(table, wanted).value();
    for (const MuscleSites& muscle : chosen) out.push_back(muscle.muscle);
    return out;
  };
  using Names = std::vector<std::string>;
  CHECK(names({"Sartorius"}) == Names{"sartorius_L", "sartorius_R"});
  CHECK(names({"brachiocephalicus", "gracilis l", "sartorius_R"}) ==
        Names{"gracilis_L", "sartorius_R", "brachiocephalicus"});
  const auto unknown = chosenMuscles(table, {"sartorus"});
  REQUIRE_FALSE(unknown);
  CHECK(unknown.error().code == ErrorCode::UnknownName);
  CHECK(unknown.error().message.find("sartorius_L") != std::string::npos);

  CHECK(muscleNamesFrom(" a, b ,,c").value() == Names{"a", "b", "c"});
  const test::TempFolder temp;
  const auto file = temp.path() / "list.txt";
  REQUIRE(writeFileWhole(file, "# thigh\nsartorius_L  # long\n\ngracilis\r\n"));
  CHECK(muscleNamesFrom(file.string()).value() == Names{"sartorius_L", "gracilis"});
  REQUIRE(writeFileWhole(file, "# nothing\n"));
  CHECK(muscleNamesFrom(file.string()).error().code == ErrorCode::FileEmpty);
}
