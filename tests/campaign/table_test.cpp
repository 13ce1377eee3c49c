#include "sightline/campaign/table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <stdexcept>

#include "sightline/config.hpp"
#include "tests/support/child.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/small_campaign.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

fs::path flown_table(const fs::path& file, int threads, int runs = 20) {
  const Scenario scenario = small_campaign();
  RunTable table(file, scenario, *scenario.campaign, 9);
  fly_campaign(scenario, *scenario.campaign,
               {.runs = runs, .seed = 9, .threads = threads, .first = table.rows()},
               [&](const RunDraw& run, const RunResult& result) { table.add(run, result); });
  table.finish();
  return file;
}

std::string refusal(const fs::path& file, const Scenario& scenario, std::uint64_t seed) {
  return refusal_of([&] { RunTable(file, scenario, *scenario.campaign, seed); });
}

TEST(RunTable, TheFileIsTheSameByteForByteWhateverTheNumberOfThreads) {
  const fs::path folder = test::fresh_folder();
  const std::string one = test::read_file(flown_table(folder / "1.sqlite", 1));
  EXPECT_GT(one.size(), 8000U);
  EXPECT_TRUE(test::read_file(flown_table(folder / "2.sqlite", 2)) == one);
  EXPECT_TRUE(test::read_file(flown_table(folder / "1.sqlite", 5)) == one) << "the same again";
}

TEST(RunTable, GoesOnToTheSameBytesWhereverItStopped) {
  const fs::path folder = test::fresh_folder();
  const std::string whole = test::read_file(flown_table(folder / "whole.sqlite", 1));
  for (const int stop : {1, 7, 19}) {
    const fs::path file = folder / "pieces.sqlite";
    fs::remove(file);
    (void)flown_table(file, 1, stop);
    (void)flown_table(file, 2, stop);
    EXPECT_TRUE(test::read_file(flown_table(file, 1)) == whole) << stop;
  }
}

TEST(RunTable, ARowIsCommittedWithinASecondWithoutAnother) {
  const fs::path file = test::fresh_folder() / "a.sqlite";
  const Scenario scenario = small_campaign();
  const Variants variants(scenario, *scenario.campaign);
  RunWorker pilot(variants, *scenario.campaign);
  const auto rows = [&] {
    Database database(file, Database::Open::as_it_is);
    Database::Statement request(database, "SELECT count(*) FROM runs");
    request.step();
    return request.integer(0);
  };
  RunTable table(file, scenario, *scenario.campaign, 9);
  EXPECT_EQ(rows(), 0) << "the file appears with its tables";
  for (int i = 0; i < 3; ++i) {
    const RunDraw run = draw_run(*scenario.campaign, 9, i);
    table.add(run, pilot.fly(run));
  }
  EXPECT_TRUE(test::eventually([&] { return rows() == 3; }));
}

TEST(RunTable, ARowThatWasThereHoldsItsRunAndNoOther) {
  const fs::path file = flown_table(test::fresh_folder() / "a.sqlite", 1);
  const Scenario scenario = small_campaign();
  const Variants variants(scenario, *scenario.campaign);
  RunWorker pilot(variants, *scenario.campaign);
  RunTable table(file, scenario, *scenario.campaign, 9);
  EXPECT_EQ(table.rows(), 20);
  int outcomes = 0;
  for (int i = 0; i < outcome_count; ++i) outcomes += table.rows(static_cast<Outcome>(i));
  EXPECT_EQ(outcomes, 20);
  const RunDraw run = draw_run(*scenario.campaign, 9, 19);
  RunResult result = pilot.fly(run);
  EXPECT_TRUE(table.holds(run, result));
  result.robots[0].energy = std::nextafter(result.robots[0].energy, 1e9);
  EXPECT_FALSE(table.holds(run, result));
  EXPECT_FALSE(table.holds(draw_run(*scenario.campaign, 9, 20), result));
}

TEST(RunTable, RunsOfAnotherCampaignAreRefusedAndStay) {
  const fs::path folder = test::fresh_folder(), file = flown_table(folder / "a.sqlite", 1);
  const std::string before = test::read_file(file);
  Scenario scenario = small_campaign();
  const auto refused = [&](std::uint64_t seed = 9) { return refusal(file, scenario, seed); };
  EXPECT_EQ(refused(), "");
  EXPECT_THAT(refused(8),
              testing::HasSubstr("a.sqlite: holds 20 runs of another campaign: another seed, exp"));
  scenario.text += "# another\n";
  EXPECT_THAT(refused(), testing::HasSubstr("another text"));
  scenario = small_campaign();
  scenario.campaign->duration = 1.5;
  EXPECT_THAT(refused(), testing::HasSubstr("another duration"));
  scenario = small_campaign();
  scenario.campaign->draws.pop_back();
  EXPECT_THAT(refused(), testing::HasSubstr("another columns"));
  scenario = small_campaign();
  scenario.campaign->text = "of another scenario";
  EXPECT_THAT(refused(), testing::HasSubstr("another plan"));
  EXPECT_TRUE(test::read_file(file) == before);
}

TEST(RunTable, WhatIsNoCampaignIsRefusedAndStays) {
  const fs::path file = test::fresh_folder() / "a.sqlite";
  const Scenario scenario = small_campaign();
  const std::string text(5000, 'x');
  std::ofstream(file) << text;
  EXPECT_THAT(refusal(file, scenario, 9), testing::HasSubstr("a.sqlite: holds no campaign ("));
  EXPECT_EQ(test::read_file(file), text);
  fs::remove(file);
  {
    Database other(file, Database::Open::anew);
    other.execute("CREATE TABLE of_others(x)");
  }
  EXPECT_THAT(refusal(file, scenario, 9), testing::HasSubstr("no such table: runs"));
}

// Of each column, of a row in the middle, whatever is put in its place.
TEST(RunTable, ARowThatWasAlteredIsRefusedByItsRunAndStays) {
  const fs::path folder = test::fresh_folder(), file = flown_table(folder / "a.sqlite", 1, 8);
  const Scenario scenario = small_campaign();
  std::vector<std::string> names;
  {
    Database database(file, Database::Open::as_it_is);
    Database::Statement columns(database, "SELECT name FROM pragma_table_info('runs')");
    while (columns.step()) names.push_back(columns.text(0));
  }
  const fs::path altered = folder / "b.sqlite";
  const auto refused = [&](const std::string& change) {
    fs::copy_file(file, altered, fs::copy_options::overwrite_existing);
    Database(altered, Database::Open::as_it_is).execute(change);
    const std::string before = test::read_file(altered);
    const std::string said = refusal(altered, scenario, 9);
    EXPECT_TRUE(test::read_file(altered) == before);
    return said;
  };
  for (const std::string& name : names) {
    if (name == "index") continue;
    const std::string value = name == "outcome"  ? "'recovered!'"
                              : name == "digest" ? "'0'"
                                                 : "coalesce(2 * x + 1.5, 7)";
    std::string change = value;
    if (const auto x = change.find('x'); x != std::string::npos && value.front() != '\'')
      change.replace(x, 1, sql_name(name));
    EXPECT_THAT(refused("UPDATE runs SET " + sql_name(name) + " = " + change + " WHERE \"index\" = 3"),
                testing::HasSubstr("b.sqlite: the row of run 3 is not as it was written, expected"))
        << name;
  }
  EXPECT_THAT(refused("DELETE FROM runs WHERE \"index\" = 3"), testing::HasSubstr("not one after another"));
  EXPECT_THAT(refused("UPDATE runs SET \"index\" = CASE \"index\" WHEN 3 THEN -1 ELSE \"index\" END"),
              testing::HasSubstr("the row of run -1"));
  EXPECT_EQ(refused("DELETE FROM runs WHERE \"index\" = 7"), "") << "it is flown again";
}

// The plan and the text are the same, the numbers are not: a row of another program.
TEST(RunTable, RunsThatFlyOtherwiseNowDoNotGoOn) {
  const fs::path file = test::fresh_folder() / "a.sqlite";
  const Scenario scenario = small_campaign();
  const CampaignPlan& plan = *scenario.campaign;
  const Variants variants(scenario, plan);
  RunWorker pilot(variants, plan);
  const RunDraw run = draw_run(plan, 9, 0);
  for (const double by : {0.0, 1e-9}) {
    fs::remove(file);
    RunResult result = pilot.fly(run);
    result.energy += by;
    {
      RunTable table(file, scenario, plan, 9);
      table.add(run, result);
      table.finish();
    }
    RunTable table(file, scenario, plan, 9);
    const auto go_on = [&] { check_continues(table, file, scenario, plan, {.runs = 4, .seed = 9}); };
    const std::string said = refusal_of<std::invalid_argument>(go_on);
    EXPECT_THAT(said, by > 0 ? testing::HasSubstr("holds 1 runs, of which number 0 flies otherwise now")
                             : testing::HasSubstr(""));
    EXPECT_EQ(said.empty(), by == 0.0);
  }
}

TEST(RunTable, ACampaignWithoutARunIsBegunAnew) {
  const fs::path file = test::fresh_folder() / "a.sqlite";
  Scenario scenario = small_campaign();
  EXPECT_EQ(refusal(file, scenario, 8), "");
  EXPECT_EQ(refusal(file, scenario, 9), "");
}

TEST(RunTable, ItHasAColumnForEachFigureAndEachDraw) {
  const fs::path file = flown_table(test::fresh_folder() / "a.sqlite", 2);
  Database database(file, Database::Open::as_it_is);
  std::vector<std::string> names;
  Database::Statement columns(database, "SELECT name FROM pragma_table_info('runs')");
  while (columns.step()) names.push_back(columns.text(0));
  EXPECT_THAT(
      names, testing::ElementsAre(
                 "index", "seed", "outcome", "reason", "min_distance", "time_to_first_view",
                 "fraction_in_view", "could_brake", "violations", "energy", "chatter", "drift",
                 "longest_without_plan", "barrier_conflict", "longest_out_of_view", "view_margin",
                 "distance_margin", "landed", "status_converged", "status_stepped", "status_iteration_limit",
                 "status_deadline", "status_not_finite", "status_invalid_state", "uav0.range", "uav0.bearing",
                 "uav0.height", "uav0.heading", "uav0.v_f", "uav0.v_s", "agent.uav1.start.p[0]",
                 "agent.uav1.start.p[2]", "agent.uav1.reference.circle.rate", "uav0.energy",
                 "uav0.rms_position_error", "uav0.rms_heading_error", "uav1.energy",
                 "uav1.rms_position_error", "uav1.rms_heading_error", "digest"));
  Database::Statement about(database,
                            "SELECT group_concat(value, '|') FROM campaign WHERE key IN "
                            "('scenario', 'seed', 'version', 'duration')");
  ASSERT_TRUE(about.step());
  EXPECT_EQ(about.text(0), std::string("1.0|cooperative_localization|9|").append(version));
}

TEST(RunTable, ARowSaysWhatItsRunWas) {
  const fs::path file = flown_table(test::fresh_folder() / "a.sqlite", 1);
  const Scenario scenario = small_campaign();
  const Variants variants(scenario, *scenario.campaign);
  RunWorker pilot(variants, *scenario.campaign);
  Database database(file, Database::Open::as_it_is);
  Database::Statement rows(database, "SELECT * FROM runs ORDER BY \"index\"");
  for (int i = 0; i < 20; ++i) {
    const RunDraw run = draw_run(*scenario.campaign, 9, i);
    const RunResult r = pilot.fly(run);
    ASSERT_TRUE(rows.step());
    EXPECT_EQ(rows.integer(0), i);
    EXPECT_EQ(static_cast<std::uint64_t>(rows.integer(1)), run.seed);
    EXPECT_EQ(rows.text(2), to_string(r.outcome));
    EXPECT_FALSE(rows.number(3)) << "it did not fail";
    EXPECT_EQ(rows.number(4), r.min_distance);
    EXPECT_EQ(rows.number(13), r.barrier_conflict) << "the barrier is on";
    EXPECT_EQ(rows.number(14), r.longest_out_of_view);
    EXPECT_EQ(rows.number(15).value_or(-1), std::isnan(r.view_margin) ? -1 : r.view_margin);
    EXPECT_EQ(rows.number(16), r.distance_margin);
    EXPECT_EQ(rows.integer(17), r.landed ? 1 : 0);
    EXPECT_EQ(rows.number(5).value_or(-1), std::isnan(r.time_to_first_view) ? -1 : r.time_to_first_view);
    EXPECT_EQ(rows.number(6), r.fraction_in_view);
    EXPECT_EQ(rows.integer(7), r.could_brake ? 1 : 0);
    EXPECT_EQ(rows.integer(8), r.violations);
    EXPECT_EQ(rows.number(9), r.energy);
    EXPECT_EQ(rows.number(10), r.chatter);
    EXPECT_FALSE(rows.number(11)) << "a second is too short to judge";
    std::int64_t updates = 0;
    for (int s = 0; s < status_count; ++s) updates += rows.integer(18 + s);
    EXPECT_EQ(updates, 100);
    for (std::size_t v = 0; v < run.values.size(); ++v)
      EXPECT_EQ(rows.number(18 + status_count + static_cast<int>(v)), run.values[v]);
    const int last = 18 + status_count + static_cast<int>(run.values.size());
    ASSERT_EQ(r.robots.size(), 2U);
    for (int robot = 0; robot < 2; ++robot) {
      const RobotResult& one = r.robots[static_cast<std::size_t>(robot)];
      EXPECT_EQ(rows.number(last + 3 * robot), one.energy);
      const auto error = [&](int column) { return rows.number(last + 3 * robot + column).value_or(-1); };
      EXPECT_EQ(error(1), std::isnan(one.rms_position_error) ? -1 : one.rms_position_error);
      EXPECT_EQ(error(2), std::isnan(one.rms_heading_error) ? -1 : one.rms_heading_error);
    }
    EXPECT_FALSE(std::isnan(r.robots[1].rms_position_error)) << "it has a reference";
    EXPECT_NEAR(r.robots[0].energy + r.robots[1].energy, r.energy, 1e-12);
  }
  EXPECT_FALSE(rows.step());
}

TEST(RunTable, OfACertifiedViewARowHasItsShareAndItsEvents) {
  const fs::path file = test::fresh_folder() / "a.sqlite";
  const Scenario scenario =
      read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/paper_7_1.toml", built_in_registry(),
                    {"campaign.duration=8.0", R"(certify_view=[{observer="uav0",target="uav1"}])"});
  const Variants variants(scenario, *scenario.campaign);
  RunWorker pilot(variants, *scenario.campaign);
  const RunDraw run = draw_run(*scenario.campaign, 9, 0);
  const RunResult result = pilot.fly(run);
  ASSERT_EQ(result.views.size(), 1U);
  {
    RunTable table(file, scenario, *scenario.campaign, 9);
    table.add(run, result);
  }
  Database database(file, Database::Open::as_it_is);
  Database::Statement row(
      database, "SELECT \"uav0.view_certified\", \"uav0.view_active\", \"uav0.view_uncertified\" FROM runs");
  ASSERT_TRUE(row.step());
  EXPECT_EQ(row.number(0), result.views[0].certified);
  EXPECT_EQ(row.number(1), result.views[0].active);
  EXPECT_EQ(row.number(2), static_cast<double>(result.views[0].uncertified));
  EXPECT_GE(*row.number(2), 1) << "it starts outside the set";
}

TEST(RunTable, OfARobotThatIsLocalizedByViewARowHasErrorAndConsistency) {
  const fs::path file = test::fresh_folder() / "a.sqlite";
  const Scenario scenario = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/localize.toml",
                                          built_in_registry(), {"campaign.duration=8.0"});
  const Variants variants(scenario, *scenario.campaign);
  RunWorker pilot(variants, *scenario.campaign);
  const RunDraw run = draw_run(*scenario.campaign, 9, 0);
  const RunResult result = pilot.fly(run);
  ASSERT_EQ(result.localizations.size(), 1U);
  {
    RunTable table(file, scenario, *scenario.campaign, 9);
    table.add(run, result);
  }
  Database database(file, Database::Open::as_it_is);
  Database::Statement row(database,
                          "SELECT \"uav0.rmse\", \"uav0.anees\", \"uav0.longest_without_sight\" FROM runs");
  ASSERT_TRUE(row.step());
  EXPECT_EQ(row.number(0), result.localizations[0].rmse);
  EXPECT_EQ(row.number(1), result.localizations[0].anees);
  EXPECT_EQ(row.number(2), result.localizations[0].longest_without_sight);
  EXPECT_LT(*row.number(0), 0.1);
  EXPECT_GT(*row.number(1), 0.1);
  EXPECT_LT(result.longest_out_of_view, 0.1);
}

}  // namespace
}  // namespace sightline
