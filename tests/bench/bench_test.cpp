#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/command.hpp"
#ifdef SIGHTLINE_BENCH
#include "bench/bench.hpp"
#include "bench/estimate.hpp"
#include "bench/event.hpp"
#include "bench/ipopt.hpp"
#include "bench/swarm.hpp"
#include "cli/allocations.hpp"
#include "sightline/base.hpp"
#include "tests/support/paper_team.hpp"
#endif

namespace sightline {
namespace {

using testing::HasSubstr;

#ifdef SIGHTLINE_BENCH

nlohmann::ordered_json flown(const std::string& name) {
  const test::Folder folder("bench");
  const test::CommandResult result = test::sightline("bench --json --case " + name, folder.path());
  EXPECT_EQ(result.code, 0) << result.err;
  return nlohmann::ordered_json::parse(result.out);
}

std::vector<std::string> keys(const nlohmann::ordered_json& object) {
  std::vector<std::string> list;
  for (const auto& [key, value] : object.items()) list.push_back(key);
  return list;
}

void expect_figures(const std::string& name, double cost) {
  const nlohmann::ordered_json json = flown(name), row = json["cases"][0];
  EXPECT_THAT(keys(json), testing::ElementsAre("machine", "compiler", "cases"));
  EXPECT_THAT(keys(row), testing::ElementsAre("name", "solver", "agents", "masked", "median_us", "p99_us",
                                              "max_us", "first_us", "p9999_us", "input_error_max",
                                              "input_error_transient", "cost", "allocations", "krylov_mean"));
  EXPECT_EQ(row["name"], name);
  EXPECT_EQ(row["solver"], "newton_riccati");
  EXPECT_EQ(row["agents"], 2);
  EXPECT_EQ(row["masked"], name == "pair_masked");
  EXPECT_NEAR(row["cost"], cost, 0.01);
  EXPECT_LE(row["input_error_max"], 1e-5);
  EXPECT_GT(row["input_error_transient"], 0.0);
  EXPECT_LE(row["input_error_transient"], 1e-3);
  EXPECT_EQ(row["allocations"], 0);
  EXPECT_GE(row["krylov_mean"], 1.0);
  EXPECT_GT(row["median_us"], 0.0);
  EXPECT_LE(row["median_us"], row["p99_us"]);
  EXPECT_LE(row["p99_us"], row["max_us"]);
}

TEST(Bench, ThePairFliesAtTheCostOfTheOptimum) { expect_figures("pair", 75.755); }
TEST(Bench, TheMaskedPairFliesAtTheCostOfItsOptimum) { expect_figures("pair_masked", 76.22); }

TEST(Bench, WithoutJsonItPrintsATable) {
  const test::Folder folder("bench");
  const test::CommandResult result = test::sightline("bench --case saturating", folder.path());
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("| IPOPT us |"));
  EXPECT_THAT(result.out, HasSubstr("\n| saturating | newton_riccati | 2 |"));
}

TEST(Bench, AnUnknownNameIsRefusedWithTheKnownOnes) {
  const test::Folder folder("bench");
  const test::CommandResult no_case = test::sightline("bench --case chain_3", folder.path());
  EXPECT_EQ(no_case.code, 2);
  EXPECT_EQ(no_case.out, "");
  for (const std::string& name : bench_case_names()) EXPECT_THAT(no_case.err, HasSubstr(name));
  EXPECT_THAT(no_case.err, HasSubstr("swarm_M of 8 to 1024 robots"));
  for (const char* name :
       {"grid_7", "grid_1025", "grid_08", "grid_+8", "grid_8x", "grid_", "grid8", "swarm_7"})
    EXPECT_THROW((void)bench_case(name), std::invalid_argument) << name;
  for (const int robots : {9, 100, 1023})
    EXPECT_EQ(bench_case("strong_chain_" + std::to_string(robots)).team.agents().size(), size(robots));
  const test::CommandResult no_solver = test::sightline("bench --case pair --solver simplex", folder.path());
  EXPECT_EQ(no_solver.code, 2);
  EXPECT_EQ(no_solver.out, "");
  for (const char* name : {"simplex", "cmscgmres", "newton_riccati"})
    EXPECT_THAT(no_solver.err, HasSubstr(name));
}

TEST(Bench, WhatACaseCannotHeedIsRefused) {
  const test::Folder folder("bench");
  for (const char* options : {"barrier_4 --threads 2", "events_8 --threads 2", "estimate --threads 2",
                              "estimate --solver cmscgmres", "swarm_8 --solver cmscgmres"}) {
    const test::CommandResult refused =
        test::sightline(std::string("bench --case ") + options, folder.path());
    EXPECT_EQ(refused.code, 2) << options;
    EXPECT_THAT(refused.err, HasSubstr("expected")) << options;
  }
}

TEST(Bench, EveryCaseFliesNearTheOptimumOfIpopt) {
  for (const std::string& name : bench_case_names()) {
    const BenchCase what = bench_case(name);
    EXPECT_EQ(what.name, name);
    // Strong couplings from a start that is far from rest; of these the small team of each family.
    const bool is_strong =
        name.starts_with("cascade") || name.starts_with("strong") || name.starts_with("mutual");
    if (is_strong && what.team.agents().size() > 8) continue;
    const BenchRow row = run_bench(what, solver_named("newton_riccati"),
                                   {.updates = 20, .ipopt_every = 19, .allocations = cli::allocations});
    EXPECT_EQ(row.allocations, 0) << name;
    EXPECT_EQ(row.unconverged, 0) << name;
    EXPECT_EQ(row.ipopt_failed, 0) << name;
    EXPECT_LE(row.ipopt_difference, 1e-6) << name;
    EXPECT_LE(row.input_error_transient, is_strong ? 2e-2 : 5e-3) << name;
  }
}

TEST(Bench, TheSwarmIsTimedWhereManyPairsAreNear) {
  int pairs = 0;
  const std::vector<BenchRow> rows = run_swarm_bench(
      "swarm_32", {.allocations = cli::allocations, .progress = [&](int most) { pairs = most; }});
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_GE(pairs, 90);
  for (const BenchRow& row : rows) {
    EXPECT_EQ(row.agents, 32);
    EXPECT_EQ(row.allocations, 0);
    EXPECT_LE(row.median_us, row.p99_us);
    EXPECT_LE(row.p99_us, row.max_us);
  }
}

void expect_timed_without_allocations(const std::vector<BenchRow>& rows) {
  for (const BenchRow& row : rows) {
    EXPECT_EQ(row.allocations, 0);
    EXPECT_LE(row.median_us, row.p99_us);
  }
}

TEST(Bench, ATeamThatChangesIsTimedBeforeAndAfter) {
  int changes = 0;
  const std::vector<BenchRow> rows = run_event_bench(
      {.updates = 600, .allocations = cli::allocations, .progress = [&](int made) { changes = made; }});
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_GE(changes, 20) << "there, back, and weights that come to rest";
  expect_timed_without_allocations(rows);
}

TEST(Bench, FiltersAreTimedByTheSampleAndByTheLateSighting) {
  int estimated = 0;
  const std::vector<BenchRow> rows = run_estimate_bench(
      {.updates = 600, .allocations = cli::allocations, .progress = [&](int count) { estimated = count; }});
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_GE(estimated, 150) << "of 180 pictures, 5 % of them lost";
  expect_timed_without_allocations(rows);
  EXPECT_LT(rows[0].median_us, rows[1].median_us) << "a late sighting applies samples again";
}

TEST(Bench, AnySolverFliesACase) {
  const BenchRow row = run_bench(bench_case("pair"), solver_named("cmscgmres"), {.updates = 300});
  EXPECT_EQ(row.solver, "cmscgmres");
  EXPECT_GT(row.input_error_max, 1e-5) << "its barrier keeps it off the optimum";
  EXPECT_LE(row.input_error_max, 5e-3);
}

TEST(Ipopt, AMaskThatClosesACircleHasNoOrderToSolveIn) {
  Team team;
  std::vector<AgentId> robots;
  for (int i = 0; i < 3; ++i) robots.push_back(team.add(Multirotor{}));
  for (std::size_t i = 0; i < 3; ++i)
    team.couple(1.0 * KeepOut{}, Between{robots[i], robots[(i + 1) % 3]}, felt_by(robots[i]));
  EXPECT_THROW(IpoptReference(Ocp(team, bench_horizon)), std::invalid_argument);
}

TEST(Ipopt, ItsOptimumHasNoSlope) {
  for (const paper::Variant variant : {paper::Variant::joint, paper::Variant::masked}) {
    const Ocp ocp(paper::team(variant), bench_horizon);
    const std::vector<double> guess(static_cast<std::size_t>(ocp.nu() * bench_horizon.N), 0.0);
    EXPECT_LE(IpoptReference(ocp).solve(0.0, paper::saturating_start(), guess).residual, 1e-8);
  }
}

#else

TEST(Bench, ABuildWithoutItSaysSo) {
  const test::Folder folder("bench");
  const test::CommandResult result = test::sightline("bench", folder.path());
  EXPECT_EQ(result.code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, HasSubstr("SIGHTLINE_BENCH=ON"));
}

#endif

}  // namespace
}  // namespace sightline
