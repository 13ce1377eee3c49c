#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "tests/support/command.hpp"

namespace sightline::cli {
namespace {

using nlohmann::json;
using test::fresh_folder;
using test::read_file;
using test::refused;
using test::sightline;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

TEST(PotentialCommand, LeavesThePaperSFiguresAndVerdict) {
  const fs::path folder = fresh_folder();
  const auto done = sightline("potential scenarios/paper_7_1.toml -o " + (folder / "out").string(), folder);
  EXPECT_EQ(done.code, 0);
  EXPECT_EQ(done.err, "");
  for (const char* words :
       {"0.447 rad, not the 0.500 rad", "no gradient in yaw behind the sensor", "vanishes beyond 2.5 m"}) {
    EXPECT_THAT(done.out, HasSubstr(words));
  }
  const json verdict = json::parse(read_file(folder / "out" / "verdict.json"));
  ASSERT_EQ(verdict.at("couplings").size(), 3u);
  EXPECT_GT(verdict["couplings"][0]["verdict"]["gradient_vanishes"]["in_yaw_behind"], 0.9);
  const std::string page = read_file(folder / "out" / "index.html");
  for (const char* name :
       {"couple[0] sensor_cone", "couple[1] keep_out", "couple[2] cohesion", "application/json"}) {
    EXPECT_THAT(page, HasSubstr(name));
  }
}

TEST(PotentialCommand, LooksAtOneCouplingWhenAsked) {
  const fs::path folder = fresh_folder();
  const auto done =
      sightline("potential scenarios/paper_7_1.toml --couple 2 -o " + (folder / "out").string(), folder);
  EXPECT_EQ(done.code, 0) << done.err;
  const json verdict = json::parse(read_file(folder / "out" / "verdict.json"));
  ASSERT_EQ(verdict.at("couplings").size(), 1u);
  EXPECT_EQ(verdict["couplings"][0]["potential"], "cohesion");
  EXPECT_THAT(done.out, Not(HasSubstr("sensor_cone")));
}

TEST(PotentialCommand, RefusesWhatIsNoCouplingNoFolderAndNoScenario) {
  const fs::path folder = fresh_folder();
  std::ofstream(folder / "file") << "x";
  const std::string paper = "scenarios/paper_7_1.toml";
  for (const std::string& arguments :
       {paper + " --couple 3", paper + " --couple -1", paper + " -o " + (folder / "file").string(),
        std::string("scenarios/nowhere.toml"), std::string("scenarios/yaw_step.toml")})
    EXPECT_THAT(refused("potential " + arguments, folder), HasSubstr("expected")) << arguments;
  EXPECT_EQ(sightline("potential " + paper + " --couple one", folder).code, 2);
  EXPECT_EQ(sightline("potential", folder).code, 2);
}

TEST(ExplainCommand, SaysWhereThePaperSPairRestsAndWhatItsLimitsAreWorth) {
  const auto done = sightline("explain scenarios/paper_7_1.toml", fresh_folder());
  EXPECT_EQ(done.code, 0);
  EXPECT_EQ(done.err, "");
  for (const char* words : {"D = 1.694 m", "from 1.00 to 2.00 m", "being hit costs at most 1.71"}) {
    EXPECT_THAT(done.out, HasSubstr(words));
  }
}

TEST(ExplainCommand, NamesLimitsThatContradictEachOtherAndRefusesABrokenScenario) {
  const fs::path folder = fresh_folder();
  const std::string text = read_file(SIGHTLINE_SOURCE_DIR "/scenarios/paper_7_1.toml");
  std::ofstream(folder / "apart.toml") << std::regex_replace(text, std::regex("d_min = 1.0"), "d_min = 2.5");
  const auto done = sightline("explain " + (folder / "apart.toml").string(), folder);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("contradiction: couple[1] keep_out and couple[2] cohesion"));
  std::ofstream(folder / "broken.toml")
      << std::regex_replace(text, std::regex("d_min = 1.0"), "d_min = -1.0");
  (void)refused("explain " + (folder / "broken.toml").string(), folder);
}

TEST(ExplainCommand, TakesEveryScenarioThatIsShipped) {
  const fs::path folder = fresh_folder();
  for (const auto& entry : fs::directory_iterator(SIGHTLINE_SOURCE_DIR "/scenarios")) {
    if (entry.path().extension() != ".toml") continue;
    const auto done = sightline("explain " + entry.path().string(), folder);
    EXPECT_EQ(done.code, 0) << entry.path() << done.err;
    EXPECT_FALSE(done.out.empty());
  }
}

TEST(CheckCommand, TellsAsExplainDoesOfEachPairWhetherItsDistanceIsGuaranteed) {
  const std::string all = " scenarios/ground_and_air.toml --set 'safety.barrier=\"on\"'";
  for (const std::string command : {"check", "explain"}) {
    const auto done = sightline(command + all, fresh_folder());
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_THAT(done.out,
                HasSubstr("\ndistance    not guaranteed, a body is up to 4.17 m/s fast, beyond 2.5 m/s: "
                          "uav0 and uav1\n"));
    EXPECT_THAT(sightline(command + " scenarios/paper_7_1.toml", fresh_folder()).out,
                Not(HasSubstr("guaranteed")));
  }
}

TEST(CheckCommand, WarnsInALineEachAfterOkAndStaysAtZero) {
  const auto done = sightline("check scenarios/paper_7_1.toml", fresh_folder());
  EXPECT_EQ(done.code, 0);
  EXPECT_EQ(done.out.find("ok\n"), 0u);
  EXPECT_THAT(done.out, HasSubstr("warning     couple[0] sensor_cone: no gradient in yaw behind the sensor"));
  EXPECT_THAT(done.out, HasSubstr("warning     couple[2] cohesion: its gradient vanishes beyond 2.5 m"));
}

}  // namespace
}  // namespace sightline::cli
