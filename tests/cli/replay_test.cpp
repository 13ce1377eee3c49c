#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/support/command.hpp"
#include "tests/support/copy_log.hpp"

namespace sightline::cli {
namespace {

using nlohmann::json;
using test::fresh_folder;
using test::read_file;
using test::sightline;
using testing::HasSubstr;
namespace fs = std::filesystem;

/// A shipped scenario, flown for so long [s] into folder/out.
void fly(const std::string& name, const std::string& duration, const fs::path& folder,
         const std::string& how = "") {
  const std::string text = read_file(fs::path(SIGHTLINE_SOURCE_DIR "/scenarios") / (name + ".toml"));
  const std::regex said("\\[simulation\\]\nduration = [0-9.]+");
  ASSERT_TRUE(std::regex_search(text, said));
  const fs::path file = folder / (name + ".toml");
  std::ofstream(file) << std::regex_replace(text, said, "[simulation]\nduration = " + duration);
  const auto run = sightline("run " + file.string() + " -o " + (folder / "out").string() + how, folder);
  ASSERT_NE(run.code, 2) << run.err;
}

std::string replay(const fs::path& folder, const std::string& how = "") {
  return "replay " + (folder / "out").string() + how;
}

TEST(Replay, SaysThatNoCommandDiffers) {
  const fs::path folder = fresh_folder();
  fly("cooperative_localization", "8.0", folder);
  const auto done = sightline(replay(folder), folder);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(done.out, "cooperative_localization: 800 updates, 1600 commands, 0 differ\n");
  EXPECT_EQ(done.err, "");
}

TEST(Replay, OfTheLastBitOfOneMeasurementTheUpdateIsNamed) {
  const fs::path folder = fresh_folder();
  fly("cooperative_localization", "8.0", folder);
  fs::create_directories(folder / "flipped");
  int flipped = 0;
  test::copy_log(folder / "out/run.mcap", folder / "flipped/run.mcap",
                 [&](std::string_view topic, std::string& text) {
                   if (topic != "/uav0/measurement" || !text.starts_with("{\"time\":4.5,")) return;
                   const std::size_t from = text.find("\"x\":[") + 5, end = text.find(',', from);
                   double x = 0.0;
                   std::from_chars(&text[from], &text[end], x);
                   x = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) ^ 1U);
                   char digits[32];
                   const auto last = std::to_chars(digits, digits + sizeof digits, x);
                   text.replace(from, end - from, digits, static_cast<std::size_t>(last.ptr - digits));
                   ++flipped;
                 });
  ASSERT_EQ(flipped, 1);
  const auto done = sightline("replay " + (folder / "flipped").string(), folder);
  EXPECT_EQ(done.code, 1);
  EXPECT_THAT(done.out, HasSubstr("update 450 at 4.5 s: u_"));
}

TEST(Replay, WithAnotherSolverOrOtherValuesTellsHowFarTheCommandsAre) {
  const fs::path folder = fresh_folder();
  fly("paper_7_1", "8.0", folder);
  const auto solver = sightline(replay(folder, " --solver cmscgmres --json"), folder);
  EXPECT_EQ(solver.code, 0) << solver.err;
  const json reported = json::parse(solver.out);
  EXPECT_EQ(reported.at("solver"), "cmscgmres");
  EXPECT_EQ(reported.at("updates"), 800);
  EXPECT_GT(reported.at("differing"), 1000);
  EXPECT_EQ(reported.at("robots").size(), 2U);
  EXPECT_GT(reported.at("robots")[0].at("rms").get<double>(), 1e-4);
  const auto set = sightline(replay(folder, " --set 'couple[0].weight=0.8' --set horizon.stages=10"), folder);
  EXPECT_EQ(set.code, 0) << set.err;
  EXPECT_THAT(set.out, HasSubstr("1600 commands, 1600 differ\nupdate 0 at 0 s: "));
  const auto same = sightline(replay(folder, " --set simulation.seed=7"), folder);
  EXPECT_THAT(same.out, HasSubstr("1600 commands, 0 differ")) << "chance is in the measurements";
}

TEST(Replay, OfATeamThatPlansInPartsTheSubteamsPlanAgain) {
  const fs::path folder = fresh_folder();
  fly("chain8", "3.0", folder,
      " --partition 'uav0,uav1,uav2,uav3 | uav4,uav5,uav6,uav7' --order jacobi --exchanges 2");
  EXPECT_EQ(sightline(replay(folder), folder).out, "chain8: 300 updates, 2400 commands, 0 differ\n");
  EXPECT_EQ(sightline("replay " + (folder / "out/whole").string(), folder).code, 0);
  EXPECT_THAT(sightline(replay(folder, " --solver newton_riccati"), folder).out, HasSubstr("differ\nupdate"));
}

TEST(Replay, OfAFlightUnderAnotherSolverThanTheScenariosThatOneFliesAgain) {
  const fs::path folder = fresh_folder();
  fly("paper_7_1", "3.0", folder, " --solver cgmres --seed 4");
  EXPECT_THAT(sightline(replay(folder), folder).out, HasSubstr(" 0 differ"));
  EXPECT_THAT(sightline(replay(folder, " --set simulation.seed=7"), folder).out, HasSubstr(" 0 differ"));
  const auto own = sightline(replay(folder, " --json --set solver.max_krylov=3"), folder);
  EXPECT_EQ(json::parse(own.out).at("solver"), "newton_riccati") << own.err;
}

TEST(Replay, AKilledFlightIsReplayedToItsEnd) {
  const fs::path folder = fresh_folder();
  fly("handover", "30.0", folder);
  const std::string log = read_file(folder / "out/run.mcap");
  std::ofstream(folder / "out/run.mcap", std::ios::binary) << log.substr(0, log.size() / 2);
  const auto done = sightline(replay(folder), folder);
  EXPECT_EQ(done.code, 0);
  EXPECT_THAT(done.err, HasSubstr("without its end"));
  EXPECT_THAT(done.out, HasSubstr(" 0 differ"));
}

TEST(Replay, WhatCannotBeReplayedIsRefusedInOneSentence) {
  const fs::path folder = fresh_folder();
  fly("handover", "3.0", folder);
  const auto refused = [&](const std::string& command) { return test::refused(command, folder); };
  EXPECT_THAT(refused("replay /nowhere"), HasSubstr("no run.mcap, expected the folder of a run"));
  EXPECT_THAT(refused(replay(folder, " --solver newton")), HasSubstr("newton"));
  EXPECT_THAT(refused(replay(folder, " --solver cgmres")), HasSubstr("the team changes in flight"));
  EXPECT_THAT(refused(replay(folder, " --set couple")), HasSubstr("expected KEY=VALUE"));
  EXPECT_THAT(refused(replay(folder, " --set horizon.stagse=3")), HasSubstr("the nearest is \"stages\""));
  std::ofstream(folder / "out/run.mcap") << "nothing";
  EXPECT_THAT(refused(replay(folder)), HasSubstr("run.mcap"));
}

}  // namespace
}  // namespace sightline::cli
