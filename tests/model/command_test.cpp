#include <ecorche/model/command_text.h>
#include <ecorche/model/history.h>
#include <ecorche/model/project_check.h>
#include <ecorche/model/project_file.h>

#include <rapidcheck/catch.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "model/generate.h"
#include "model/sample_project.h"

using namespace ecorche;
using namespace ecorche::model;

namespace {

Project sample() { return parseProject(test::kFullProject, "p/forearm.ecorche").value(); }

/// The sample after a line of text, which has to work.
Project after(const Project& before, std::string_view line) {
  const auto command = parseCommand(line);
  INFO(line);
  if (!command) FAIL(command.error().text());
  auto result = apply(before, *command);
  if (!result) FAIL(result.error().text());
  return *result;
}
Project after(std::string_view line) { return after(sample(), line); }

Error refusal(std::string_view line) {
  const auto command = parseCommand(line);
  if (!command) return command.error();
  const auto result = apply(sample(), *command);
  INFO(line);
  REQUIRE_FALSE(result);
  return result.error();
}

const Tissue& tissueOf(const Project& project, std::string_view name) {
  return project.tissues[findTissue(project, name).value()];
}

}  // namespace

TEST_CASE("the line of the design adds a curve") {
  const Project p = after(after("muscle.add brachialis"),
                          "curve.add brachialis 0.02,0.31,0.05 0.03,0.24,0.06 tissue=1.2");
  const Tissue& muscle = tissueOf(p, "brachialis");
  REQUIRE(muscle.curves.size() == 1);
  CHECK(muscle.curves[0].points[1] == ControlPoint{{0.03, 0.24, 0.06}, 1.2});
  CHECK(parseProject(projectText(p), "p/forearm.ecorche").value() == p);
}

TEST_CASE("every command is found by its text and does what it says") {
  CHECK(after("project.name \"left arm\"").name == "left arm");
  CHECK(after("project.unit mm").unit == Unit::Millimetre);
  CHECK(after("skin.set new.obj part=body unit=in").skin == MeshRef{"new.obj", "body", Unit::Inch});
  CHECK(after("bone.add ulna ulna.stl").bones.back().name == "ulna");
  CHECK(after("plane.add wrist region 0,0,0.5 0,0,-2").cutPlanes.back().normal ==
        Vector3(0, 0, -1));
  CHECK(after("fat.set 0").settings.fat == 0.0);
  CHECK(tissueOf(after("fat.colour #010203"), "fat").colour == Colour{1, 2, 3});
  CHECK(after("settings.core_radius none").settings.coreRadius == std::nullopt);
  CHECK(after("settings.alpha 5").settings.coreRadius == std::nullopt);
  CHECK(after("settings.edge_length 0.004").settings.tets == std::nullopt);
  CHECK(after("settings.surface_tolerance 0.01").settings.surfaceTolerance == 0.01);
  CHECK(tissueOf(after("muscle.colour biceps none"), "biceps").colour == std::nullopt);
  CHECK(tissueOf(after("muscle.side biceps right"), "biceps").side == Side::Right);
  CHECK(tissueOf(after("muscle.group biceps flexors"), "biceps").group == "flexors");
  CHECK(tissueOf(after("muscle.layer biceps 3"), "biceps").layer == 3);
  CHECK(tissueOf(after("muscle.protect biceps on"), "biceps").isProtected);
  CHECK_FALSE(tissueOf(after("muscle.keep_twin biceps off"), "biceps").keepsTwin);
  CHECK(tissueOf(after("muscle.core biceps 0.002"), "biceps").coreRadius == 0.002);
  CHECK(tissueOf(after("muscle.anisotropy biceps 3 0.25 0.5"), "biceps").anisotropy ==
        Anisotropy{3, 0.25, 0.5});
  CHECK(tissueOf(after("curve.move biceps 2 0,0,0.01"), "biceps").curves[1].points[1].at ==
        Vector3(0.04, 0.04, 0.08));
  CHECK(tissueOf(after("curve.start biceps 2 free"), "biceps").curves[1].start == Support{});
  CHECK(tissueOf(after("curve.end biceps 1 bone:humerus"), "biceps").curves[0].end.name ==
        "humerus");
  CHECK(tissueOf(after("curve.points biceps 1 0,0,0 0,0,1 tissue=1,2"), "biceps")
            .curves[0]
            .points[1]
            .tissue == 2.0);
  CHECK(tissueOf(after("curve.rename biceps 1 caput"), "biceps").curves[0].name == "caput");
  CHECK(tissueOf(after("curve.remove biceps 1"), "biceps").curves.size() == 1);
  CHECK(tissueOf(after("point.move biceps 1 2 0.1,0.2,0.3"), "biceps").curves[0].points[1].at ==
        Vector3(0.1, 0.2, 0.3));
  CHECK(tissueOf(after("point.insert biceps 1 4 0.1,0.2,0.3 tissue=2"), "biceps")
            .curves[0]
            .points[3]
            .tissue == 2.0);
  CHECK(tissueOf(after("point.remove biceps 1 2"), "biceps").curves[0].points.size() == 2);
  CHECK(tissueOf(after("point.value biceps 1 2 0.5"), "biceps").curves[0].points[1].tissue == 0.5);
  CHECK(tissueOf(after("attachment.add biceps origin bone:humerus at=1,2,3"), "biceps")
            .attachments.size() == 3);
  CHECK(tissueOf(after("attachment.remove biceps 1"), "biceps").attachments.size() == 1);
  CHECK(after("filler.add gut").tissues.back().kind == Tissue::Kind::Filler);
  CHECK(after("obstacle.add liver liver.obj").tissues.back().mesh->file == "liver.obj");
  CHECK(after("cavity.add chest chest.obj").tissues.back().kind == Tissue::Kind::Cavity);
}

TEST_CASE("what sits on a thing follows its name and is set free by its removal") {
  const Project renamed = after("bone.rename humerus \"upper arm\"");
  CHECK(tissueOf(renamed, "biceps").curves[0].start.name == "upper arm");
  CHECK(tissueOf(renamed, "biceps").attachments[0].support.name == "upper arm");
  const Project removed = after("muscle.remove belly");
  CHECK(tissueOf(removed, "biceps").curves[1].end == Support{});
  CHECK(tissueOf(after("plane.remove median"), "biceps").curves[1].start == Support{});
}

TEST_CASE("a command that would break the project says why and changes nothing") {
  CHECK(refusal("muscle.remove quadriceps").code == ErrorCode::UnknownName);
  CHECK(refusal("muscle.add biceps").code == ErrorCode::DuplicateName);
  CHECK(refusal("muscle.add \"\"").code == ErrorCode::MissingKey);
  CHECK(refusal("curve.remove biceps 3").code == ErrorCode::ValueOutOfRange);
  CHECK(refusal("point.move biceps 1 9 0,0,0").message ==
        "there is no control point 9 in \"biceps\", curve 1 (long head); the last is 3");
  CHECK(refusal("point.value biceps 1 1 0").code == ErrorCode::ValueOutOfRange);
  CHECK(refusal("point.move biceps 1 2 0.01,0.02,0.03").code == ErrorCode::ZeroLengthCurve);
  CHECK(refusal("curve.end biceps 1 bone:ulna").code == ErrorCode::UnknownName);
  CHECK(refusal("curve.add spleen 0,0,0 0,0,1").code == ErrorCode::WrongType);
  CHECK(refusal("muscle.side fat left").code == ErrorCode::WrongType);
  CHECK(refusal("fat.set -1").code == ErrorCode::ValueOutOfRange);
  CHECK(refusal("muscle.layer biceps -5").code == ErrorCode::ValueOutOfRange);
}

TEST_CASE("a protected tissue keeps its body and may change its looks") {
  const Project kept = after("muscle.protect biceps on");
  for (const char* line :
       {"point.move biceps 1 2 0.1,0.2,0.3", "point.value biceps 1 2 0.5", "curve.remove biceps 1",
        "muscle.core biceps 0.002", "muscle.anisotropy biceps 3 0.25 0.5", "muscle.remove biceps",
        "muscle.rename biceps brachii", "attachment.remove biceps 1"}) {
    INFO(line);
    const auto done = apply(kept, parseCommand(line).value());
    REQUIRE_FALSE(done);
    CHECK(done.error().code == ErrorCode::TissueProtected);
    CHECK(done.error().message ==
          "\"biceps\" is protected; lift that first: muscle.protect biceps off");
  }
  for (const char* line : {"muscle.colour biceps none", "muscle.side biceps right",
                           "muscle.group biceps flexors", "muscle.layer biceps 3", "fat.set 0"}) {
    INFO(line);
    CHECK(apply(kept, parseCommand(line).value()));
  }
  const Project lifted = apply(kept, parseCommand("muscle.protect biceps off").value()).value();
  CHECK(apply(lifted, parseCommand("muscle.remove biceps").value()));
}

TEST_CASE("a line that is no command says what is wrong with which word") {
  const std::vector<std::pair<const char*, const char*>> cases = {
      {"muscle.praise biceps", "1: there is no command \"muscle.praise\""},
      {"", "1: there is no command here"},
      {"fat.set", "8: VALUE is missing; write: fat.set VALUE"},
      {"fat.set much", "9: \"much\" is not a number; write: fat.set VALUE"},
      {"fat.set 1 2", "11: \"2\" is too much"},
      {"fat.set 1 tissue=2", "11: \"tissue=2\" is too much"},
      {"fat.set nan", "9: \"nan\" is not a number"},
      {"point.move biceps 0 1 0,0,0", "19: \"0\" is not a number from 1"},
      {"point.move biceps 1 1 0,0",
       "23: \"0,0\" is not x,y,z; write: point.move MUSCLE CURVE POINT X,Y,Z"},
      {"curve.add biceps", "17: X,Y,Z is missing"},
      {"curve.add biceps end=bone:radius here", "34: \"here\" is not x,y,z"},
      {"curve.add biceps 0,0,0 0,0,1 tissue=1,2,3", "30: \"1,2,3\" is not one tissue value or 2"},
      {"curve.end biceps 1 skull", "20: \"skull\" is not bone:NAME"},
      {"muscle.colour biceps red", "22: \"red\" is not a colour"},
      {"muscle.add \"open", "12: a quotation mark is not closed"},
      {"muscle.add \"a\\z\"", "14: \"\\z\" means nothing"},
      {"project.unit furlong", "14: \"furlong\" is not a unit"},
  };
  for (const auto& [line, message] : cases) {
    const auto command = parseCommand(line);
    INFO(line);
    REQUIRE_FALSE(command);
    CHECK(command.error().code == ErrorCode::CommandSyntax);
    const std::string text =
        std::to_string(command.error().place.column) + ": " + command.error().message;
    CHECK(text.substr(0, std::string_view(message).size()) == message);
  }
}

TEST_CASE("a script is read whole, comments and empty lines aside") {
  const auto script = parseScript("# first steps\n\n  muscle.add a\r\n\tfat.set 0.5", "s.txt");
  REQUIRE(script);
  REQUIRE(script->size() == 2);
  CHECK((*script)[1].line == 4);
  CHECK((*script)[0].command == Command(AddMuscle{"a"}));
  CHECK(parseScript("fat.set 1\nfat.set\n", "s.txt").error().text() ==
        "s.txt:2:8: VALUE is missing; write: fat.set VALUE");
}

TEST_CASE("verbs are unique and their usage starts with them") {
  std::set<std::string> verbs;
  for (const std::string& usage : commandUsages()) verbs.insert(usage.substr(0, usage.find(' ')));
  CHECK(verbs.size() == commandUsages().size());
  CHECK(verbs.size() == std::variant_size_v<Command::Act>);
}

TEST_CASE("text and commands") {
  rc::prop("parsing what was formatted gives the command back", [] {
    const Command command = test::anyCommand();
    const std::string text = formatCommand(command);
    RC_LOG(text);
    const auto again = parseCommand(text);
    if (!again) RC_FAIL(again.error().text());
    RC_ASSERT(*again == command);
    RC_ASSERT(text.find('\n') == std::string::npos);
  });
  rc::prop("any text gives a command or an error", [](const std::string& text) {
    (void)parseCommand(text);
    (void)parseCommand("curve.add " + text);
    (void)parseScript(text, "s");
  });
}

TEST_CASE("history") {
  rc::prop("undo gives back what was, redo what was undone", [] {
    History history(sample());
    std::vector<Project> states = {history.project()};
    for (int k = 0; k < 60; ++k) {
      const Command command = test::anyCommand();
      if (!history.perform(command)) {
        RC_ASSERT(history.project() == states.back());
        continue;
      }
      states.push_back(history.project());
      RC_ASSERT(findFault(states.back(), Completeness::Editing) == std::nullopt);
    }
    RC_ASSERT(history.performed().size() + 1 == states.size());
    for (std::size_t k = states.size() - 1; k > 0; --k) {
      history.undo();
      RC_ASSERT(history.project() == states[k - 1]);
    }
    RC_ASSERT(!history.canUndo());
    for (std::size_t k = 1; k < states.size(); ++k) {
      history.redo();
      RC_ASSERT(history.project() == states[k]);
    }
    RC_ASSERT(!history.canRedo());
  });
  rc::prop("what extends a step is undone with it, all of it or none", [] {
    History history(sample());
    std::vector<Project> states = {history.project()};
    for (int k = 0; k < 40; ++k) {
      if (!history.perform(test::anyCommand())) continue;
      std::vector<Command> more;
      for (int i = *rc::gen::inRange(0, 4); i > 0; --i) more.push_back(test::anyCommand());
      const Project before = history.project();
      const std::size_t steps = history.stepsDone();
      if (!history.extend(more)) RC_ASSERT(history.project() == before);
      RC_ASSERT(history.stepsDone() == steps);
      states.push_back(history.project());
    }
    for (std::size_t k = states.size() - 1; k > 0; --k) {
      history.undo();
      RC_ASSERT(history.project() == states[k - 1]);
    }
    for (std::size_t k = 1; k < states.size(); ++k) {
      history.redo();
      RC_ASSERT(history.project() == states[k]);
    }
  });
  rc::prop("several commands in one step are undone at once, and done all or not at all", [] {
    History history(sample());
    std::vector<Project> states = {history.project()};
    for (int k = 0; k < 30; ++k) {
      std::vector<Command> step;
      for (int i = *rc::gen::inRange(1, 6); i > 0; --i) step.push_back(test::anyCommand());
      Project after = states.back();
      bool all = true;
      for (const Command& command : step) {
        auto next = apply(after, command);
        all = next.has_value();
        if (!all) break;
        after = std::move(*next);
      }
      RC_ASSERT(history.perform(step, "step").has_value() == all);
      if (all) states.push_back(after);
      RC_ASSERT(history.project() == states.back());
      RC_ASSERT(history.stepsDone() + 1 == states.size());
    }
    Project replayed = sample();
    for (const Command& command : history.performed()) replayed = *apply(replayed, command);
    RC_ASSERT(replayed == states.back());
    for (std::size_t k = states.size() - 1; k > 0; --k) {
      history.undo();
      RC_ASSERT(history.project() == states[k - 1]);
    }
    for (std::size_t k = 1; k < states.size(); ++k) {
      history.redo();
      RC_ASSERT(history.project() == states[k]);
    }
  });
  rc::prop("a past that is moved to another folder names the same meshes from there", [] {
    History history(sample());
    for (int k = 0; k < 40; ++k) (void)history.perform(test::anyCommand());
    std::vector<Project> states;
    const std::size_t steps = history.stepsDone();
    while (history.canUndo()) history.undo();
    for (std::size_t k = 0; k <= steps; ++k) {
      states.push_back(history.project());
      if (k < steps) history.redo();
    }
    const std::filesystem::path folder = "somewhere/else";
    history.moveTo(folder);
    for (std::size_t k = steps; k > 0; --k) {
      RC_ASSERT(history.project() == movedTo(states[k], folder));
      history.undo();
    }
    for (std::size_t k = 0; k < steps; ++k) {
      RC_ASSERT(history.project() == movedTo(states[k], folder));
      history.redo();
    }
  });
  rc::prop("a new act after some undoing forgets the undone and nothing else", [] {
    History history(sample());
    std::vector<Project> states = {history.project()};
    for (int round = 0; round < 120; ++round) {
      if (*rc::gen::inRange(0, 3) == 0 && history.canUndo()) {
        history.undo();
        states.pop_back();
      } else {
        REQUIRE(history.perform(SetFat{round * 0.01}));
        states.push_back(history.project());
      }
      RC_ASSERT(history.project() == states.back());
    }
    while (history.canUndo()) {
      history.undo();
      states.pop_back();
      RC_ASSERT(history.project() == states.back());
    }
  });
}

TEST_CASE("whatever commands make can be written and read") {
  rc::prop("a complete project survives its file", [] {
    Project project = sample();
    for (int k = 0; k < 40; ++k) {
      const auto next = apply(project, test::anyCommand());
      if (next) project = *next;
    }
    if (findFault(project)) return;  // a muscle without curves
    if (project.unit == Unit::Inch) project.unit = Unit::Metre;
    const auto again = parseProject(projectText(project), "p/forearm.ecorche");
    if (!again) RC_FAIL(again.error().text());
    // Degrees come to rest after the first writing
    RC_ASSERT(projectText(*again) == projectText(project));
    for (std::size_t k = 0; k < project.tissues.size(); ++k) {
      Tissue a = project.tissues[k], b = again->tissues[k];
      RC_ASSERT(std::abs(a.anisotropy.rotation - b.anisotropy.rotation) <=
                1e-15 * std::abs(a.anisotropy.rotation));
      a.anisotropy.rotation = b.anisotropy.rotation;
      RC_ASSERT(a == b);
    }
  });
}

TEST_CASE("any bytes give a project or an error with a place") {
  const auto check = [](const std::string& text) {
    const auto project = parseProject(text, "f.ecorche");
    if (project) {
      RC_ASSERT(findFault(*project) == std::nullopt);
    } else {
      RC_ASSERT(project.error().place.file == "f.ecorche");
      RC_ASSERT(!project.error().message.empty());
      RC_ASSERT(project.error().code == ErrorCode::FileEmpty || project.error().place.line > 0);
    }
  };
  rc::prop("random bytes", [&](const std::string& text) { check(text); });
  rc::prop("a project file with bytes changed, cut or doubled", [&] {
    std::string text(test::kFullProject);
    for (int k = *rc::gen::inRange(1, 4); k > 0; --k) {
      const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
      const auto many = *rc::gen::inRange<std::size_t>(1, 40);
      switch (*rc::gen::inRange(0, 5)) {
        case 0:
          text[at] = *rc::gen::arbitrary<char>();
          break;
        case 1:
          text.erase(at, many);
          break;
        case 2:
          text.insert(at, text.substr(at, many));
          break;
        case 3:
          text.resize(at + 1);
          break;
        default:
          text.insert(at, *rc::gen::element<std::string>("\"", "{", "]", ",", "-", "1e9", "null",
                                                         "[1,2,3]", "\xff"));
          break;
      }
    }
    check(text);
  });
}
