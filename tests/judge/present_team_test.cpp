#include "sightline/judge/present_team.hpp"

#include <gtest/gtest.h>

#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

Scenario scenario_with(std::vector<TeamEvent> events) {
  Scenario scenario;
  scenario.team = event_team(3, 2);
  scenario.x0 = event_start(scenario.team, 2);
  scenario.script = {std::move(events)};
  return scenario;
}

Sample steered_sample(const Scenario& scenario, double time, std::vector<Event> events = {}) {
  Sample sample;
  sample.time = time;
  sample.x = scenario.x0;
  sample.u.assign(static_cast<std::size_t>(scenario.team.nu()), 0.25);
  sample.presence.assign(static_cast<std::size_t>(scenario.team.bodies()), Presence::steered);
  sample.event_count = static_cast<int>(events.size());
  std::copy(events.begin(), events.end(), sample.events.begin());
  return sample;
}

TEST(PresentTeam, OfATeamThatStaysIsTheScenarios) {
  const Scenario scenario = scenario_with({});
  PresentTeam present(scenario);
  const Sample sample = steered_sample(scenario, 3.0);
  EXPECT_FALSE(present.follow(sample));
  EXPECT_EQ(present.cost(sample), stage_cost(scenario.team, 3.0, sample.x, sample.u));
  EXPECT_EQ(present.couplings().size(), scenario.team.couplings().size());
  EXPECT_EQ(observations(all_couplings(scenario)).size(), 1U);
}

TEST(PresentTeam, FollowsTheEventsThatAreInForceAndNoOthers) {
  const Scenario scenario =
      scenario_with({{.name = "over",
                      .trigger = AtTime{2.0},
                      .actions = {Observe{AgentId{BodyId{2}}, BodyId{0}}},
                      .ramp = 1.0},
                     {.name = "gone", .trigger = AtTime{4.0}, .actions = {RemoveBody{BodyId{1}}}}});
  PresentTeam present(scenario);
  EXPECT_FALSE(present.follow(steered_sample(scenario, 2.0, {{2.0, EventKind::event_occurred, 0, 0.0}})));
  EXPECT_FALSE(present.follow(steered_sample(scenario, 2.0, {{2.0, EventKind::event_ignored, 0, 1.0}})));
  EXPECT_EQ(observations(present.couplings()).at(0).target, BodyId{1});
  EXPECT_TRUE(present.follow(steered_sample(scenario, 2.01, {{2.01, EventKind::event_in_force, 0, 0.0}})));
  EXPECT_EQ(observations(present.couplings()).at(0).target, BodyId{0});
  EXPECT_NE(present.agent(BodyId{1}), nullptr);
  EXPECT_TRUE(present.follow(steered_sample(scenario, 4.01, {{4.01, EventKind::event_in_force, 0, 1.0}})));
  EXPECT_EQ(present.agent(BodyId{1}), nullptr);
  EXPECT_EQ(observations(all_couplings(scenario)).size(), 2U) << "all there will be";
}

TEST(PresentTeam, TheCostMovesWithTheWeights) {
  const Scenario scenario = scenario_with({{.name = "more",
                                            .trigger = AtTime{2.0},
                                            .actions = {RetuneTerm{.name = "sees2", .weight = 0.8}},
                                            .ramp = 1.0}});
  PresentTeam present(scenario);
  const Sample sample = steered_sample(scenario, 2.0);
  const double before = present.cost(sample);
  ASSERT_TRUE(present.follow(steered_sample(scenario, 2.0, {{2.0, EventKind::event_in_force, 0, 0.0}})));
  const auto beside_tracking = [&](double t) {
    Sample later = sample;
    later.time = t;
    return present.cost(later) - stage_cost(scenario.team, t, sample.x, sample.u);
  };
  EXPECT_NEAR(present.cost(sample), before, 1e-12);
  EXPECT_NEAR(2 * beside_tracking(2.5), beside_tracking(3.0), 1e-12);
  EXPECT_GT(beside_tracking(3.0), 0.0);
}

}  // namespace
}  // namespace sightline
