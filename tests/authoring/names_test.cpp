#include <ecorche/authoring/names.h>

#include <catch2/catch.hpp>

using namespace ecorche::authoring;
using ecorche::model::Side;

TEST_CASE("names come from file names as people meant them") {
  CHECK(boneNameFrom("x/BONEFemoris_L.stl") == "Femoris_L");
  CHECK(boneNameFrom("bones-left femur.obj") == "left_femur");
  CHECK(boneNameFrom("FemurL.obj") == "FemurL");
  CHECK(boneNameFrom("bone.obj") == "bone");
  CHECK(boneNameFrom("bones.obj") == "bones");
  CHECK(boneNameFrom("BONEScapula_L.stl") == "Scapula_L");
  CHECK(boneNameFrom("bonesFemur.stl") == "Femur");
  CHECK(boneNameFrom("BONEOs_metacarpale_V_L.001.stl") == "Os_metacarpale_V_L.001");
  CHECK(muscleNameFrom("MUSCm.biceps_femoris_L.stl") == "biceps_femoris_L");
  CHECK(muscleNameFrom("MUSCm_tensor_f.latae_L.stl") == "tensor_f.latae_L");
  CHECK(muscleNameFrom("MUSCm._sternohyroideus_L.stl") == "sternohyroideus_L");
  CHECK(muscleNameFrom("MUSCMm.thoracis_serratus_ventr_L.stl") == "thoracis_serratus_ventr_L");
  CHECK(muscleNameFrom("M. biceps brachii") == "biceps_brachii");
  CHECK(muscleNameFrom("masseter") == "masseter");
  CHECK(muscleNameFrom("  ").empty());
}

TEST_CASE("sides and mirrored names") {
  CHECK(sideFrom("sartorius_L2") == Side::Left);
  CHECK(sideFrom("sartorius right") == Side::Right);
  CHECK(sideFrom("biceps_femoris") == Side::Unknown);
  CHECK(sideFrom("L") == Side::Unknown);
  CHECK(sideFrom("") == Side::Unknown);
  CHECK(sideFrom("levator") == Side::Unknown);
  CHECK(mirroredName("sartorius_L2") == "sartorius_R2");
  CHECK(mirroredName("femur_right") == "femur_left");
  CHECK(mirroredName("femur Left") == "femur Right");
  CHECK(mirroredName("sternum") == std::nullopt);
  CHECK(withoutSide("sartorius_L2") == "sartorius_2");
  CHECK(bareName(withoutSide("sartorius_R")) == "sartorius");
  CHECK(withoutSide("sternum") == "sternum");
}

TEST_CASE("names that repeat are numbered, and numbers that are taken are passed by") {
  CHECK(madeUnique({"a", "b", "a", "a_2", "a"}) ==
        std::vector<std::string>{"a", "b", "a_3", "a_2", "a_4"});
  CHECK(bareName("C-1") == bareName("c_1"));
}
