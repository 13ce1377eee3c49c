// Flights in the world of vehicles by the command line: run, replay, campaign, a crash.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>

#include "tests/support/command.hpp"

namespace sightline::test {
namespace {

using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

fs::path scenario(const fs::path& folder) {
  std::string text = read_file(fs::path(SIGHTLINE_SOURCE_DIR) / "scenarios/cooperative_localization.toml");
  text = std::regex_replace(text, std::regex("\nduration = 60.0"), "\nduration = 4.0");
  text = std::regex_replace(text, std::regex("\ncompare = [^\n]*"), "");
  text = std::regex_replace(text, std::regex("gust = \\{ sigma = 0.0"), "gust = { sigma = 0.2");
  text = std::regex_replace(text, std::regex("position = 0.0,"), "position = 0.01,");
  text = std::regex_replace(text, std::regex("\nduration = 25.0"), "\nduration = 10.0");
  const fs::path file = folder / "rotors.toml";
  std::ofstream(file) << text << "\n[world]\nkind = \"rotors\"\n\n[agent.uav0.vehicle]\nmass = 2.1\n"
                      << "\n[[campaign.draw]]\nkey = \"agent.uav0.vehicle.mass\"\nuniform = [1.9, 2.3]\n";
  return file;
}

TEST(Vehicles, AReplayWithDownwashImuAndOdometryGivesTheSameCommandsAndASecondRunTheSameBytes) {
  const fs::path folder = fresh_folder(), file = scenario(folder);
  std::string text = read_file(file);
  text = std::regex_replace(text, std::regex("kind = \"rotors\""), "kind = \"rotors\"\ndownwash = 1.0");
  text = std::regex_replace(text, std::regex("mass = 2.1\n"), "mass = 2.1\nimu = {}\n");
  text = std::regex_replace(
      text, std::regex("\nnoise = "),
      "\nodometry = { position_walk = 0.01, heading_bias = 0.01, velocity_scale = 0.02 }\nnoise = ");
  std::ofstream(file) << text;
  for (const char* out : {"out", "again"}) {
    const CommandResult flown = sightline("run " + file.string() + " -o " + (folder / out).string(), folder);
    ASSERT_NE(flown.code, 2) << flown.err;
  }
  EXPECT_EQ(read_file(folder / "out/run.mcap"), read_file(folder / "again/run.mcap"));
  const CommandResult again = sightline("replay " + (folder / "out").string(), folder);
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("400 updates, 800 commands, 0 differ"));
}

TEST(Vehicles, ACampaignDrawsTheirNumbers) {
  const fs::path folder = fresh_folder();
  const CommandResult done = sightline(
      "campaign " + scenario(folder).string() + " --runs 8 -o " + (folder / "campaign").string(), folder);
  EXPECT_LE(done.code, 1) << done.err;
  EXPECT_THAT(done.out, HasSubstr("8 runs, seed 1"));
  EXPECT_THAT(done.out, Not(HasSubstr("recovered                 0 of 8")));
}

TEST(Vehicles, ACrashIsToldAndEndsWithExitCode1) {
  const fs::path folder = fresh_folder(), file = folder / "crash.toml";
  std::ofstream(file) << R"toml([world]
kind = "rotors"

[agent.uav]
robot = "velocity_multirotor"
parameters = { preset = "px4" }
start = { p = [0.0, 0.0, 3.0], heading = 0.0 }
Q = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
R = [1.0, 1.0, 0.1, 1.0]
reference = { state = [0.0, 0.0, -20.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0] }

[simulation]
duration = 10.0
)toml";
  const CommandResult flown = sightline("run " + file.string() + " -o " + (folder / "out").string(), folder);
  EXPECT_EQ(flown.code, 1);
  EXPECT_THAT(flown.err, HasSubstr("uav touched the ground at "));
  EXPECT_THAT(flown.err, Not(HasSubstr("not finite")));
  EXPECT_EQ(sightline("replay " + (folder / "out").string(), folder).code, 0);
}

}  // namespace
}  // namespace sightline::test
