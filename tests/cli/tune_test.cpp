#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/command.hpp"

namespace sightline::cli {
namespace {

using test::fresh_folder;
using test::read_file;
using test::sightline;
using testing::HasSubstr;

TEST(TuneCommand, WritesAScenarioThatAnImprovementOfHeldOutRunsSupports) {
  const auto folder = fresh_folder();
  const std::string command =
      "tune scenarios/paper_7_2.toml --for rms_position_error --draws 2 --held-out 2 --steps 2 "
      "--set campaign.duration=8.0 --set simulation.rms_from=5.0 -o " +
      (folder / "tuned").string();
  const auto done = sightline(command, folder);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("agent.uav1.Q[0]"));
  EXPECT_THAT(done.err, HasSubstr("step 2: rms_position_error"));
  const auto json = nlohmann::json::parse(read_file(folder / "tuned" / "tune.json"));
  EXPECT_EQ(json.at("accepted"), true);
  EXPECT_LT(json.at("held_out").at("after").at("rms_position_error").get<double>(),
            json.at("held_out").at("before").at("rms_position_error").get<double>());
  const auto file = folder / "tuned" / "paper_7_2.toml";
  const std::string text = read_file(file);
  EXPECT_EQ(sightline("check " + file.string(), folder).code, 0);

  const auto again = sightline(command, folder);
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.err, HasSubstr("paper_7_2.toml: is there already; give another folder by -o"));
  EXPECT_EQ(read_file(file), text);
}

TEST(TuneCommand, WritesNoScenarioWithoutAnImprovement) {
  const auto folder = fresh_folder();
  // uav1 starts where its reference rests, and nothing disturbs it.
  std::ofstream(folder / "rest.toml")
      << "[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0.0, 0.0, 1.0] }\n"
         "Q = [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]\nR = [1.0, 1.0, 1.0, 1.0]\n"
         "reference = { state = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0] }\n"
         "[simulation]\nrms_from = 0.0\n[simulation.disturbance]\nwind = [0.0, 0.0, 0.0]\n"
         "[campaign]\nduration = 1.0\n[[campaign.draw]]\nkey = \"simulation.disturbance.wind[0]\"\nchoice = "
         "[0.0]\n";
  const auto done = sightline("tune " + (folder / "rest.toml").string() + " --for rms_position_error -o " +
                                  (folder / "tuned").string(),
                              folder);
  EXPECT_EQ(done.code, 1) << done.err;
  EXPECT_THAT(done.err, HasSubstr("no step lowers rms_position_error: no scenario is written"));
  EXPECT_TRUE(std::filesystem::exists(folder / "tuned" / "tune.json"));
  EXPECT_FALSE(std::filesystem::exists(folder / "tuned" / "rest.toml"));
}

TEST(TuneCommand, RefusesBadInputWithASentence) {
  const auto folder = fresh_folder();
  const std::string out = " -o " + (folder / "tuned").string();
  EXPECT_THAT(test::refused("tune scenarios/paper_7_2.toml --for view" + out, folder),
              HasSubstr("--for = view, expected one of view_angle, view_excess, rms_position_error"));
  EXPECT_THAT(test::refused("tune scenarios/chain8.toml --for view_angle" + out, folder),
              HasSubstr("campaign is missing, expected [campaign] with what is drawn"));
  EXPECT_THAT(test::refused("tune scenarios/paper_7_2.toml" + out, folder), HasSubstr("--for"));
}

}  // namespace
}  // namespace sightline::cli
