/// The command line of a program with parts of its own, examples/own_command_line.cpp: all
/// commands, its words.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/command.hpp"

namespace sightline {
namespace {

using test::fresh_folder;
using test::read_file;
using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

const std::string own_parts = "examples/own_parts.toml";

test::CommandResult own(const std::string& arguments, const fs::path& folder) {
  return test::shell("'" SIGHTLINE_EXAMPLES "/own_command_line' " + arguments, folder);
}

/// The scenario with another text in one place.
std::string with(const fs::path& folder, const std::string& what, const std::string& instead) {
  std::string text = read_file(fs::path(SIGHTLINE_SOURCE_DIR) / own_parts);
  const std::size_t place = text.find(what);
  EXPECT_NE(place, std::string::npos) << what;
  text.replace(place, what.size(), instead);
  const fs::path file = folder / "own.toml";
  std::ofstream(file) << text;
  return file.string();
}

/// What `check` says to it.
std::string refusal(const std::string& what, const std::string& instead) {
  const fs::path folder = fresh_folder();
  const auto result = own("check " + with(folder, what, instead), folder);
  EXPECT_EQ(result.code, 2);
  return result.err.substr(result.err.find("own.toml"));
}

TEST(OwnCommandLine, FliesAScenarioWithARobotAPotentialAndAReferenceOfItsOwn) {
  const fs::path folder = fresh_folder();
  const auto run = own("run " + own_parts + " -o " + (folder / "out").string(), folder);
  EXPECT_EQ(run.code, 0) << run.err;
  const auto summary = nlohmann::json::parse(read_file(folder / "out/summary.json"));
  EXPECT_EQ(summary.at("updates"), 1500);
  EXPECT_EQ(summary.at("not_finite"), 0);
  EXPECT_EQ(summary.at("allocations_per_update"), 0);
  EXPECT_EQ(summary.at("limits").at(0).at("name"), "halo uav-blimp");
  EXPECT_LT(summary.at("limits").at(0).at("fraction").get<double>(), 0.05);  // from 5 s on
  EXPECT_LT(summary.at("agents").at(0).at("rms_position_error").get<double>(), 0.5);

  EXPECT_EQ(own("report " + (folder / "out").string(), folder).code, 0);
  EXPECT_TRUE(fs::exists(folder / "out/report.html"));
}

TEST(OwnCommandLine, ASolverOfItsOwnFliesReplaysAndIsCompared) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  const std::string scenario =
      with(folder, "[simulation]\nduration = 15.0",
           "[solver]\nname = \"one_move\"\nrate = 0.1\n[simulation]\nduration = 6.0\n"
           "compare = [\"one_move\", \"cgmres\"]");
  const auto run = own("run " + scenario + " -o " + out.string(), folder);
  EXPECT_EQ(run.code, 0) << run.err;
  const auto summary = nlohmann::json::parse(read_file(out / "summary.json"));
  EXPECT_EQ(summary.at("solver"), "one_move");
  EXPECT_EQ(summary.at("updates"), 600);
  EXPECT_EQ(summary.at("allocations_per_update"), 0);
  EXPECT_TRUE(fs::exists(out / "cgmres/summary.json"));

  const auto replay = own("replay " + out.string(), folder);
  EXPECT_EQ(replay.code, 0) << replay.err;
  EXPECT_THAT(replay.out, HasSubstr("1200 commands, 0 differ"));
  const auto other_rate = own("replay " + out.string() + " --set solver.rate=0.3", folder);
  EXPECT_EQ(other_rate.code, 0) << other_rate.err;
  EXPECT_THAT(other_rate.out, AllOf(HasSubstr("1200 commands, 600 differ"), HasSubstr("u_0 of blimp")));
  // A program without it cannot read the log's scenario, and says which solvers it has.
  const auto without = test::sightline("replay " + out.string(), folder);
  EXPECT_EQ(without.code, 2);
  EXPECT_THAT(without.err, HasSubstr("expected one of"));

  const auto chosen = own("run " + own_parts + " --solver one_move --set simulation.duration=2.0 -o " +
                              (folder / "chosen").string(),
                          folder);
  EXPECT_EQ(chosen.code, 0) << chosen.err;
  EXPECT_EQ(nlohmann::json::parse(read_file(folder / "chosen/summary.json")).at("solver"), "one_move");
  EXPECT_EQ(own("replay " + (folder / "chosen").string(), folder).code, 0);
  EXPECT_EQ(own("run " + own_parts + " --solver two_moves -o " + (folder / "none").string(), folder).code, 2);
}

TEST(OwnCommandLine, WhatASolverOfItsOwnCannotDoIsRefused) {
  const auto solver = [](const std::string& keys) {
    return refusal("[simulation]", "[solver]\nname = \"one_move\"\n" + keys + "\n[simulation]");
  };
  EXPECT_EQ(solver("steps = 0"), "own.toml:23: solver.steps = 0, expected an integer, 1 to 100\n");
  EXPECT_EQ(solver("zeta = 1.0"), "own.toml:23: solver.zeta = 1, expected a known key: steps, rate, name\n");
  EXPECT_THAT(
      solver("[[event]]\nat = 1.0\nremove = { couple = \"beside\" }"),
      HasSubstr(
          "the team changes in flight, which the solver one_move cannot follow, expected newton_riccati"));
}

TEST(OwnCommandLine, EveryOtherCommandKnowsTheWordsToo) {
  const fs::path folder = fresh_folder();
  const auto check = own("check " + own_parts, folder);
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_THAT(check.out, HasSubstr("agent       blimp: blimp, 7 states, 3 inputs"));
  EXPECT_THAT(check.out, HasSubstr("couple      1 halo"));
  EXPECT_EQ(own("check --print " + own_parts, folder).code, 0);
  const auto explain = own("explain " + own_parts, folder);
  EXPECT_EQ(explain.code, 0) << explain.err;
  EXPECT_THAT(explain.out, HasSubstr("halo"));
  const auto potential = own("potential " + own_parts + " -o " + (folder / "potential").string(), folder);
  EXPECT_EQ(potential.code, 0) << potential.err;
  EXPECT_TRUE(fs::exists(folder / "potential/index.html"));
  EXPECT_EQ(own("version", folder).code, 0);

  const auto parts = own("parts --json", folder);
  EXPECT_EQ(parts.code, 0) << parts.err;
  const auto all = nlohmann::json::parse(parts.out);
  const auto& thrust = all.at("robot").at("blimp").at(0);
  EXPECT_EQ(thrust.at("key"), "thrust");
  EXPECT_EQ(thrust.at("unit"), "m/s^2");
  EXPECT_EQ(thrust.at("default"), "0.8");
  EXPECT_EQ(thrust.at("range"), "> 0");
  EXPECT_TRUE(all.at("potential").contains("halo") && all.at("potential").contains("sensor_cone"));
  EXPECT_EQ(all.at("reference").at("figure_eight").at(0).at("must_be_given"), true);
  EXPECT_THAT(own("parts", folder).out, HasSubstr("| `halo` | `d` | 2 m | > 0 | distance to keep |"));
}

TEST(OwnCommandLine, ACampaignReadsTheWordsAgainInEachOfItsRuns) {
  const fs::path folder = fresh_folder();
  const auto campaign =
      own("campaign " + own_parts + " --runs 4 --seed 3 -o " + (folder / "campaign").string(), folder);
  EXPECT_NE(campaign.code, 2) << campaign.err;
  EXPECT_TRUE(fs::exists(folder / "campaign/campaign.sqlite"));
  EXPECT_THAT(campaign.out, HasSubstr("4"));
  const auto one =
      own("campaign " + own_parts + " --runs 4 --seed 3 --only 2 -o " + (folder / "run").string(), folder);
  EXPECT_NE(one.code, 2) << one.err;
  EXPECT_TRUE(fs::exists(folder / "run/run.mcap"));
}

TEST(OwnCommandLine, WhatIsWrongWithAnOwnPartIsRefusedAtItsLine) {
  EXPECT_EQ(
      refusal("thrust = 1.0", "trhust = 1.0"),
      "own.toml:4: agent.blimp.parameters.trhust = 1, expected a known key, the nearest is \"thrust\"\n");
  EXPECT_EQ(refusal("thrust = 1.0", "thrust = 0.0"),
            "own.toml:4: agent.blimp.parameters.thrust = 0, expected > 0 m/s^2\n");
  EXPECT_EQ(
      refusal("centre = [0.0, 0.0, 2.0], ", ""),
      "own.toml:8: agent.blimp.reference.figure_eight.centre is missing, expected an array of 3 numbers\n");
}

TEST(OwnCommandLine, TheCommandLineOfTheLibraryDoesNotKnowThem) {
  const fs::path folder = fresh_folder();
  const auto check = test::sightline("check " + own_parts, folder);
  EXPECT_EQ(check.code, 2);
  EXPECT_THAT(check.err, HasSubstr("agent.blimp.robot = \"blimp\", expected one of"));
}

}  // namespace
}  // namespace sightline
