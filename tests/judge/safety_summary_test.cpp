#include "sightline/judge/safety_summary.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sightline {
namespace {

Scenario scenario(const std::string& safety) {
  return parse_scenario(R"(
[agent.a]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0] }
[agent.b]
robot = "multirotor"
start = { p = [3.0, 0.0, 1.0] }
[obstacle.o]
p = [9.0, 0.0, 1.0]
d_hard = 1.2
)" + safety,
                        "a.toml");
}

/// The same, whose bodies a test lets begin beyond its limits on purpose.
Scenario meant_outside(Scenario scenario) {
  scenario.safety->start_outside = true;
  return scenario;
}

const std::vector<Presence> there = {Presence::steered, Presence::steered, Presence::hold};
const std::vector<FallbackLevel> landing = {FallbackLevel::land, FallbackLevel::valid, FallbackLevel::valid};

/// A summary of bodies that are put where a test wants them, at rest.
class Judged {
 public:
  explicit Judged(const Scenario& scenario) : team_(scenario.team), summary_(scenario) {
    sample_.x.resize(static_cast<std::size_t>(team_.nx()));
    sample_.u.resize(static_cast<std::size_t>(team_.nu()));
  }
  void add(double time, const std::vector<Sight<double>>& sights, const std::vector<Presence>& presence,
           const std::vector<BarrierRecord>& barriers = {}, const std::vector<FallbackLevel>& levels = {}) {
    for (int i = 0; i < team_.bodies(); ++i) {
      const Pose<double> pose{sights[at(BodyId{i})].p, {1, 0}};
      team_.model(BodyId{i}).at_rest(pose, sample_.x.data() + team_.state_offset(BodyId{i}));
    }
    sample_.time = time;
    sample_.presence = presence;
    sample_.barriers = barriers;
    sample_.levels = levels;
    summary_.add(sample_, sights);
  }
  Sample& sample() { return sample_; }
  SafetySummary* operator->() { return &summary_; }

 private:
  Team team_;
  SafetySummary summary_;
  Sample sample_{};
};

std::vector<Sight<double>> places(double a, double b, double o) {
  std::vector<Sight<double>> sights(3);
  sights[0].p.x = a, sights[1].p.x = b, sights[2].p.x = o;
  for (Sight<double>& sight : sights) sight.p.z = 1.0;
  return sights;
}

TEST(SafetySummary, KeepsTheLeastOfEachHardDistanceAndItsTime) {
  Judged summary(scenario("[safety]\nbarrier = \"on\"\nd_hard = 0.5\n"));
  const std::vector<BarrierRecord> idle(2);
  summary.add(0.0, places(0, 3, 9), there, idle);
  summary.add(0.1, places(0, 0.6, 9), there, idle);
  summary.add(0.2, places(0, 4, 5.1), there, idle);
  EXPECT_EQ(summary->pairs().size(), 3U);
  const std::vector<std::string> broken = summary->broken();
  ASSERT_EQ(broken.size(), 1U);
  EXPECT_EQ(broken[0], "b came within 1.1 m of o at 0.20 s, d_hard is 1.2 m");
  const auto json = nlohmann::json::parse(summary->json());
  EXPECT_EQ(json.at("barrier"), "on");
  EXPECT_EQ(json.at("hard_distances").at(0).at("b"), "o") << "the worst first";
  EXPECT_NEAR(json.at("hard_distances").at(1).at("least").get<double>(), 0.6, 1e-12);
  EXPECT_EQ(json.at("hard_distances").at(1).at("time"), 0.1);
  const auto lines = safety_lines(summary->json());
  EXPECT_EQ(lines.at(0).second, "b and o: 1.1 m at least, BROKEN, to be 1.2 m");
  EXPECT_EQ(lines.at(1).second, "a and b: 0.6 m at least, kept 0.5 m");
}

TEST(SafetySummary, ADistanceThatIsJustReachedIsKept) {
  Judged summary(scenario("[safety]\nd_hard = 0.5\n"));
  summary.add(0.0, places(0, 0.5, 9), there, {});
  EXPECT_TRUE(summary->broken().empty());
  summary.add(0.0, places(0, 0.4999999, 9), there, {});
  EXPECT_EQ(summary->broken().size(), 1U);
}

// At rest before and after, and fast between.
std::vector<Sight<double>> passing(double a, double b, double speed) {
  std::vector<Sight<double>> sights = places(a, b, 99);
  sights[0].v.x = sights[1].v.x = speed;
  return sights;
}

TEST(SafetySummary, WhoeverOfTwoPassesTheOtherAndIsFarAgainWasNear) {
  for (const bool first : {true, false}) {
    Judged summary(scenario("[safety]\nd_hard = 0.5\n"));
    summary.add(0.0, first ? passing(0, 0.9, 40) : passing(0.9, 0, 40), there);
    summary.add(0.1, first ? passing(4, 0.9, 40) : passing(0.9, 4, 40), there);
    ASSERT_EQ(summary->broken().size(), 1U);
    EXPECT_NEAR(summary->least_distance(), 0.0, 1e-4);
    EXPECT_NEAR(summary->pairs()[0].least.time, 0.1 * 0.9 / 4, 1e-6);
  }
}

TEST(SafetySummary, ASummitBetweenSamplesIsJudgedAlsoWhereBothAreWithin) {
  const Scenario scenario = parse_scenario(
      "[agent.m]\nrobot = \"point_mass\"\nstart = { p = [0.0, 0.0, 1.0] }\n[safety]\nceiling = 1.1\n",
      "m.toml");
  SafetySummary summary(scenario);
  Sample sample;
  sample.presence = {Presence::steered};
  const auto add = [&](double time, double v, double u) {
    sample.time = time;
    sample.x = {0, 0, 1, 0, 0, v};
    sample.u = {0, 0, u};
    const std::vector sights = {true_sight(scenario.team, BodyId{0}, sample)};
    summary.add(sample, sights);
  };
  add(0.0, 0.0, 0.0);
  add(0.1, 0.0, 0.0);
  EXPECT_TRUE(summary.broken().empty());
  add(0.2, 2.0, -10.0);
  add(0.6, -2.0, 0.0);
  ASSERT_EQ(summary.broken().size(), 1U);
  EXPECT_NEAR(summary.bounds()[0].worst(), 1.2, 1e-3);
  EXPECT_NEAR(summary.bounds()[0].limit.worst().time, 0.4, 0.02);
}

TEST(SafetySummary, WhoComesBackWithinTheHardDistanceIsTooClose) {
  const std::vector<Presence> alone = {Presence::steered, Presence::absent, Presence::hold};
  Judged summary(scenario("[safety]\nd_hard = 0.5\n"));
  summary->look_at_brakes(places(0, 3, 9), there, 1.0);
  summary.add(0.0, places(0, 3, 9), there);
  summary.add(0.1, places(0, 3, 9), alone);
  EXPECT_FALSE(summary->too_close());
  summary.add(0.2, places(0, 0.4, 9), there);
  EXPECT_TRUE(summary->too_close_now());
  summary.add(0.3, places(0, 3, 9), there);
  EXPECT_FALSE(summary->too_close_now());
  EXPECT_TRUE(summary->too_close());
}

TEST(SafetySummary, WhoCouldBrakeIsJudgedOnceWhateverJoinsLater) {
  const std::vector<Presence> alone = {Presence::steered, Presence::steered, Presence::absent};
  Judged summary(scenario("[safety]\nd_hard = 0.5\n"));
  summary->look_at_brakes(places(0, 3, 9), alone, 1.0);
  auto sights = places(0, 0.6, 9);
  sights[1].v.x = -5.0;
  summary->look_at_brakes(sights, there, 1.0);
  EXPECT_TRUE(summary->could_brake());
  auto parting = places(0, 3, 4.3);
  parting[2].v.x = 5.0;
  Judged other(scenario("[safety]\nd_hard = 0.5\n"));
  other->look_at_brakes(parting, there, 1.0);
  EXPECT_TRUE(other->could_brake()) << "they part";
}

TEST(SafetySummary, ABodyThatIsNotThereComesNearNobody) {
  Judged summary(scenario("[safety]\nd_hard = 0.5\n"));
  const std::vector<Presence> alone = {Presence::steered, Presence::absent, Presence::absent};
  summary.add(0.0, places(0, 0.1, 0.2), alone, {});
  EXPECT_TRUE(summary->broken().empty());
  summary.add(0.1, places(0, 0.1, 9), there, {});
  EXPECT_EQ(summary->broken().size(), 1U);
}

std::vector<Sight<double>> heights(double a, double b) {
  std::vector<Sight<double>> sights = places(0, 3, 9);
  sights[0].p.z = a, sights[1].p.z = b;
  return sights;
}

TEST(SafetySummary, JudgesTheWallsThatTheScenarioStatesOrTheBarrierIsToKeep) {
  const auto judged = [](const std::string& safety) {
    Judged summary(scenario(safety));
    auto sights = heights(0.2, 11.0);
    sights[1].p.y = -102.0;
    summary.add(0.0, heights(1.0, 1.0), there, {});
    summary.add(0.1, sights, there, {});
    return summary->broken();
  };
  EXPECT_TRUE(judged("").empty());
  EXPECT_TRUE(judged("[safety]\nd_hard = 0.5\n").empty());
  EXPECT_EQ(
      judged("[safety]\nfloor = 0.25\n"),
      std::vector<std::string>{"a came to a height of 0.2 m at 0.10 s, the floor is 0.25 m, for 0.01 s"});
  EXPECT_EQ(
      judged("[safety]\nbarrier = \"on\"\n"),
      (std::vector<std::string>{"b came to |p_x| or |p_y| of 102 m at 0.10 s, the world is 100 m",
                                "b came to a height of 11 m at 0.10 s, the ceiling is 10 m, for 0.01 s",
                                "a came to a height of 0.2 m at 0.10 s, the floor is 0.3 m, for 0.01 s"}));
}

TEST(SafetySummary, TellsTheWorstOfEachWall) {
  Judged summary(scenario("[safety]\nfloor = 0.3\nceiling = 2.0\n"));
  summary.add(0.0, heights(1.0, 1.5), there, {});
  summary.add(0.1, heights(0.3 - 1e-9, 1.6), there, {});
  EXPECT_TRUE(summary->broken().empty()) << "rounding breaks nothing";
  summary.add(0.2, heights(0.25, 1.0), there, {});
  const auto json = nlohmann::json::parse(summary->json());
  const auto& wall = json.at("walls").at(0);
  EXPECT_EQ(wall.at("name"), "a");
  EXPECT_EQ(wall.at("wall"), "floor");
  EXPECT_EQ(wall.at("time"), 0.2);
  EXPECT_FALSE(wall.at("kept").get<bool>());
  EXPECT_NEAR(wall.at("worst").get<double>(), 0.25, 1e-12);
  const auto lines = safety_lines(summary->json());
  ASSERT_GE(lines.size(), 2U);
  EXPECT_EQ(lines[lines.size() - 2], (std::pair<std::string, std::string>(
                                         "floor", "a: 0.25 m at least, BROKEN, to be 0.3 m, for 0.10 s")));
  EXPECT_EQ(lines.back(), (std::pair<std::string, std::string>("ceiling", "b: 1.6 m at most, kept 2 m")));
}

TEST(SafetySummary, AWallThatIsPassedByLessThanAMillimetreIsBroken) {
  Judged summary(scenario("[safety]\nfloor = 0.3\n"));
  summary.add(0.0, heights(0.2995, 1.5), there, {});
  EXPECT_EQ(summary->broken().size(), 1U);
}

TEST(SafetySummary, ARobotThatLandsIsGroundedOrAbsentHasNoFloor) {
  const std::vector<FallbackLevel> grounded = {FallbackLevel::grounded, FallbackLevel::valid,
                                               FallbackLevel::valid};
  const std::vector<Presence> sinks = {Presence::land, Presence::steered, Presence::hold},
                              gone = {Presence::absent, Presence::steered, Presence::hold};
  for (const auto& [presence, levels] :
       {std::pair<std::vector<Presence>, std::vector<FallbackLevel>>{there, landing},
        {there, grounded},
        {sinks, {}},
        {gone, {}}}) {
    Judged summary(scenario("[safety]\nfloor = 0.3\n"));
    summary.add(0.0, heights(1.0, 1.0), there, {});
    summary.add(0.1, heights(0.05, 1.0), presence, {}, levels);
    EXPECT_TRUE(summary->broken().empty());
    summary.add(0.2, heights(0.05, 0.2), presence, {}, levels);
    EXPECT_EQ(summary->broken().size(), 1U) << "the other one has its floor";
  }
}

// 0.1 m and 0.2 m for 0.1 s each, then up to 0.35 m and down to 0.28 m.
std::vector<std::string> begun_below(Judged& summary, double last = 0.28) {
  summary.add(0.0, heights(0.1, 1.0), there);
  summary.add(0.1, heights(0.2, 1.0), there);
  summary.add(0.2, heights(0.35, 1.0), there);
  summary.add(0.3, heights(last, 1.0), there);
  return summary->broken();
}

TEST(SafetySummary, ARobotThatLandsHasACeiling) {
  Judged summary(scenario("[safety]\nceiling = 2.0\n"));
  summary.add(0.0, heights(2.5, 1.0), there, {}, landing);
  summary.add(0.1, heights(2.4, 1.0), there, {}, landing);
  EXPECT_EQ(summary->broken().size(), 1U);
}

TEST(SafetySummary, AStartBelowTheFloorBreaksItWithTheWorstValueAndTheTime) {
  Judged summary(scenario("[safety]\nfloor = 0.3\n"));
  EXPECT_EQ(
      begun_below(summary, 0.4),
      std::vector<std::string>{"a came to a height of 0.1 m at 0.00 s, the floor is 0.3 m, for 0.17 s"});
  const auto json = nlohmann::json::parse(summary->json());
  EXPECT_FALSE(json.at("walls").at(0).at("kept").get<bool>());
  EXPECT_NEAR(json.at("walls").at(0).at("broken_for").get<double>(), 0.1 + 0.1 * 2 / 3, 1e-9);
  EXPECT_EQ(safety_lines(summary->json()).back().second,
            "a: 0.1 m at least, BROKEN, to be 0.3 m, for 0.17 s");
}

TEST(SafetySummary, AStartThatIsMeantIsJudgedFromWhenItIsWithin) {
  const Scenario meant = meant_outside(scenario("[safety]\nfloor = 0.3\n"));
  Judged kept(meant), broken(meant), never(meant);
  EXPECT_TRUE(begun_below(kept, 0.4).empty());
  EXPECT_EQ(safety_lines(kept->json()).back().second,
            "a: 0.35 m at least, kept 0.3 m, outside at the start for 0.17 s, then kept");
  EXPECT_EQ(begun_below(broken).at(0).substr(0, 65),
            "a came to a height of 0.28 m at 0.30 s, the floor is 0.3 m, for 0");
  never.add(0.0, heights(0.1, 1.0), there);
  never.add(0.1, heights(0.2, 1.0), there);
  EXPECT_EQ(never->broken(), std::vector<std::string>{"a began at a height of 0.1 m at 0.00 s and never came "
                                                      "within, the floor is 0.3 m, for 0.10 s"});
  never.add(0.2, heights(0.05, 1.0), there);
  EXPECT_EQ(never->broken(),
            std::vector<std::string>{"a began at a height of 0.05 m at 0.20 s and never came "
                                     "within, the floor is 0.3 m, for 0.20 s"});
}

TEST(SafetySummary, AStartThatIsMeantAndEndsBeforeItIsWithinIsBroken) {
  Judged summary(meant_outside(scenario("[safety]\nfloor = 0.3\n")));
  summary.add(0.0, heights(0.1, 1.0), there);
  summary.add(0.1, heights(0.2, 1.0), there);
  summary.add(0.2, heights(0.25, 1.0), {Presence::absent, Presence::steered, Presence::steered});
  EXPECT_EQ(summary->broken(), std::vector<std::string>{
                                   "a came to a height of 0.1 m at 0.00 s, the floor is 0.3 m, for 0.10 s"});
}

TEST(SafetySummary, AStartWithinTheHardDistanceIsJudgedLikeOneBeyondAWall) {
  const auto flown = [](const Scenario& of) {
    Judged summary(of);
    summary.add(0.0, places(0, 0.3, 9), there);
    summary.add(0.1, places(0, 0.39, 9), there);
    summary.add(0.2, places(0, 0.48, 9), there);
    summary.add(0.3, places(0, 0.57, 9), there);
    return std::pair(summary->broken(), safety_lines(summary->json()).at(0).second);
  };
  const Scenario strict = scenario("[safety]\nd_hard = 0.5\n");
  EXPECT_EQ(flown(strict).first.at(0), "a came within 0.3 m of b at 0.00 s, d_hard is 0.5 m, for 0.22 s");
  EXPECT_TRUE(flown(meant_outside(strict)).first.empty());
  EXPECT_EQ(flown(meant_outside(strict)).second,
            "a and b: 0.57 m at least, kept 0.5 m, outside at the start for 0.22 s, then kept");
}

TEST(SafetySummary, OneThatCeasesToLandIsJudgedFromWhenItIsAboveTheFloor) {
  Judged summary(scenario("[safety]\nfloor = 0.3\n"));
  summary.add(0.0, heights(1.0, 1.0), there);
  summary.add(0.1, heights(0.05, 1.0), there, {}, landing);
  summary.add(0.2, heights(0.1, 1.0), there);
  summary.add(0.3, heights(0.4, 1.0), there);
  EXPECT_TRUE(summary->broken().empty());
}

TEST(SafetySummary, OneThatCeasesToLandAndLandsAgainHasNoFloorMeanwhile) {
  Judged summary(scenario("[safety]\nfloor = 0.3\n"));
  summary.add(0.0, heights(0.05, 1.0), there, {}, landing);
  summary.add(0.1, heights(0.05, 1.0), there);
  summary.add(0.2, heights(0.04, 1.0), there, {}, landing);
  EXPECT_TRUE(summary->broken().empty());
}

TEST(SafetySummary, RefusesAStartOutsideThatNoStartIs) {
  EXPECT_THROW((void)scenario("[safety]\nfloor = 0.3\nceiling = 2.0\nd_hard = 0.5\nstart_outside = true\n"),
               ScenarioError);
}

TEST(SafetySummary, CountsThePeriodsThatNobodySaw) {
  Judged summary(scenario("[safety]\nd_hard = 0.5\n"));
  summary.sample().truth_known = false;
  summary.sample().event_count = 1;
  summary.sample().events[0] = {0.0, EventKind::missed_period, 0, 12.0};
  summary.add(0.0, places(0, 3, 9), there);
  EXPECT_EQ(nlohmann::json::parse(summary->json()).at("unseen_periods"), 12);
  EXPECT_EQ(safety_lines(summary->json()).back().second,
            "12 were not seen, only the measurements around them are judged");
  Judged seen(scenario("[safety]\nd_hard = 0.5\n"));
  seen.sample() = summary.sample();
  seen.sample().truth_known = true;
  seen.add(0.0, places(0, 3, 9), there);
  EXPECT_FALSE(nlohmann::json::parse(seen->json()).contains("unseen_periods"));
}

TEST(SafetySummary, WhatDrivesHasNeitherFloorNorCeiling) {
  Judged summary(parse_scenario(
      "[agent.rover]\nrobot = \"omni_rover\"\nstart = { p = [0.0, 0.0, 0.0] }\n[safety]\nfloor = 0.3\n",
      "a.toml"));
  summary.add(0.0, std::vector<Sight<double>>(1), std::vector{Presence::steered}, {});
  EXPECT_TRUE(summary->broken().empty());
  EXPECT_TRUE(summary->bounds().empty());
}

TEST(SafetySummary, ARobotThatClimbsOnlyBySpeedAndPitchHasAFloorAndACeiling) {
  Judged summary(parse_scenario(R"toml(
[agent.plane]
start = { p = [0.0, 0.0, 3.0], heading = 0.0 }
[agent.plane.robot.text]
states = ["p_x", "p_y", "p_z", "psi", "v", "theta"]
inputs = ["thrust", "turn", "pitch"]
position = ["p_x", "p_y", "p_z"]
heading = "psi"
f.p_x = "v * cos(psi) * cos(theta)"
f.p_y = "v * sin(psi) * cos(theta)"
f.p_z = "v * sin(theta)"
f.psi = "turn"
f.v = "2 * thrust - 0.5 * v"
f.theta = "pitch - theta"
[safety]
floor = 0.3
ceiling = 10.0
)toml",
                                "plane.toml"));
  ASSERT_EQ(summary->bounds().size(), 2U);
  std::vector<Sight<double>> below(1);
  below[0].p.z = 1.0;
  summary.add(0.0, below, {Presence::steered}, {});
  below[0].p.z = -5.0;
  summary.add(0.1, below, {Presence::steered}, {});
  EXPECT_EQ(summary->broken_walls().size(), 1U);
}

constexpr const char* strip =
    "[[safety.zone]]\npolygon = [[1, -1], [2, -1], [2, 1], [1, 1]]\nkeep = \"outside\"\n";

TEST(SafetySummary, KeepsTheLeastReserveOfEachZoneAndItsTime) {
  Judged summary(scenario(strip));
  summary.add(0.0, places(0, 3, 9), there);
  summary.add(0.1, places(0.9, 3, 9), there);
  EXPECT_TRUE(summary->broken().empty());
  EXPECT_EQ(safety_lines(summary->json()).back().second, "a: 0.1 m from its boundary at least, kept outside");
  summary.add(0.2, places(1.3, 3, 9), there);
  ASSERT_EQ(summary->broken().size(), 1U);
  EXPECT_TRUE(summary->broken()[0].starts_with("a came 0.3 m inside zone 0 at 0.20 s, to be outside"))
      << summary->broken()[0];
  const auto zones = nlohmann::json::parse(summary->json()).at("zones");
  ASSERT_EQ(zones.size(), 2U);
  EXPECT_EQ(zones.at(0).at("name"), "a");
  EXPECT_EQ(zones.at(0).at("zone"), 0);
  EXPECT_EQ(zones.at(0).at("keep"), "outside");
  EXPECT_NEAR(zones.at(0).at("least").get<double>(), -0.3, 1e-9);
  EXPECT_EQ(zones.at(0).at("time"), 0.2);
  EXPECT_EQ(zones.at(0).at("kept"), false);
  EXPECT_NEAR(zones.at(1).at("least").get<double>(), 1.0, 1e-9);
  EXPECT_EQ(zones.at(1).at("kept"), true);
  const auto lines = safety_lines(summary->json());
  EXPECT_EQ(lines.back().first, "zone 0");
  EXPECT_TRUE(
      lines.back().second.starts_with("a: -0.3 m from its boundary at least, BROKEN, to be outside, for 0.0"))
      << lines.back().second;
}

TEST(SafetySummary, AZoneThatIsCrossedBetweenSamplesIsBroken) {
  Judged summary(scenario(strip));
  summary.add(0.0, passing(0, 9, 40), there);
  summary.add(0.1, passing(4, 9, 40), there);
  ASSERT_EQ(summary->broken_walls().size(), 1U);
  EXPECT_NEAR(summary->bounds()[0].worst(), -0.5, 1e-4);
  EXPECT_NEAR(summary->bounds()[0].limit.worst().time, 0.1 * 1.5 / 4, 1e-4);
}

TEST(SafetySummary, ARoomHasNoFloorForOneThatLandsAndKeepsItsWalls) {
  const std::string room =
      "[[safety.zone]]\npolygon = [[-5, -5], [12, -5], [12, 5], [-5, 5]]\nfrom = 0.5\nkeep = \"inside\"\n";
  Judged summary(scenario(room));
  summary.add(0.0, heights(1.0, 1.0), there);
  summary.add(0.1, heights(0.1, 1.0), there, {}, landing);
  summary.add(0.2, heights(0.05, 1.0), there);
  summary.add(0.3, heights(0.0, 1.0), there, {}, landing);
  EXPECT_TRUE(summary->broken().empty());
  std::vector<Sight<double>> beside = heights(0.0, 1.0);
  beside[0].p.y = 6.0;
  summary.add(0.4, beside, there, {}, landing);
  ASSERT_EQ(summary->broken().size(), 1U);
  EXPECT_TRUE(summary->broken()[0].starts_with("a came 1 m outside zone 0 at 0.40 s, to be inside"));
  Judged low(scenario(room));
  low.add(0.0, heights(1.0, 1.0), there);
  low.add(0.1, heights(0.4, 1.0), there);
  ASSERT_EQ(low->broken().size(), 1U);
  EXPECT_TRUE(low->broken()[0].starts_with("a came 0.1 m outside zone 0 at 0.10 s, to be inside"));
}

TEST(SafetySummary, TellsHowOftenTheBarrierActed) {
  for (const auto& [mode, word] : {std::pair{"on", "acted"}, {"report", "would have acted"}}) {
    Judged summary(scenario("[safety]\nbarrier = \"" + std::string(mode) + "\"\n"));
    std::vector<BarrierRecord> records(2);
    for (int k = 0; k < 8; ++k) {
      records[1] = {.active = k < 2, .conflict = k < 1};
      summary.add(0.1 * k, places(0, 3, 9), there, records);
    }
    summary.sample().of = Sample::Of::states;
    summary.add(0.8, places(0, 3, 9), there, records);  // no update
    const auto lines = safety_lines(summary->json());
    ASSERT_EQ(lines.size(), 8U);
    EXPECT_EQ(lines[6].first, "barrier of a");
    EXPECT_EQ(lines[6].second, std::string(word) + " 0.0 % of the time");
    EXPECT_EQ(lines[7].second, std::string(word) + " 25.0 % of the time, in conflict 12.5 %");
  }
}

TEST(SafetySummary, TellsHowLongAViewWasCertifiedAndItsLeastReserve) {
  Judged summary(scenario(R"(
[agent.b.sensor]
pitch = 0.5
offset = 0.17
[[couple]]
potential = { sensor_cone = { alpha = 0.5 } }
between = ["b", "o"]
[[couple]]
potential = { keep_out = { d_min = 1.0 } }
between = ["b", "o"]
[[couple]]
potential = { cohesion = { d_max = 2.0 } }
between = ["b", "o"]
[[certify_view]]
observer = "b"
target = "o"
speed_max = 0.3
)"));
  for (const double reserve : {0.2, 0.1, -0.3, 0.4}) {
    summary.sample().views.assign(2, {});
    summary.sample().views[1] = {
        .certified = reserve > 0, .active = reserve == 0.1, .reserve = reserve, .target = BodyId{2}};
    summary.add(0.0, places(0, 3, 9), there);
  }
  const auto json = nlohmann::json::parse(summary->json());
  ASSERT_EQ(json.at("views").size(), 1U);
  const auto& view = json.at("views")[0];
  EXPECT_EQ(view.at("observer"), "b");
  EXPECT_EQ(view.at("target"), "o");
  EXPECT_EQ(view.at("speed_max"), 0.3);
  EXPECT_EQ(view.at("certified"), 0.75);
  EXPECT_EQ(view.at("active"), 0.25);
  EXPECT_EQ(view.at("uncertified"), 0);
  ASSERT_EQ(summary->views().size(), 1U);
  EXPECT_EQ(summary->views()[0].observer, "b");
  EXPECT_EQ(summary->views()[0].certified, 0.75);
  EXPECT_EQ(view.at("reserve"), 0.1);
  const auto lines = safety_lines(summary->json());
  EXPECT_EQ(lines.back().first, "view of o");
  EXPECT_EQ(lines.back().second, "by b: certified 75.0 % of the time for 0.3 m/s, its filter acted 25.0 %");
}

TEST(SafetySummary, SaysNothingWhereNobodyAsks) {
  const Scenario free =
      parse_scenario("[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0.0, 0.0, 1.0] }\n", "a");
  EXPECT_EQ(SafetySummary(free).json(), "");
}

}  // namespace
}  // namespace sightline
