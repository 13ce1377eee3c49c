// --set KEY=VALUE of the commands that take a scenario.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sightline/log.hpp"
#include "tests/support/command.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::fresh_folder;
using test::read_file;
using test::sightline;
using testing::HasSubstr;

const std::string pair = "scenarios/cooperative_localization.toml";
const std::string in_rotors =
    " --set world.kind=rotors --set agent.uav0.vehicle.preset=crazyflie --set simulation.duration=2 ";

TEST(Set, AFlightIsThatOfTheChangedScenarioAndItsLogNeedsNoSet) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  const auto run = sightline(
      "run " + pair + in_rotors + "--set 'simulation.compare=[\"newton_riccati\"]' -o " + out.string(),
      folder);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(json::parse(read_file(out / "summary.json")).at("updates"), 200);
  EXPECT_THAT(flown_as(out / "run.mcap").text, HasSubstr("[agent.uav0.vehicle]\npreset = \"crazyflie\"\n"));
  EXPECT_THAT(sightline("replay " + out.string(), folder).out, HasSubstr("400 commands, 0 differ"));
  EXPECT_EQ(sightline("report " + out.string(), folder).code, 0);
}

TEST(Set, TheChangedFileIsPrintedAndFliesToTheSameLog) {
  const fs::path folder = fresh_folder();
  const std::string set = in_rotors + "--set 'simulation.compare=[\"newton_riccati\"]' ";
  const auto printed = sightline("check " + pair + set + "--print", folder);
  ASSERT_EQ(printed.code, 0) << printed.err;
  EXPECT_THAT(printed.out, HasSubstr("kind = \"rotors\""));
  const fs::path file = folder / "cooperative_localization.toml";
  std::ofstream(file) << printed.out;
  ASSERT_EQ(sightline("run " + file.string() + " -o " + (folder / "a").string(), folder).code, 0);
  ASSERT_EQ(sightline("run " + pair + set + "-o " + (folder / "b").string(), folder).code, 0);
  EXPECT_EQ(read_file(folder / "a/run.mcap"), read_file(folder / "b/run.mcap"));
}

TEST(Set, EachCommandThatTakesAScenarioKnowsItAndNamesItWhereItIsWrong) {
  const fs::path folder = fresh_folder();
  for (const char* command : {"run", "check", "campaign", "identify", "potential", "explain"}) {
    EXPECT_EQ(
        test::refused(std::string(command) + " " + pair + " --set world.kid=rotors", folder),
        "--set world.kid=rotors: world.kid = \"rotors\", expected a known key, the nearest is \"kind\"\n");
  }
}

// The file's campaign draws the centre of a circle that is no more.
TEST(Set, AFlightIsNotStoppedByACampaignThatDrawsWhatIsReplaced) {
  const fs::path folder = fresh_folder();
  const std::string file =
      pair + " --set 'agent.uav1.reference={constant={p=[0.0,0.0,1.0]}}' --set simulation.duration=0.5 ";
  const auto run = sightline("run " + file + "-o " + (folder / "out").string(), folder);
  EXPECT_NE(run.code, 2) << run.err;
  const auto replay = sightline("replay " + (folder / "out").string(), folder);
  EXPECT_EQ(replay.code, 0) << replay.err;
  const auto view = sightline("view " + file + "--port 0 --seconds 0.2", folder);
  EXPECT_EQ(view.code, 0) << view.err;
  const auto check = sightline("check " + file, folder);
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_THAT(check.out, HasSubstr("warning     no campaign can be flown: "));
  const auto campaign = sightline("campaign " + file + "--runs 1", folder);
  EXPECT_EQ(campaign.code, 2);
  EXPECT_THAT(campaign.err, testing::AllOf(HasSubstr("agent.uav1.reference.circle"), HasSubstr("expected")));
}

TEST(Set, ACampaignHoldsOfBothScenariosAndTellsItWhereARunFliesAgain) {
  const fs::path folder = fresh_folder();
  const std::string words = "campaign " + pair +
                            " --compare-with scenarios/paper_7_1.toml --set campaign.duration=1 "
                            "--set campaign.view_within=1 --runs 2 -o " +
                            (folder / "out").string();
  const auto flown = sightline(words, folder);
  ASSERT_NE(flown.code, 2) << flown.err;
  EXPECT_THAT(read_file(folder / "out/campaign.html"), HasSubstr("--set campaign.duration=1"));
}

}  // namespace
}  // namespace sightline
