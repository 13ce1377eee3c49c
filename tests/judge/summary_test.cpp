#include "sightline/judge/summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "sightline/potentials.hpp"
#include "tests/support/command.hpp"
#include "tests/support/random_team.hpp"

namespace sightline {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

Scenario scenario_of(Team team) {
  Scenario scenario;
  scenario.name = "some \"name\"";
  scenario.team = std::move(team);
  scenario.simulation.settle = 1.0;
  scenario.simulation.rms_from = 2.0;
  return scenario;
}

// All zero but the headings, and sized as the loop's.
Sample sample_of(const Scenario& scenario, double time, std::size_t controllers = 1) {
  const Team& team = scenario.team;
  Sample sample;
  sample.time = time;
  sample.x.resize(static_cast<std::size_t>(team.nx()));
  for (int i = 0; i < team.bodies(); ++i) {
    team.model(BodyId{i}).at_rest({{}, {1, 0}}, sample.x.data() + team.state_offset(BodyId{i}));
  }
  sample.measured = sample.x;
  sample.u.resize(static_cast<std::size_t>(team.nu()));
  sample.raw_u = sample.u;
  sample.solvers.resize(controllers);
  sample.presence.assign(static_cast<std::size_t>(team.bodies()), Presence::steered);
  return sample;
}

// An observer at the origin that looks along x; its target, which is not controlled.
Scenario watch() {
  Team team;
  const AgentId observer = team.add(Multirotor{}, {.name = "observer"});
  const BodyId target = team.add(Obstacle{"target"});
  team.couple(1.0 * SensorCone{.mount = {.pitch = 0.0, .offset = 0.0}}, Between{observer, target});
  team.couple(1.0 * KeepOut{.d_min = 1.0}, Between{observer, target});
  return scenario_of(std::move(team));
}

// Whether the target stands ahead, `distance` away, or behind.
void add_watch(Summary& summary, const Scenario& scenario, double time, bool ahead, double distance = 2.0) {
  Sample sample = sample_of(scenario, time);
  sample.x[7] = ahead ? distance : -distance;
  summary.add(sample);
}

TEST(Summary, ABearingObservesAndSlopesOnDistanceAreLimits) {
  Team team;
  const AgentId observer = team.add(Multirotor{}, {.name = "observer"});
  const BodyId target = team.add(Obstacle{"target"});
  team.couple(1.0 * TooNear{.d_min = 0.7}, Between{observer, target});
  team.couple(1.0 * Bearing{.alpha = 0.3, .mount = {.pitch = 0.25}}, Between{observer, target});
  team.couple(1.0 * TooFar{.d_max = 1.9}, Between{observer, target});
  const std::vector<Observation> found = observations(team.couplings());
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].observer, observer);
  EXPECT_EQ(std::tie(found[0].alpha, found[0].d_min, found[0].d_max, found[0].mount.pitch),
            std::make_tuple(0.3, 0.7, 1.9, 0.25));
}

TEST(Summary, CostAndEnergyAreTheSumsOfTheirRatesOverAllSamples) {
  Random random(1);
  for (int round = 0; round < 20; ++round) {
    const Scenario scenario = scenario_of(random_team(random, 3, Feeling::anyone));
    const Team& team = scenario.team;
    Summary summary(scenario, 1);
    double cost = 0.0, energy = 0.0;
    for (int k = 0; k < 30; ++k) {
      Sample sample = sample_of(scenario, 0.01 * k);
      sample.x = random_states(random, team, 2.0);
      sample.u = random_numbers(random, team.nu(), 1.0);
      summary.add(sample);
      cost += 0.01 * stage_cost(team, sample.time, sample.x, sample.u);
      const auto at = static_cast<std::size_t>(team.input_offset(team.find(team.agents()[0].name)));
      for (std::size_t i = 0; i < 4; ++i) {
        energy += 0.01 * team.agents()[0].R[i] * sample.u[at + i] * sample.u[at + i];
      }
    }
    const SummaryValues values = summary.values();
    EXPECT_EQ(values.updates, 30);
    EXPECT_NEAR(values.cost, cost, 1e-12 * (1 + std::abs(cost)));
    EXPECT_NEAR(values.robots[0].energy, energy, 1e-12);
  }
}

TEST(Summary, ViewCountsAfterSettleAndIsForGoodFromTheLastTimeItWasWon) {
  Random random(2);
  for (int round = 0; round < 50; ++round) {
    const Scenario scenario = watch();
    Summary summary(scenario, 1);
    int seen = 0;
    double from = std::numeric_limits<double>::quiet_NaN(), nearest = 1e9, farthest = 0.0;
    for (int k = 0; k < 300; ++k) {
      const bool ahead = random() % 100 != 0;
      const double time = 0.01 * k, distance = uniform(random, 0.5, 3.0);
      add_watch(summary, scenario, time, ahead, distance);
      if (!ahead) from = std::numeric_limits<double>::quiet_NaN();
      if (ahead && std::isnan(from)) from = time;
      if (k < 100) continue;
      seen += ahead;
      nearest = std::min(nearest, distance);
      farthest = std::max(farthest, distance);
    }
    const auto pair = summary.values().pairs.at(0);
    EXPECT_EQ(pair.observer, "observer");
    EXPECT_EQ(pair.target, "target");
    EXPECT_EQ(std::isnan(pair.in_view_from), std::isnan(from));
    if (!std::isnan(from)) {
      EXPECT_EQ(pair.in_view_from, from);
    }
    EXPECT_DOUBLE_EQ(pair.in_view_fraction, seen / 200.0);
    EXPECT_DOUBLE_EQ(pair.distance_min, nearest);
    EXPECT_DOUBLE_EQ(pair.distance_max, farthest);
    EXPECT_NEAR(pair.view_angle_max, seen == 200 ? 0.0 : std::numbers::pi, 1e-12);
  }
}

TEST(Summary, ATargetIsLostWhereItWasNotSeenDuringAllOfTheLastTwoSeconds) {
  for (const int out : {0, 1, 199, 200, 201, 400}) {
    const Scenario scenario = watch();
    Summary summary(scenario, 1);
    for (int k = 0; k < 400; ++k) add_watch(summary, scenario, 0.01 * k, k < 400 - out);
    EXPECT_EQ(summary.target_lost_at_end(), out >= 200) << out;
    EXPECT_EQ(summary.out_of_view().size(), out >= 200 ? 1U : 0U);
    add_watch(summary, scenario, 4.0, true);
    EXPECT_FALSE(summary.target_lost_at_end());
  }
}

TEST(Summary, ALimitTellsHowOftenHowLongAndHowFarItWasBroken) {
  const Scenario scenario = watch();
  Summary summary(scenario, 1);
  for (int k = 0; k < 100; ++k) {
    const bool near = (k >= 10 && k < 30) || (k >= 40 && k < 45);
    add_watch(summary, scenario, 0.01 * k, true, !near ? 1.0 : k == 12 ? 0.5 : 0.75);
  }
  const SummaryValues values = summary.values();
  ASSERT_EQ(values.limits.size(), 2U);
  EXPECT_EQ(values.limits[0].name, "sensor_cone observer-target");
  EXPECT_EQ(values.limits[0].fraction, 0.0);
  EXPECT_EQ(values.limits[1].name, "keep_out observer-target");
  EXPECT_DOUBLE_EQ(values.limits[1].fraction, 0.25);
  EXPECT_NEAR(values.limits[1].longest, 0.2, 1e-12);
  EXPECT_DOUBLE_EQ(values.limits[1].worst, 0.5);
}

TEST(Summary, TwoLimitsOfOneKindOnTheSameBodiesAreJudgedEachByItself) {
  Team team;
  const AgentId robot = team.add(Multirotor{});
  const BodyId wall = team.add(Obstacle{"wall"});
  team.couple(1.0 * TooNear{.d_min = 1.5}, Between{robot, wall});
  team.couple(1.0 * TooNear{.d_min = 0.5}, Between{robot, wall});
  team.constrain(1.0 * AltitudeBand{.z_min = -1.0, .z_max = -0.5}, robot);
  team.constrain(1.0 * AltitudeBand{.z_min = -1.0, .z_max = 3.0}, robot);
  const Scenario scenario = scenario_of(std::move(team));
  Summary summary(scenario, 1);
  add_watch(summary, scenario, 0.0, true, 1.0);
  const auto limits = summary.values().limits;
  ASSERT_EQ(limits.size(), 4U);
  const auto worst = [&](std::size_t i) { return limits[i].worst; };
  EXPECT_EQ(std::make_tuple(worst(0), worst(1), worst(2), worst(3)), std::make_tuple(0.5, 0.0, 0.5, 0.0));
}

TEST(Summary, WhatAnEventAddsIsJudgedBesideWhatIsThere) {
  Team team;
  const AgentId robot = team.add(Multirotor{});
  const BodyId wall = team.add(Obstacle{"wall"});
  team.couple(1.0 * TooNear{.d_min = 0.5}, Between{robot, wall});
  Scenario scenario = scenario_of(std::move(team));
  const Coupling wider = {.term = 1.0 * TooNear{.d_min = 1.5}, .between = {robot, wall}, .felt_by = {robot}};
  const Constraint band = {.term = 1.0 * AltitudeBand{.z_min = 0.25, .z_max = 3.0}, .agent = robot};
  scenario.script.events.push_back(
      {.name = "more", .trigger = AtTime{0.0}, .actions = {AddCoupling{wider}, AddConstraint{band}}});
  Summary summary(scenario, 1);
  add_watch(summary, scenario, 0.0, true, 1.0);
  EXPECT_EQ(summary.values().limits.size(), 1U);
  Sample sample = sample_of(scenario, 0.01);
  sample.x[7] = 1.0;
  sample.events[0] = {0.01, EventKind::event_in_force, 0, 0.0};
  sample.event_count = 1;
  summary.add(sample);
  const auto limits = summary.values().limits;
  ASSERT_EQ(limits.size(), 3U);
  const auto worst = [&](std::size_t i) { return limits[i].worst; };
  EXPECT_EQ(std::make_tuple(worst(0), worst(1), worst(2)), std::make_tuple(0.0, 0.5, 0.25));
}

TEST(Summary, LeastDistanceIsThatOfARobotToAnyBodyAndNullForOneAlone) {
  Team pair;
  pair.add(Obstacle{"wall"});
  pair.add(Multirotor{});
  pair.add(Obstacle{"tree"});
  const Scenario scenario = scenario_of(std::move(pair));
  Summary summary(scenario, 1);
  Sample sample = sample_of(scenario, 0.0);
  sample.x[0] = 0.3;  // the wall; the tree, nearer to it than the robot, in place
  sample.x[13] = 0.3;
  summary.add(sample);
  EXPECT_DOUBLE_EQ(summary.values().min_distance, 0.3);

  Team one;
  one.add(Multirotor{});
  const Scenario alone = scenario_of(std::move(one));
  Summary lonely(alone, 1);
  lonely.add(sample_of(alone, 0.0));
  EXPECT_TRUE(Json::parse(lonely.json()).at("min_distance").is_null());
}

TEST(Summary, PositionErrorCountsFromRmsFromOnAndOnlyWhereQAsksForAPlace) {
  Team team;
  team.add(Multirotor{}, {.Q = {1, 1, 1, 0, 0, 0, 0}, .x_ref = Circle{.centre = {0, 0, 1}, .radius = 0.0}});
  team.add(Multirotor{}, {.Q = {0, 0, 0, 0, 0, 1, 1}});
  const Scenario scenario = scenario_of(std::move(team));
  Summary summary(scenario, 1);
  for (int k = 0; k < 400; ++k) {
    Sample sample = sample_of(scenario, 0.01 * k);
    sample.x[2] = k < 200 ? 9.0 : 1.0;
    sample.x[0] = k % 2 == 0 ? 0.3 : -0.4;
    summary.add(sample);
  }
  const SummaryValues values = summary.values();
  EXPECT_NEAR(values.robots[0].rms_position_error, std::sqrt(0.125), 1e-12);
  EXPECT_NEAR(values.robots[0].position_offset, 0.05, 1e-12) << "the mean of 0.3 and -0.4";
  EXPECT_NEAR(values.robots[0].tracking_error, 0.35, 1e-12) << "the rest";
  const Json agents = Json::parse(summary.json()).at("agents");
  EXPECT_NEAR(agents.at(0).at("position_offset").get<double>(), 0.05, 1e-12);
  EXPECT_NEAR(agents.at(0).at("tracking_error").get<double>(), 0.35, 1e-12);
  for (const double none : {values.robots[1].rms_position_error, values.robots[1].position_offset,
                            values.robots[1].tracking_error})
    EXPECT_TRUE(std::isnan(none));
  EXPECT_FALSE(agents.at(1).contains("position_offset"));
  EXPECT_FALSE(agents.at(0).contains("planned_tilt")) << "it does not lean";
}

TEST(Summary, HeadingErrorIsTheShortWayRoundFromRmsFromOnAndOnlyWhereQAsksForAHeading) {
  Team team;
  const auto back = [](double) { return Pose<double>{{0, 0, 1}, {std::cos(3.1), std::sin(3.1)}}; };
  team.add(Multirotor{}, {.Q = {0, 0, 0, 1, 1, 0, 0}, .x_ref = back});
  team.add(AngleMultirotor{}, {.Q = {0, 0, 0, 1, 0, 0}, .x_ref = back});
  team.add(Multirotor{}, {.Q = {1, 1, 1, 0, 0, 0, 0}, .x_ref = back});
  const Scenario scenario = scenario_of(std::move(team));
  Summary summary(scenario, 1);
  for (int k = 0; k < 400; ++k) {
    Sample sample = sample_of(scenario, 0.01 * k);
    const double psi = k < 200 ? 0.0 : k % 2 == 0 ? -3.1 : 3.1;
    sample.x[3] = std::cos(psi);
    sample.x[4] = std::sin(psi);
    sample.x[10] = psi;
    summary.add(sample);
  }
  const double across = 2 * (std::numbers::pi - 3.1), rms = across / std::sqrt(2.0);
  const SummaryValues values = summary.values();
  EXPECT_NEAR(values.robots[0].rms_heading_error, rms, 1e-9);
  EXPECT_NEAR(values.robots[1].rms_heading_error, rms, 1e-9);
  EXPECT_TRUE(std::isnan(values.robots[2].rms_heading_error));
  const Json agents = Json::parse(summary.json()).at("agents");
  EXPECT_NEAR(agents.at(0).at("rms_heading_error").get<double>(), rms, 1e-9);
  EXPECT_FALSE(agents.at(2).contains("rms_heading_error"));
}

TEST(Summary, TimesAreExactOverAllSolvesAndAllocationsTheMostOfOneUpdate) {
  const Scenario scenario = watch();
  Summary summary(scenario, 2);
  for (int k = 0; k < 50; ++k) {
    Sample sample = sample_of(scenario, 0.01 * k, 2);
    sample.solvers[0] = {Status::converged, 0.0, 1, 2.0 * k + 1, k == 7 ? 3 : 0};
    sample.solvers[1] = {Status::deadline, 0.0, 1, 2.0 * k + 2, k == 7 ? 2 : 0};
    summary.add(sample);
  }
  const SummaryValues values = summary.values();
  EXPECT_EQ(values.solve_us.median, 50.0);
  EXPECT_EQ(values.solve_us.p99, 99.0);
  EXPECT_EQ(values.solve_us.max, 100.0);
  EXPECT_DOUBLE_EQ(values.solve_us.mean, 50.5);
  EXPECT_EQ(values.allocations_per_update, 5);
  const Json statuses = Json::parse(summary.json()).at("status");
  EXPECT_EQ(statuses.size(), static_cast<std::size_t>(status_count));
  EXPECT_EQ(statuses.at("converged"), 50);
  EXPECT_EQ(statuses.at("deadline"), 50);
  EXPECT_EQ(statuses.at("not_finite"), 0);
}

TEST(Summary, WhatIsNotFiniteIsCountedAndNeverReachesTheJson) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (int place = 0; place < 3; ++place) {
      const Scenario scenario = watch();
      Summary summary(scenario, 1);
      add_watch(summary, scenario, 0.0, true);
      EXPECT_TRUE(summary.finite());
      Sample sample = sample_of(scenario, 1.0);
      (place == 0 ? sample.x : place == 1 ? sample.u : sample.raw_u)[0] = bad;
      summary.add(sample);
      EXPECT_FALSE(summary.finite());
      EXPECT_EQ(summary.not_finite(), 1);
      const Json json = Json::parse(summary.json());
      EXPECT_EQ(json.at("cost").is_null(), place < 2);
      EXPECT_FALSE(summary_lines(summary.json()).empty());
    }
  }
}

TEST(Summary, KeysStandAsDocumentedInTheirOrder) {
  const Scenario scenario = watch();
  Summary summary(scenario, 1);
  Sample sample = sample_of(scenario, 0.0);
  sample.events[0] = {0.0, EventKind::input_refused, 0, 0.0};
  sample.events[1] = {0.0, EventKind::solver_status, 0, 1.0};
  sample.event_count = 2;
  summary.add(sample);
  const auto json = nlohmann::ordered_json::parse(summary.json());
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  EXPECT_EQ(fmt::format("{}", fmt::join(keys, " ")),
            "scenario seed version solver settle updates cost solve_us allocations_per_update status "
            "without_plan not_finite input_violations applied_violations max_abs_input min_distance pairs "
            "agents limits chatter drift events");
  EXPECT_EQ(json.at("scenario"), "some \"name\"");
  EXPECT_TRUE(json.at("pairs").at(0).at("distance").at("min").is_null());
  EXPECT_EQ(json.at("events").size(), 1U);
  EXPECT_EQ(json.at("events").at(0).at("name"), "input_refused observer");
}

// Some line whose name begins so; none: "".
std::string line_of(const Summary& summary, std::string_view what) {
  for (const SummaryLine& line : summary_lines(summary.json())) {
    if (line.what.starts_with(what)) return line.value;
  }
  return "";
}

TEST(Summary, AnInputThatJumpsToAndFroIsToldWithItsCure) {
  for (const bool as_text : {true, false}) {
    Scenario scenario = watch();
    const BodyId target = scenario.team.find("target");
    if (as_text) scenario.team.couple(1.0 * Region("distance < 9 m"), Between{BodyId{0}, target});
    Summary summary(scenario, 1);
    EXPECT_EQ(line_of(summary, "chatter"), "");
    for (int k = 0; k < 200; ++k) {
      Sample sample = sample_of(scenario, 0.01 * k);
      sample.u[3] = k % 2 == 0 ? 0.41 : 0.0;
      summary.add(sample);
    }
    const Json found = Json::parse(summary.json()).at("chatter");
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].at("agent"), "observer");
    EXPECT_EQ(found[0].at("input"), "u_psi");
    EXPECT_NEAR(found[0].at("jump"), 0.41, 1e-12);
    EXPECT_THAT(line_of(summary, "chatter of observer"), HasSubstr("u_psi oscillates"));
    EXPECT_THAT(line_of(summary, "chatter of observer"), HasSubstr(as_text ? "smooth" : "a larger R"));
  }
}

TEST(Summary, ATeamThatLeavesIsToldWithItsSpeedUnlessItLandsOrTheRunIsShort) {
  const auto flown = [&](int seconds, int lands_at) {
    Team team;
    team.add(Multirotor{}, {.Q = {0, 0, 0, 0, 0, 1, 1}, .name = "free"});
    const Scenario scenario = scenario_of(std::move(team));
    Summary summary(scenario, 1);
    for (int k = 0; k < 10 * seconds; ++k) {
      Sample sample = sample_of(scenario, 0.1 * k);
      sample.presence = {Presence::steered};
      sample.x[2] = 0.1 * k;
      if (k == lands_at)
        sample.events[static_cast<std::size_t>(sample.event_count++)] = {0.1 * k, EventKind::land};
      summary.add(sample);
    }
    return std::pair(Json::parse(summary.json()).at("drift"), line_of(summary, "drift of free"));
  };
  const auto [drift, line] = flown(20, -1);
  ASSERT_EQ(drift.size(), 1U);
  EXPECT_NEAR(drift[0].at("speed"), 1.0, 1e-9);
  EXPECT_THAT(line, HasSubstr("(0.000, 0.000, 1.000) m/s"));
  EXPECT_TRUE(flown(20, 50).first.empty());
  EXPECT_TRUE(flown(5, -1).first.is_null());
}

TEST(Summary, LinesTellUnitsAndWhyAPairIsNotJudged) {
  const Scenario scenario = watch();
  Summary summary(scenario, 1);
  add_watch(summary, scenario, 0.0, false, 0.5);
  EXPECT_THAT(line_of(summary, "limit keep_out"), testing::EndsWith("by up to 0.500 m"));
  EXPECT_THAT(line_of(summary, "limit sensor_cone"), testing::EndsWith(" rad"));
  EXPECT_EQ(line_of(summary, "observer sees target"), "not judged: nothing after settle = 1.00 s");
  EXPECT_THAT(line_of(summary, "cost"), HasSubstr("which has no unit, summed over time"));
  for (const SummaryLine& line : summary_lines(summary.json()))
    EXPECT_THAT(line.value, Not(HasSubstr(" - "))) << line.what;
}

TEST(Summary, OfManyTheWorstTwelveAreToldAndHowManyMoreThereAre) {
  Team team;
  for (int i = 0; i < 40; ++i)
    team.add(Multirotor{}, {.Q = {1, 1, 1, 0, 0, 0, 0}, .name = fmt::format("r{}", i)});
  const Scenario scenario = scenario_of(std::move(team));
  Summary summary(scenario, 1);
  for (int k = 0; k < 30; ++k) {
    Sample sample = sample_of(scenario, 0.1 * k);
    for (std::size_t i = 0; i < 40; ++i) sample.x[7 * i] = static_cast<double>((7 * i) % 40);
    summary.add(sample);
  }
  std::vector<std::string> reported;
  for (const SummaryLine& line : summary_lines(summary.json())) {
    if (line.what.starts_with("r")) reported.push_back(line.what);
  }
  ASSERT_EQ(reported.size(), 12U);
  EXPECT_EQ(reported[0], "r17") << "its error is 39 m";
  EXPECT_EQ(line_of(summary, "..."), "28 more robots, none of them worse");
  EXPECT_EQ(Json::parse(summary.json()).at("agents").size(), 40U);
}

TEST(Summary, LinesRefuseWhatIsNoSummary) {
  for (const char* text : {"", "{}", "[1, 2]", "{\"status\": 3}"}) {
    EXPECT_THROW(summary_lines(text), std::runtime_error) << text;
  }
}

TEST(Summary, AFileThatCannotBeWrittenIsSaidAndLeavesNothing) {
  const test::Folder folder("summary_test");
  EXPECT_THAT(write_summary(folder.path() / "none", "{}"), HasSubstr("summary.json cannot be written: "));
  EXPECT_EQ(write_summary(folder.path(), "{}\n"), "");
  EXPECT_EQ(test::read_file(folder.path() / "summary.json"), "{}\n");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

}  // namespace
}  // namespace sightline
