// The benchmark in short: every task with every controller, a run of 5 s, one table.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/command.hpp"

namespace sightline {
namespace {

using Json = nlohmann::json;
using test::read_file;
namespace fs = std::filesystem;

const std::string run =
    "benchmark/run.py --program '" SIGHTLINE_EXAMPLES "/sightline_keep_in_view' --duration 5 ";

Json table(const std::string& options, const fs::path& folder) {
  const auto done = test::shell(run + options + " -o '" + folder.string() + "'", test::fresh_folder());
  EXPECT_EQ(done.code, 0) << done.err;
  return Json::parse(read_file(folder / "table.json"));
}

TEST(Benchmark, FliesEveryTaskWithEveryController) {
  const fs::path folder = test::fresh_folder();
  const Json all = table("--runs 1", folder);
  const Json settings = Json::parse(read_file(SIGHTLINE_SOURCE_DIR "/benchmark/controllers.json"));
  EXPECT_GE(all.at("tasks").size(), 8U);
  EXPECT_EQ(all.at("controllers").size(), settings.size());
  for (const auto& [task, cells] : all.at("tasks").items()) {
    for (const auto& [name, cell] : cells.items()) {
      const bool stated =
          !settings.at(name).contains("certify_view") || settings.at(name)["certify_view"].contains(task);
      ASSERT_EQ(cell.contains("refused"), !stated) << task << ' ' << name << ' ' << cell;
      if (!stated) continue;
      int runs = 0;
      for (const auto& of : cell.at("outcomes")) runs += of.get<int>();
      EXPECT_EQ(runs, 1) << task << ' ' << name;
      EXPECT_EQ(cell.at("outcomes").at("failed"), 0) << task << ' ' << name;
      const auto& recovered = cell.at("recovered");
      EXPECT_TRUE(recovered[1] <= recovered[0] && recovered[0] <= recovered[2]) << task << ' ' << name;
    }
  }
  // What judges comes first: the first view of a pair counts.
  const std::string leader = read_file(folder / "sightline/leader_1/leader_1.toml");
  EXPECT_LT(leader.find("contact.toml"), leader.find("bearing"));
  const std::string text = read_file(folder / "table.md");
  EXPECT_THAT(text, testing::HasSubstr("Where a baseline wins:"));
  EXPECT_THAT(text, testing::HasSubstr("| paper_7_1 |"));
}

TEST(Benchmark, GivesTheSameBitsOnAnyNumberOfThreads) {
  const std::string some = "--runs 4 --tasks adversary --controllers sightline cbf_mpc visual_servo";
  const Json one = table(some, test::fresh_folder()).at("tasks"),
             two = table(some + " --threads 2", test::fresh_folder()).at("tasks");
  EXPECT_EQ(one, two);
  EXPECT_EQ(one.at("adversary").at("cbf_mpc").at("digest").get<std::string>().size(), 16U);
}

TEST(Benchmark, AControllerOutsideOfAtMost30LinesScores) {
  EXPECT_LE(test::lines(read_file(SIGHTLINE_SOURCE_DIR "/benchmark/examples/pursuer.py")), 30);
  const Json cell = table(
      "--runs 2 --tasks adversary --controllers process --process 'python3 benchmark/examples/pursuer.py'",
      test::fresh_folder())["tasks"]["adversary"]["process"];
  EXPECT_EQ(cell.at("outcomes").at("recovered"), 2) << cell;
  EXPECT_GT(cell.at("in_view")[0], 0.8) << cell;
}

}  // namespace
}  // namespace sightline
