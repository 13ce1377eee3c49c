#include "cli/partition.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/support/command.hpp"

namespace sightline::cli {
namespace {

using nlohmann::json;
using test::fresh_folder;
using test::read_file;
using test::sightline;
namespace fs = std::filesystem;

const std::string halves = "uav0,uav1,uav2,uav3 | uav4,uav5,uav6,uav7";
const std::string quarters = "uav0,uav1 | uav2,uav3 | uav4,uav5 | uav6,uav7";

/// chain8 with another duration [s]; joint: every coupling felt by both of its robots.
fs::path chain8(const fs::path& folder, const std::string& duration, bool joint = false) {
  std::string text = read_file(SIGHTLINE_SOURCE_DIR "/scenarios/chain8.toml");
  text = std::regex_replace(text, std::regex("duration = 60.0"), "duration = " + duration);
  if (joint) text = std::regex_replace(text, std::regex("felt_by = \"observer\", "), "");
  fs::path file = folder / (joint ? "chain8_joint.toml" : "chain8.toml");
  std::ofstream(file) << text;
  return file;
}

TEST(RunInParts, FliesTheChainOfEightWithinOnePercentOfTheCostOfTheWholeByOneExchange) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  for (const bool joint : {false, true}) {
    const fs::path scenario = chain8(folder, "11.0", joint);
    for (const std::string& parts : {halves, quarters}) {
      for (const char* order : {"jacobi", "gauss_seidel"}) {
        if (joint && (parts == halves || order == std::string("gauss_seidel")))
          continue;  // the hardest of them
        const auto run = sightline("run " + scenario.string() + " --partition '" + parts + "' --order " +
                                       order + " -o " + out.string(),
                                   folder);
        EXPECT_EQ(run.code, 0) << run.err;
        const json reported = json::parse(read_file(out / "partition.json"));
        EXPECT_EQ(reported.at("parts").size(), parts == halves ? 2u : 4u);
        EXPECT_EQ(reported.at("order"), order);
        EXPECT_EQ(reported.at("exchanges"), 1);
        EXPECT_LE(std::abs(reported.at("cost_excess").get<double>()), 0.01) << parts << " " << order;
        const json summary = json::parse(read_file(out / "summary.json"));
        EXPECT_EQ(summary.at("solver"), "partitioned");
        EXPECT_EQ(summary.at("cost"), reported.at("cost"));
        EXPECT_EQ(summary.at("allocations_per_update"), 0);
        for (const json& pair : summary.at("pairs")) EXPECT_EQ(pair.at("in_view_fraction"), 1.0) << pair;
      }
    }
  }
}

TEST(RunInParts, TellsHowFarItIsFromTheOptimumOfTheWholeSweepBySweep) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  const auto run = sightline("run " + chain8(folder, "4.0", true).string() + " --partition '" + quarters +
                                 "' --exchanges 2 -o " + out.string(),
                             folder);
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_NE(run.out.find("4 subteams, gauss_seidel order, exchanges per update: 2\n"), std::string::npos)
      << run.out;
  const json reported = json::parse(read_file(out / "partition.json"));
  EXPECT_GE(reported.at("moments"), 20);
  const json& sweeps = reported.at("sweeps");
  ASSERT_GE(sweeps.size(), 4u);
  for (std::size_t i = 1; i < sweeps.size(); ++i) {
    EXPECT_EQ(sweeps[i].at("sweep"), i + 1);
    EXPECT_LT(sweeps[i].at("input").at("median"), sweeps[i - 1].at("input").at("median")) << i;
  }
  const auto whole = sightline(
      "run " + (folder / "chain8_joint.toml").string() + " -o " + (folder / "alone").string(), folder);
  EXPECT_EQ(whole.code, 0);
  EXPECT_EQ(read_file(out / "whole" / "run.mcap"), read_file(folder / "alone" / "run.mcap"))
      << "what it is compared with is the flight without --partition";
}

/// The pair of localize.toml, each robot in a part of its own, whose messages are late and lost.
fs::path localized_in_parts(const fs::path& folder) {
  fs::path file = test::short_scenario(folder, "localize", "25.0");
  std::ofstream(file, std::ios::app) << R"(
[partition]
head = ["uav1"]
tail = ["uav0"]
[partition.exchange]
loss = 0.2
delay = 0.03
)";
  return file;
}

TEST(RunInParts, OfARobotLocalizedByVisionKeepsViewDistanceAndAConsistentEstimate) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  const std::string scenario = localized_in_parts(folder).string();
  constexpr int runs = 8;
  double anees = 0.0;
  for (int seed = 1; seed <= runs; ++seed) {
    const auto run =
        sightline("run " + scenario + " --seed " + std::to_string(seed) + " -o " + out.string(), folder);
    EXPECT_EQ(run.code, 0) << run.err;
    const json summary = json::parse(read_file(out / "summary.json"));
    EXPECT_EQ(summary.at("solver"), "partitioned");
    EXPECT_EQ(summary.at("allocations_per_update"), 0);
    ASSERT_EQ(summary.at("pairs").size(), 1u);
    const json& pair = summary.at("pairs")[0];
    EXPECT_EQ(pair.at("in_view_fraction"), 1.0) << seed;
    EXPECT_GE(pair.at("distance").at("min"), 1.0) << seed;
    EXPECT_LE(pair.at("distance").at("max"), 2.0) << seed;
    ASSERT_EQ(summary.at("localization").size(), 1u);
    anees += summary.at("localization")[0].at("anees").get<double>() / runs;
    const auto again = sightline("replay " + out.string(), folder);
    EXPECT_EQ(again.code, 0) << seed;
    EXPECT_THAT(again.out, testing::ContainsRegex(" commands, 0 differ\n.* estimates of poses, 0 differ\n"));
  }
  // Four errors: mean 4, variance 8. Errors last as long as a run, which counts as one sample.
  const double two_sigma = 2.0 * std::sqrt(8.0 / runs);
  EXPECT_NEAR(anees, 4.0, two_sigma);
}

TEST(RunInParts, RefusesARobotLocalizedByVisionInAProgramOfItsOwnPart) {
  const fs::path folder = fresh_folder();
  const std::string check = "check " + localized_in_parts(folder).string() + " --set partition.part=";
  EXPECT_EQ(test::sightline(check + "all", folder).code, 0);
  for (const char* part : {"head", "tail"})
    EXPECT_THAT(test::refused(check + part, folder),
                testing::HasSubstr(std::string("partition.part = \"") + part +
                                   "\" beside agent.uav0.localization = vision, expected \"global\", or "
                                   "parts in one program: messages of parts carry no estimates\n"));
}

TEST(RunInParts, LogsTheSameBytesWhateverTheNumberOfThreads) {
  const fs::path folder = fresh_folder();
  std::vector<std::string> logs;
  for (const char* threads : {"1", "2", "3"}) {
    const auto run = sightline(std::string("run fleets/chain8.toml --set simulation.duration=2.0 "
                                           "--set partition.exchange.loss=0.2 --threads ") +
                                   threads + " -o " + (folder / threads).string(),
                               folder);
    EXPECT_LE(run.code, 1) << run.err;
    logs.push_back(read_file(folder / threads / "run.mcap"));
    EXPECT_EQ(json::parse(read_file(folder / threads / "summary.json")).at("allocations_per_update"), 0);
  }
  EXPECT_GT(logs[0].size(), 10'000u);
  EXPECT_TRUE(logs[1] == logs[0] && logs[2] == logs[0]);
}

TEST(RunInParts, WordsThatDoNotFitEndWithTwoAndASentence) {
  const fs::path folder = fresh_folder();
  const std::string run = "run scenarios/chain8.toml -o " + (folder / "out").string() + " ";
  const auto refusal = [&](const std::string& words) { return test::refused(run + words, folder); };
  EXPECT_EQ(refusal("--partition 'uav0,uav1'"),
            "the partition leaves out \"uav2\", expected every robot in one part\n");
  EXPECT_EQ(
      refusal("--partition 'uav0,uaw1'"),
      "partition = \"uav0,uaw1\": \"uaw1\" is no robot of the team, expected one, the nearest is \"uav1\"\n");
  EXPECT_EQ(refusal("--partition '" + halves + "' --order backwards"),
            "order = \"backwards\", expected jacobi or gauss_seidel\n");
  EXPECT_EQ(refusal("--partition '" + halves + "' --exchanges 0"), "exchanges = 0, expected 1 to 1000\n");
  EXPECT_EQ(refusal("--partition '" + halves + "' --solver cgmres"),
            "--partition: the solver cgmres cannot plan a part, expected newton_riccati\n");
  EXPECT_EQ(refusal("--partition '" + halves + "' --threads 2"),
            "threads = 2, expected 1 in gauss_seidel order, where each part waits for the one before, or "
            "jacobi\n");
  EXPECT_NE(refusal("--order jacobi").find("--partition"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "out")) << "refused before anything is written";
}

}  // namespace
}  // namespace sightline::cli
