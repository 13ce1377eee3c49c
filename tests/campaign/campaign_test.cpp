#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/analysis.hpp"
#include "sightline/registry.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/seeing_world.hpp"
#include "tests/support/small_campaign.hpp"

namespace sightline {
namespace {

/// Every number of a row, so that equal rows are equal bit for bit.
std::vector<double> numbers(const RunDraw& run, const RunResult& r) {
  std::vector<double> all = {static_cast<double>(run.index),
                             static_cast<double>(run.seed),
                             static_cast<double>(r.outcome),
                             r.min_distance,
                             std::isnan(r.time_to_first_view) ? -1.0 : r.time_to_first_view,
                             r.fraction_in_view,
                             static_cast<double>(r.violations),
                             r.energy};
  for (const std::int64_t count : r.statuses) all.push_back(static_cast<double>(count));
  all.insert(all.end(), run.values.begin(), run.values.end());
  return all;
}

using Rows = std::vector<std::vector<double>>;

Rows flown(const Scenario& scenario, int threads, int runs = 24, std::uint64_t seed = 1) {
  Rows rows;
  const int landed =
      fly_campaign(scenario, *scenario.campaign, {.runs = runs, .seed = seed, .threads = threads},
                   [&](const RunDraw& run, const RunResult& r) { rows.push_back(numbers(run, r)); });
  EXPECT_EQ(landed, runs);
  return rows;
}

TEST(Campaign, RowsAreTheSameWhateverTheNumberOfThreads) {
  Scenario scenario = small_campaign();
  scenario.simulation.disturbances.gust_sigma = 0.3;
  const Rows one = flown(scenario, 1);
  for (const int threads : {2, 3, 7}) EXPECT_EQ(flown(scenario, threads), one) << threads;
  EXPECT_NE(flown(scenario, 1, 24, 2), one);
}

TEST(Campaign, FliesInARegisteredWorldThatGivesDetections) {
  Registry registry;
  registry.worlds.add("seeing", [](const Scenario& flown) {
    return std::make_unique<test::SeeingWorld>(flown.team, flown.x0, plant_options(flown),
                                               sensor_options(flown));
  });
  const std::string text = test::read_file(SIGHTLINE_SOURCE_DIR "/scenarios/cooperative_localization.toml");
  Scenario scenario = parse_scenario(text + "\n[world]\nkind = \"seeing\"\n", "seeing.toml", registry);
  scenario.campaign->duration = 1.0;
  EXPECT_EQ(flown(scenario, 2), flown(small_campaign(), 2));
}

Scenario shipped_with_campaign(const std::string& name, const std::string& more, const std::string& draw) {
  const std::string text = test::read_file(SIGHTLINE_SOURCE_DIR "/" + name);
  return parse_scenario(text + more +
                            "\n[campaign]\nduration = 12.0\nview_within = 6.0\n[[campaign.draw]]\nkey = \"" +
                            draw + "\"\nuniform = [-0.2, 0.2]\n",
                        "a.toml");
}

TEST(Campaign, ATeamThatChangesIsJudgedByThoseWhoAreThere) {
  // Others join and leave, and who observes whom changes.
  const Scenario scenario =
      shipped_with_campaign("scenarios/join_and_leave.toml", "", "agent.uav1.start.p[1]");
  const Rows one = flown(scenario, 1, 6);
  EXPECT_EQ(flown(scenario, 3, 6), one);
  for (const auto& row : one) {
    EXPECT_EQ(row[2], static_cast<double>(Outcome::recovered)) << row[0];
    EXPECT_GE(row[4], 0.0);
  }
}

TEST(Campaign, ATeamThatPlansInPartsLosesOtherMessagesInEachRun) {
  const Scenario lossy = shipped_with_campaign(
      "scenarios/chain8.toml",
      "\n[partition]\nfront = [\"uav0\", \"uav1\", \"uav2\", \"uav3\"]\nback = [\"uav4\", "
      "\"uav5\", \"uav6\", \"uav7\"]\n[partition.exchange]\nloss = 0.5\ndelay = 0.05\n",
      "agent.uav0.start.p[1]");
  const Rows one = flown(lossy, 1, 3);
  EXPECT_EQ(flown(lossy, 2, 3), one);
  const Scenario clear = shipped_with_campaign("scenarios/chain8.toml", "", "agent.uav0.start.p[1]");
  const Rows whole = flown(clear, 2, 3);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i][2], static_cast<double>(Outcome::recovered));
    EXPECT_NE(one[i][7], whole[i][7]);
    EXPECT_NEAR(one[i][7], whole[i][7], 0.05 * whole[i][7]);
  }
}

// More teams than solvers are kept: each is made again, and nothing of the old ones is left.
TEST(Campaign, APilotFliesManyTeamsAsNewPilotsWould) {
  Scenario scenario = small_campaign();
  scenario.campaign->duration = 0.2;
  scenario.campaign->draws.push_back({"couple[0].weight", {.values = {0.5, 2.0}}});
  scenario.campaign->draws.push_back(
      {"horizon.stages", {.kind = Distribution::Kind::choice, .values = {10, 20}, .fractions = {0.5, 0.5}}});
  const Rows rows = flown(scenario, 1, 12);
  const Variants variants(scenario, *scenario.campaign);
  for (int index = 0; index < 12; ++index) {
    const RunDraw run = draw_run(*scenario.campaign, 1, index);
    EXPECT_EQ(numbers(run, RunWorker(variants, *scenario.campaign).fly(run)),
              rows[static_cast<std::size_t>(index)]);
  }
}

TEST(Campaign, ARefusedNumberEndsTheCampaignWithItsSentence) {
  Scenario scenario = small_campaign();
  scenario.campaign->duration = 0.1;
  scenario.campaign->draws.push_back({"couple[0].weight", {.values = {-0.1, 2.0}}});
  for (const int threads : {1, 3}) {
    const auto fly = [&] {
      fly_campaign(scenario, *scenario.campaign, {.runs = 400, .seed = 1, .threads = threads},
                   [](const RunDraw&, const RunResult&) {});
    };
    EXPECT_THAT(refusal_of<ScenarioError>(fly), testing::HasSubstr("couple[0].weight = -0.0"));
  }
}

TEST(Campaign, WhatTheTableThrowsEndsTheCampaign) {
  for (const int threads : {1, 3}) {
    int landed = 0;
    const auto full = [&](const RunDraw&, const RunResult&) {
      if (++landed == 5) throw std::runtime_error("the disk is full");
    };
    const Scenario scenario = small_campaign();
    EXPECT_THROW(
        fly_campaign(scenario, *scenario.campaign, {.runs = 100, .seed = 1, .threads = threads}, full),
        std::runtime_error);
    EXPECT_EQ(landed, 5);
  }
}

TEST(Campaign, StoppedItHandsOverWhatWasInTheAir) {
  std::atomic<bool> stop{false};
  int landed = 0;
  const Scenario scenario = small_campaign();
  const int count =
      fly_campaign(scenario, *scenario.campaign, {.runs = 1000, .seed = 1, .threads = 3, .stop = &stop},
                   [&](const RunDraw& run, const RunResult&) {
                     EXPECT_EQ(run.index, landed++);
                     if (landed == 4) stop = true;
                   });
  EXPECT_EQ(count, landed);
  EXPECT_GE(landed, 4);
  EXPECT_LT(landed, 20);
}

}  // namespace
}  // namespace sightline
