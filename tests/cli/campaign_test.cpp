#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "sightline/campaign/database.hpp"
#include "sightline/campaign/page.hpp"
#include "sightline/campaign/paired.hpp"
#include "tests/support/command.hpp"

namespace sightline::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::fresh_folder;
using test::read_file;
using test::sightline;
using testing::HasSubstr;

const std::string shipped = "scenarios/cooperative_localization.toml";

/// A shipped scenario with runs of another duration [s].
std::string with_runs_of(const std::string& duration, const fs::path& folder) {
  const fs::path file = folder / "short.toml";
  std::ofstream(file) << std::regex_replace(read_file(fs::path(SIGHTLINE_SOURCE_DIR) / shipped),
                                            std::regex("duration = 25.0 "), "duration = " + duration + " ");
  return file.string();
}

std::string one(const fs::path& file, const std::string& sql) {
  Database database(file, Database::Open::as_it_is);
  Database::Statement request(database, sql);
  return request.step() ? request.text(0) : "nothing";
}

/// Flies so many shards, each into a folder of its number. @return the folders, each after a blank
std::string flown_shards(const std::string& campaign, int count, const fs::path& folder) {
  std::string folders;
  for (int shard = 1; shard <= count; ++shard) {
    const fs::path out = folder / std::to_string(shard);
    (void)sightline(fmt::format("{} --shard {}/{} -o {}", campaign, shard, count, out.string()), folder);
    folders += " " + out.string();
  }
  return folders;
}

TEST(Campaign, TheShippedOneFindsItsTargetFromEveryStart) {
  const fs::path folder = fresh_folder();
  const auto flown = sightline("campaign " + shipped + " --runs 20 -o " + (folder / "a").string(), folder);
  EXPECT_EQ(flown.code, 0) << flown.err;
  EXPECT_THAT(flown.out, HasSubstr("20 of 20, 100.00 %"));
  EXPECT_THAT(flown.err, HasSubstr("20 of 20 runs, 20 recovered, 0 s left"));
  const fs::path table = folder / "a" / "campaign.sqlite";
  EXPECT_EQ(one(table, "SELECT count(*) || ' ' || sum(violations) FROM runs WHERE outcome = 'recovered'"),
            "20 0");
  EXPECT_GT(fs::file_size(folder / "a" / "campaign.html"), 20'000U);
}

TEST(Campaign, RunsThatAreNotRecoveredAreSaidAndAFailure) {
  const fs::path folder = fresh_folder();
  const auto flown = sightline(
      "campaign " + with_runs_of("0.1", folder) + " --runs 40 -o " + (folder / "a").string(), folder);
  EXPECT_EQ(flown.code, 1);
  EXPECT_THAT(flown.err, testing::ContainsRegex("sightline: [0-9]+ of 40 runs: lost"));
  EXPECT_THAT(read_file(folder / "a" / "campaign.html"), HasSubstr("runs were not recovered."));
}

// The row of the table, an ordinary run folder, and that folder's scenario flown as any other: all
// the same.
TEST(Campaign, OneRunAloneIsTheRowOfTheTable) {
  const fs::path folder = fresh_folder();
  const std::string scenario = with_runs_of("3.0", folder), campaign = "campaign " + scenario + " --seed 4";
  (void)sightline(campaign + " --runs 9 -o " + (folder / "all").string(), folder);
  const auto alone = sightline(campaign + " --only 8 -o " + (folder / "one").string(), folder);
  EXPECT_LE(alone.code, 1) << alone.err;
  const json summary = json::parse(read_file(folder / "one" / "summary.json"));
  const fs::path table = folder / "all" / "campaign.sqlite";
  Database database(table, Database::Open::as_it_is);
  Database::Statement row(database,
                          "SELECT seed, min_distance, energy, status_converged, status_stepped, outcome "
                          "FROM runs WHERE \"index\" = 8");
  ASSERT_TRUE(row.step());
  EXPECT_EQ(summary.at("seed"), row.integer(0));
  EXPECT_EQ(summary.at("min_distance").get<double>(), row.number(1));
  EXPECT_EQ(summary.at("status").at("converged"), row.integer(3));
  EXPECT_EQ(summary.at("status").at("stepped"), row.integer(4));
  double energy = 0;
  for (const json& agent : summary.at("agents")) energy += agent.at("energy").get<double>();
  EXPECT_NEAR(energy, row.number(2).value_or(-1), 1e-12);
  EXPECT_THAT(alone.out, HasSubstr("run 8: " + row.text(5)));
  for (const char* file : {"run.mcap", "timing.csv", "report.html", "short.toml"})
    EXPECT_GT(fs::file_size(folder / "one" / file), 1000U) << file;

  (void)sightline("run " + (folder / "one" / "short.toml").string() + " -o " + (folder / "again").string(),
                  folder);
  EXPECT_TRUE(read_file(folder / "again" / "run.mcap") == read_file(folder / "one" / "run.mcap"));
}

// Its scenario lies in another folder than the one that it was read from, which has no seed and a
// file beside it.
TEST(Campaign, TheScenarioOfARunAloneFindsTheFilesThatItNames) {
  const fs::path folder = fresh_folder();
  fs::create_directory(folder / "sensors");
  fs::copy_file("scenarios/sensors/camera.toml", folder / "sensors" / "camera.toml");
  std::ofstream(folder / "pyramid.toml")
      << std::regex_replace(read_file("scenarios/pyramid_camera.toml"), std::regex("\nseed = .*\n"), "\n")
      << "\n[campaign]\nduration = 1.0\n"
         "[[campaign.draw]]\nkey = \"agent.uav0.start.p[0]\"\nuniform = [-2.0, -1.0]\n";
  const fs::path one = folder / "one", again = folder / "again";
  const auto alone =
      sightline("campaign " + (folder / "pyramid.toml").string() + " --only 3 -o " + one.string(), folder);
  EXPECT_LE(alone.code, 1) << alone.err;
  const auto flown = sightline("run " + (one / "pyramid.toml").string() + " -o " + again.string(), folder);
  EXPECT_LE(flown.code, 1) << flown.err;
  EXPECT_TRUE(read_file(again / "run.mcap") == read_file(one / "run.mcap"));
}

TEST(Campaign, TheSameAgainIsWhatIsThereAndMoreRunsGoOn) {
  const fs::path folder = fresh_folder(), out = folder / "a", table = out / "campaign.sqlite";
  const std::string campaign = "campaign " + with_runs_of("0.5", folder) + " --seed 5 -o ";
  const auto first = sightline(campaign + out.string() + " --runs 8", folder);
  const std::string rows = read_file(table);
  const auto again = sightline(campaign + out.string() + " --runs 8", folder);
  EXPECT_EQ(again.code, first.code);
  EXPECT_EQ(again.out, first.out);
  EXPECT_TRUE(read_file(table) == rows);
  const auto more = sightline(campaign + out.string() + " --runs 20", folder);
  EXPECT_THAT(more.err, HasSubstr("campaign.sqlite: goes on after 8 runs\n"));
  const auto whole = sightline(campaign + (folder / "b").string() + " --runs 20", folder);
  EXPECT_TRUE(read_file(table) == read_file(folder / "b" / "campaign.sqlite"));
  EXPECT_EQ(more.code, whole.code);
}

TEST(Campaign, WhatAFolderHoldsIsNeverReplaced) {
  const fs::path folder = fresh_folder(), out = folder / "a", table = out / "campaign.sqlite";
  const std::string scenario = with_runs_of("0.5", folder),
                    campaign = "campaign " + scenario + " -o " + out.string();
  (void)sightline(campaign + " --runs 8", folder);
  const std::string rows = read_file(table), page = read_file(out / "campaign.html");
  for (const auto& [words, why] :
       {std::pair{campaign + " --runs 8 --seed 77", "holds 8 runs of another campaign: another seed"},
        {campaign + " --runs 7", "holds 8 runs of this campaign, expected at most 7"},
        {"campaign scenarios/energy.toml --runs 8 -o " + out.string(), "another scenario, text"}}) {
    const auto refused = sightline(words, folder);
    EXPECT_EQ(refused.code, 2) << words;
    EXPECT_EQ(refused.out, "") << words;
    EXPECT_THAT(refused.err, HasSubstr("campaign.sqlite: ")) << words;
    EXPECT_THAT(refused.err, HasSubstr(why)) << words;
    EXPECT_THAT(refused.err, HasSubstr("another folder by -o")) << words;
  }
  // A number that somebody changed.
  {
    Database database(table, Database::Open::as_it_is);
    database.execute("UPDATE runs SET energy = energy + 1e-9 WHERE \"index\" = 7");
  }
  const auto other = sightline(campaign + " --runs 8", folder);
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("campaign.sqlite: the row of run 7 is not as it was written"));
  EXPECT_EQ(one(table, "SELECT count(*) FROM runs"), "8");
  EXPECT_TRUE(read_file(out / "campaign.html") == page);
}

TEST(Campaign, ThePageSaysHowToFlyARunAgainInWordsOfTheShell) {
  const fs::path folder = fresh_folder(), strange = folder / "it's $(here)";
  fs::create_directory(strange);
  fs::copy_file(with_runs_of("0.5", folder), strange / "a b.toml");
  const std::string words = "campaign " + shell_word((strange / "a b.toml").native()) + " --runs 2 -o " +
                            shell_word((strange / "o ut").native());
  EXPECT_LE(sightline(words, folder).code, 1);
  const std::string page = read_file(strange / "o ut" / "campaign.html");
  const std::size_t begin = page.find("sightline campaign"), end = page.find('\n', begin);
  ASSERT_NE(begin, std::string::npos);
  const std::string command = page.substr(begin, end - begin).substr(std::string("sightline ").size());
  EXPECT_LE(sightline(command, folder).code, 1) << command;
  EXPECT_TRUE(fs::exists(strange / "o ut" / "run_0" / "run.mcap") ||
              fs::exists(strange / "o ut" / "run_1" / "run.mcap"));
}

TEST(Campaign, AnotherScenarioBesideFliesTheSameDraws) {
  const fs::path folder = fresh_folder();
  const std::string campaign = "campaign " + with_runs_of("1.0", folder) + " --runs 12 --compare-with " +
                               "scenarios/paper_7_1.toml -o " + (folder / "a").string();
  const auto flown = sightline(campaign, folder);
  EXPECT_LE(flown.code, 1) << flown.err;
  EXPECT_EQ(sightline(campaign, folder).out, flown.out) << "the same again is what is there";
  const std::string drawn =
      "SELECT group_concat(seed || ' ' || \"uav0.range\" || ' ' || \"agent.uav1.reference.circle.rate\") "
      "FROM runs";
  EXPECT_EQ(one(folder / "a" / "campaign.sqlite", drawn), one(folder / "a/paper_7_1/campaign.sqlite", drawn));
  EXPECT_EQ(one(folder / "a/paper_7_1/campaign.sqlite", "SELECT value FROM campaign WHERE key = 'scenario'"),
            "paper_7_1");
  EXPECT_THAT(read_file(folder / "a" / "campaign.html"), HasSubstr("<h2>paper_7_1</h2>"));
  EXPECT_TRUE(fs::exists(folder / "a/paper_7_1/campaign.html"));
}

TEST(Campaign, KeepingATargetInASharpConeTakesLessEnergyThanPointingAtItInMostRuns) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  const auto done =
      sightline("campaign scenarios/energy.toml --compare-with scenarios/energy_pointing.toml --runs 40 -o " +
                    out.string(),
                folder);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("energy_pointing, compared with energy"));
  EXPECT_THAT(read_file(out / "campaign.html"), HasSubstr("Energy of energy_pointing, compared with energy"));
  const CampaignTable cone{"energy", out / "campaign.sqlite"},
      pointing{"energy_pointing", out / "energy_pointing" / "campaign.sqlite"};
  const Pairing observer = pair_runs(cone, pointing, "uav0.energy"),
                leader = pair_runs(cone, pointing, "uav1.energy");
  EXPECT_EQ(observer.runs, 40);
  EXPECT_GE(observer.more, 28);
  EXPECT_GT(observer.ratio.median, 1.02);
  EXPECT_LT(observer.ratio.median, 1.2);
  EXPECT_EQ(leader.less + leader.more, 0) << "who is watched flies the same";
}

TEST(Campaign, ShardsThatAreMergedAreTheCampaignOfOneProcess) {
  const fs::path folder = fresh_folder();
  const std::string campaign = "campaign " + with_runs_of("0.5", folder) + " --seed 5 --runs 10";
  const auto whole = sightline(campaign + " -o " + (folder / "whole").string(), folder);
  const std::string folders = flown_shards(campaign, 3, folder);
  const auto merged = sightline("campaign --merge" + folders + " -o " + (folder / "merged").string(), folder);
  EXPECT_EQ(merged.code, whole.code) << merged.err;
  EXPECT_TRUE(read_file(folder / "merged" / "campaign.sqlite") ==
              read_file(folder / "whole" / "campaign.sqlite"));
  EXPECT_THAT(merged.out, HasSubstr("10 runs of 3 shards, seed 5"));
  EXPECT_GT(read_file(folder / "merged" / "campaign.html").size(), 1000U);
  // A run of it flies again by the scenario that lies beside.
  const auto again = sightline("campaign " + (folder / "merged" / "short.toml").string() +
                                   " --seed 5 --only 4 -o " + (folder / "run_4").string(),
                               folder);
  EXPECT_THAT(again.out, HasSubstr("run 4: ")) << again.err;
}

TEST(Campaign, ShardsBringTheFilesThatTheirScenarioNames) {
  const fs::path folder = fresh_folder(), from = folder / "from", out = folder / "merged";
  fs::create_directories(from / "obstacles");
  fs::copy_file(fs::path(SIGHTLINE_SOURCE_DIR) / "scenarios/obstacles/line_of_sight.toml",
                from / "obstacles/line_of_sight.toml");
  std::ofstream(from / "pillar.toml")
      << read_file(fs::path(SIGHTLINE_SOURCE_DIR) / "scenarios/line_of_sight.toml")
      << "\n[campaign]\nduration = 0.5\n[[campaign.draw]]\nkey = "
         "\"agent.uav0.start.heading\"\nuniform = [2.8, 3.4]\n";
  const std::string campaign = "campaign " + (from / "pillar.toml").string() + " --runs 3";
  const std::string merge = "campaign --merge" + flown_shards(campaign, 2, folder) + " -o ";
  fs::rename(from, folder / "away");  // they were flown by another machine
  const auto merged = sightline(merge + out.string(), folder);
  EXPECT_EQ(merged.err, "");
  EXPECT_GT(read_file(out / "campaign.html").size(), 1000U);
  const auto again = sightline(
      "campaign " + (out / "pillar.toml").string() + " --only 1 -o " + (folder / "run_1").string(), folder);
  EXPECT_THAT(again.out, HasSubstr("run 1: ")) << again.err;

  // What a folder holds is not written over, and a shard of another file is none of this campaign.
  std::ofstream(out / "obstacles/line_of_sight.toml") << "mine";
  EXPECT_THAT(sightline(merge + out.string(), folder).err,
              HasSubstr("line_of_sight.toml: is there already and is not that of the shards"));
  EXPECT_EQ(read_file(out / "obstacles/line_of_sight.toml"), "mine");
  fs::rename(folder / "away", from);
  std::ofstream(from / "obstacles/line_of_sight.toml", std::ios::app) << "# another\n";
  const std::string second = campaign + " --shard 2/2 -o " + (folder / "2").string();
  EXPECT_THAT(sightline(second, folder).err, HasSubstr("another file obstacles/line_of_sight.toml"));
  fs::remove_all(folder / "2");
  (void)sightline(second, folder);
  EXPECT_THAT(sightline(merge + (folder / "other").string(), folder).err,
              HasSubstr("another file obstacles/line_of_sight.toml"));
}

TEST(Campaign, ShardsOfAScenarioBesideAloneHaveThePageOfTheOneThatDraws) {
  const fs::path folder = fresh_folder();
  const std::string paper = read_file(fs::path(SIGHTLINE_SOURCE_DIR) / "scenarios/paper_7_1.toml");
  std::ofstream(folder / "plain.toml") << paper.substr(0, paper.find("[campaign]"));
  const std::string campaign = "campaign " + with_runs_of("0.5", folder) + " --runs 4 --compare-with " +
                               (folder / "plain.toml").string();
  (void)flown_shards(campaign, 2, folder);
  const auto merged = sightline(
      fmt::format("campaign --merge {0}/1/plain {0}/2/plain -o {0}/merged", folder.string()), folder);
  EXPECT_EQ(merged.err, "");
  EXPECT_GT(read_file(folder / "merged/campaign.html").size(), 1000U);
}

TEST(Campaign, ShardsWithAScenarioBesideArePairedAsOneProcessPairsThem) {
  const fs::path folder = fresh_folder();
  const std::string campaign =
      "campaign " + with_runs_of("1.0", folder) + " --runs 12 --compare-with scenarios/paper_7_1.toml";
  const auto whole = sightline(campaign + " -o " + (folder / "whole").string(), folder);
  const std::string folders = flown_shards(campaign, 2, folder);
  const auto merge = [&] {
    return sightline("campaign --merge" + folders + " -o " + (folder / "merged").string(), folder);
  };
  const auto merged = merge();
  const auto compared = [](const std::string& out) {
    const auto begin = out.find("\npaper_7_1, compared with short\n");
    return begin == std::string::npos ? "" : out.substr(begin, out.find("\n/", begin) - begin);
  };
  EXPECT_NE(compared(whole.out), "") << whole.err;
  EXPECT_EQ(compared(merged.out), compared(whole.out)) << merged.err;
  const auto paired = [&](const char* name) {
    return json::parse(read_file(folder / name / "campaign.json")).at("beside").at(0);
  };
  EXPECT_EQ(paired("merged"), paired("whole"));
  EXPECT_TRUE(read_file(folder / "merged/paper_7_1/campaign.sqlite") ==
              read_file(folder / "whole/paper_7_1/campaign.sqlite"));
  fs::remove_all(folder / "2" / "paper_7_1");
  EXPECT_EQ(merge().code, 2);
  EXPECT_THAT(merge().err, HasSubstr("/2: holds other scenarios beside its own than " +
                                     (folder / "1").string() + ", expected the same: none and paper_7_1\n"));
}

TEST(Campaign, ShardsThatCannotBeAreRefused) {
  const fs::path folder = fresh_folder();
  const std::string campaign =
      "campaign " + with_runs_of("0.5", folder) + " --runs 6 -o " + (folder / "a").string();
  for (const auto& [words, why] :
       {std::pair{campaign + " --shard 4/3", "shard = 4/3, expected I/N"},
        {campaign + " --resume", "campaign.sqlite: is missing, expected runs to --resume"},
        {campaign + " --shard 1/2 --only 3", "--only"},
        {std::string("campaign"), "SCENARIO is missing"},
        {"campaign --runs 6 --merge " + (folder / "a").string(), "--runs"},
        {"campaign --merge " + (folder / "none").string(), "none/campaign.sqlite: is missing"}}) {
    const auto refused = sightline(words, folder);
    EXPECT_NE(refused.code, 0) << words;
    EXPECT_EQ(refused.out, "") << words;
    EXPECT_THAT(refused.err, HasSubstr(why)) << words;
  }
  (void)sightline(campaign + " --shard 1/2", folder);
  EXPECT_THAT(sightline(campaign + " --shard 2/2", folder).err, HasSubstr("another campaign: another shard"));
  EXPECT_THAT(sightline(campaign + " --shard 1/2 --resume", folder).err, testing::Not(HasSubstr("missing")));
  EXPECT_THAT(
      sightline("campaign --merge " + (folder / "a").string() + " -o " + (folder / "b").string(), folder).err,
      HasSubstr("of 2 shards 2 is missing"));
}

TEST(Campaign, BadInputEndsWithTwoAndSaysWhat) {
  const fs::path folder = fresh_folder();
  const auto refused = [&](const std::string& arguments) {
    const auto result = sightline("campaign " + arguments + " -o " + (folder / "a").string(), folder);
    EXPECT_EQ(result.code, 2) << arguments;
    EXPECT_FALSE(fs::exists(folder / "a" / "campaign.sqlite")) << arguments;
    return result.err + result.out;
  };
  EXPECT_EQ(refused("scenarios/yaw_step.toml"),
            "scenarios/yaw_step.toml:1: campaign is missing, expected [campaign] with what is drawn\n");
  EXPECT_THAT(refused(shipped + " --compare-with scenarios/yaw_step.toml"),
              HasSubstr("scenarios/yaw_step.toml:1: agent."));
  EXPECT_THAT(refused(shipped + " --compare-with scenarios/handover.toml"),
              HasSubstr("scenarios/handover.toml:1: obstacle.uav1.p[0] is missing"));
  EXPECT_THAT(refused("none.toml"), HasSubstr("none.toml:1: cannot be read"));
  for (const char* options : {"--runs 0", "--runs x", "--threads 0", "--only -1", "--seed -1"})
    EXPECT_NE(refused(shipped + " " + options), "");
  std::ofstream(folder / "file") << "x";
  EXPECT_EQ(sightline("campaign " + shipped + " -o " + (folder / "file").string(), folder).code, 2);
}

}  // namespace
}  // namespace sightline::cli
