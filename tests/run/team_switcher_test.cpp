#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "sightline/loop.hpp"
#include "sightline/potentials.hpp"
#include "sightline/run/controller.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/counted_new.hpp"
#include "tests/support/event_team.hpp"
#include "tests/support/gradient_planner.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/team_flight.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

TeamEvent at(double t, Action action, double ramp = 0.0) {
  return {.name = "", .trigger = AtTime{t}, .actions = {std::move(action)}, .ramp = ramp};
}

const Event* event_of(const FlownPeriod& period, EventKind kind) {
  for (const Event& event : period.events) {
    if (event.kind == kind) return &event;
  }
  return nullptr;
}

std::size_t period_of(const TeamFlight& flight, EventKind kind) {
  for (std::size_t k = 0; k < flight.flown.size(); ++k) {
    if (event_of(flight.flown[k], kind) != nullptr) return k;
  }
  return flight.flown.size();
}

double largest_jump(const TeamFlight& flight, std::size_t from, std::size_t to, std::size_t first,
                    std::size_t n) {
  double jump = 0.0;
  for (std::size_t k = from; k < to; ++k) {
    for (std::size_t i = first; i < first + n; ++i) {
      jump = std::max(jump, std::abs(flight.flown[k].u[i] - flight.flown[k - 1].u[i]));
    }
  }
  return jump;
}

TEST(TeamSwitcher, TheTeamChangesExactlyOnePeriodAfterTheTrigger) {
  const Team all = event_team(3);
  const TeamFlight flight =
      fly_script(all, event_start(all), {{at(0.5, RemoveBody{BodyId{2}, Afterwards::hold})}}, 1.0);
  EXPECT_EQ(period_of(flight, EventKind::event_occurred), 50U);
  EXPECT_EQ(period_of(flight, EventKind::event_in_force), 51U);
  EXPECT_EQ(flight.flown[50].presence[2], Presence::steered);
  EXPECT_EQ(flight.flown[51].presence[2], Presence::hold);
  EXPECT_EQ(period_of(flight, EventKind::team_late), flight.flown.size());
}

TEST(TeamSwitcher, AScriptInWhichNothingHappensFliesAsTheSolverAlone) {
  const Team all = event_team(4);
  const std::vector<double> x0 = event_start(all);
  const TeamFlight flight = fly_script(all, x0, {{at(9.0, RemoveBody{BodyId{2}})}}, 1.0);
  NewtonRiccati solver(all, Horizon{});
  Plant plant(all, x0);
  for (const FlownPeriod& period : flight.flown) {
    const auto u = solver.step(period.time, plant.x());
    ASSERT_TRUE(std::equal(u.begin(), u.end(), period.u.begin())) << period.time;
    ASSERT_TRUE(plant.step(u, 0.01));
  }
}

TEST(TeamSwitcher, TheNextTeamIsAtItsOptimumFromItsFirstUpdateOn) {
  const Team all = event_team(5, 2);
  for (const Action& action :
       std::initializer_list<Action>{RemoveBody{BodyId{4}}, RetuneTerm{.name = "sees3", .weight = 0.8},
                                     Observe{AgentId{BodyId{2}}, BodyId{0}}}) {
    const TeamFlight flight = fly_script(all, event_start(all, 2), {{at(3.0, action, 1.0)}}, 5.0, {}, true);
    const std::size_t swap = period_of(flight, EventKind::event_in_force);
    ASSERT_EQ(swap, 301U);
    EXPECT_LE(flight.flown[swap + 3].kkt, 1e-4);
    EXPECT_LE(largest_jump(flight, swap, swap + 120, 0, flight.flown[0].u.size()), 0.3);
  }
}

TEST(TeamSwitcher, RobotsTwoCouplingsAwayDoNotNotice) {
  const Team all = event_team(6);
  const std::vector<double> x0 = event_start(all);
  const TeamFlight quiet = fly_script(all, x0, {{at(99.0, RemoveBody{BodyId{5}})}}, 5.0);
  const TeamFlight flight = fly_script(all, x0, {{at(3.0, RemoveBody{BodyId{5}, Afterwards::hold})}}, 5.0);
  for (std::size_t k = 0; k < flight.flown.size(); ++k) {
    for (std::size_t i = 0; i < 4U * 4U; ++i) {
      ASSERT_LT(std::abs(flight.flown[k].u[i] - quiet.flown[k].u[i]), 0.02) << flight.flown[k].time;
    }
  }
}

TEST(TeamSwitcher, WhatCannotBeIsToldOnceAndTheTeamStays) {
  const Team all = event_team(3);
  TeamEvent again{.name = "", .trigger = Signal{"again"}, .actions = {AddBody{BodyId{1}}}};
  again.repeat = true;
  const TeamFlight flight = fly_script(all, event_start(all), {{again}}, 1.0, {}, false,
                                       {{0.2, "again"}, {0.4, "again"}, {0.6, "again"}, {0.7, "nobody"}});
  int occurred = 0, ignored = 0, in_force = 0;
  for (const FlownPeriod& period : flight.flown) {
    for (const Event& event : period.events) {
      occurred += event.kind == EventKind::event_occurred;
      ignored += event.kind == EventKind::event_ignored;
      in_force += event.kind == EventKind::event_in_force;
    }
  }
  EXPECT_EQ(occurred, 3);
  EXPECT_EQ(ignored, 1);
  EXPECT_EQ(in_force, 0);
}

TEST(TeamSwitcher, ARobotThatIsAbsentRestsAndOneThatComesIsSteered) {
  const Team all = event_team(3);
  const std::vector<double> x0 = event_start(all);
  const TeamFlight flight = fly_script(all, x0, {{at(1.0, AddBody{BodyId{2}}, 1.0)}}, 4.0,
                                       {Presence::steered, Presence::steered, Presence::absent}, true);
  const std::size_t of_it = 14;
  for (std::size_t k = 0; k <= 101; ++k) {
    for (std::size_t i = 0; i < 7; ++i) ASSERT_EQ(flight.flown[k].x[of_it + i], x0[of_it + i]);
    ASSERT_EQ(flight.flown[k].presence[2], k <= 100 ? Presence::absent : Presence::steered);
  }
  EXPECT_NE(flight.flown[200].x[of_it], x0[of_it]);
  EXPECT_LE(largest_jump(flight, 101, 300, 0, 12), 0.3);
}

TEST(TeamSwitcher, OnASteadyClockTheLoopNeverWaits) {
  const Team all = event_team(3);
  TeamSwitcher team_switcher(ActiveTeam(all), {{at(0.05, RetuneTerm{.name = "sees1", .weight = 0.5}, 0.1)}},
                             newton_riccati_of(Horizon{}));
  ModelWorld world(all, event_start(all));
  SteadyClock clock;
  const Controllers controllers = {*team_switcher.present().solver};
  KeepSamples sink(sized_sample(all, controllers, &team_switcher));
  Loop loop(world, controllers, clock, sink, {.duration = 1.0, .team_switcher = &team_switcher});
  const LoopOutcome outcome = loop.run();
  EXPECT_TRUE(outcome.finite);
  int in_force = 0;
  for (const FlownPeriod& period : sink.flown)
    in_force += event_of(period, EventKind::event_in_force) != nullptr;
  EXPECT_EQ(in_force, 1);
}

TEST(TeamSwitcher, NothingInTheLoopAllocatesWhenATeamChanges) {
  ASSERT_GT(
      [before = allocations_here()] {
        const std::vector<double> some(3);
        return allocations_here() - before;
      }(),
      0)
      << "the counter counts";
  const Team team = event_team(6, 2);
  const TeamEvent there{.name = "there",
                        .trigger = AfterTime{0.1},
                        .actions = {Observe{AgentId{BodyId{2}}, BodyId{0}}},
                        .stage = "start",
                        .enter = "there"};
  const TeamEvent back{
      .name = "back",
      .trigger = Condition{DistanceOf{BodyId{0}, BodyId{1}}, Condition::Side::above, 0.1, 0.0, 0.1},
      .actions = {Observe{AgentId{BodyId{2}}, BodyId{1}}},
      .stage = "there",
      .enter = "start",
      .ramp = 0.05};
  const TeamEvent fails{
      .name = "fails", .trigger = Signal{"fail"}, .actions = {RemoveBody{BodyId{5}, Afterwards::land}}};
  TeamSwitcher team_switcher(ActiveTeam(team), {{there, back, fails}}, newton_riccati_of(Horizon{}));
  ModelWorld world(team, event_start(team, 2));
  Guard guard(team, {.supervisor = SupervisorOptions{}, .barrier = BarrierMode::on});
  const Controllers controllers = {*team_switcher.present().solver};
  SpscQueue<Sample> ring(1000, sized_sample(team, controllers, &team_switcher));
  SimulatedClock clock;
  Loop loop(world, controllers, clock, ring,
            {.duration = 3.0,
             .allocations = allocations_here,
             .guard = &guard,
             .team_switcher = &team_switcher,
             .signals = {{1.0, "fail"}}});
  const std::int64_t before = allocations_here();
  const LoopOutcome outcome = loop.run();
  EXPECT_EQ(allocations_here(), before);
  EXPECT_EQ(outcome.max_allocations, 0);
  EXPECT_EQ(outcome.updates, 300);
  int changes = 0;
  for (const Sample* sample = ring.front(); sample != nullptr; ring.pop(), sample = ring.front()) {
    for (int i = 0; i < sample->event_count; ++i) {
      changes += sample->events[static_cast<std::size_t>(i)].kind == EventKind::event_in_force;
    }
  }
  EXPECT_GT(changes, 10);
}

TEST(TeamSwitcher, TriggersOfTextAllocateNothing) {
  const Team team = event_team(3);
  const auto when = [](Potential limit) {
    TeamEvent event = at(0.0, SetReference{AgentId{BodyId{0}}, Circle{.centre = {0, 0, 1}, .radius = 0.3}});
    event.trigger = Condition{.measure = ExcessOf{std::move(limit), BodyId{1}, BodyId{0}}, .threshold = 9.0};
    return event;
  };
  const Region camera = Region(all_of({"bearing < 0.4", "0.3 m < range < 6 m"}), {{"far", "6 m"}});
  TeamSwitcher team_switcher(ActiveTeam(team),
                             {{when(camera), when(Region("target.v_x < 0.3 m/s")), when(SensorCone{})}},
                             newton_riccati_of(Horizon{}));
  ModelWorld world(team, event_start(team));
  const Controllers controllers = {*team_switcher.present().solver};
  SpscQueue<Sample> ring(1000, sized_sample(team, controllers, &team_switcher));
  SimulatedClock clock;
  Loop loop(world, controllers, clock, ring,
            {.duration = 0.5, .allocations = allocations_here, .team_switcher = &team_switcher});
  const std::int64_t before = allocations_here();
  const LoopOutcome outcome = loop.run();
  EXPECT_EQ(allocations_here() - before, 0);
  EXPECT_EQ(outcome.max_allocations, 0) << "looks at triggers count too";
}

/// A solver of any team, but not of this one, or not for the moment.
MakeSolver fails_where(std::function<bool(const Team&)> fails) {
  return [fails = std::move(fails), make = newton_riccati_of(Horizon{})](Team team) {
    if (fails(team)) throw std::bad_alloc();
    return make(std::move(team));
  };
}

struct Reported {
  std::vector<std::size_t> in_force, ignored;
  Team team;  // at the end
};
Reported fly_failing(const Team& all, const Script& script, MakeSolver make) {
  TeamSwitcher team_switcher(ActiveTeam(all), script, std::move(make));
  ModelWorld world(all, event_start(all));
  SimulatedClock clock;
  const Controllers controllers = {*team_switcher.present().solver};
  KeepSamples sink(sized_sample(all, controllers, &team_switcher));
  Loop loop(world, controllers, clock, sink, {.duration = 0.5, .team_switcher = &team_switcher});
  EXPECT_TRUE(loop.run().finite);
  Reported reported;
  for (const FlownPeriod& period : sink.flown) {
    for (const Event& event : period.events) {
      const auto place = static_cast<std::size_t>(event.value);
      if (event.kind == EventKind::event_in_force) reported.in_force.push_back(place);
      if (event.kind == EventKind::event_ignored) reported.ignored.push_back(place);
    }
  }
  reported.team = team_switcher.present().solver->ocp().team();
  return reported;
}

int couplings_called(const Team& team, std::string_view name) {
  return static_cast<int>(std::count_if(team.couplings().begin(), team.couplings().end(),
                                        [&](const Coupling& c) { return c.name == name; }));
}

/// A coupling of uav2, and a solver of any team without it.
Coupling bad_coupling() {
  const AgentId uav2{BodyId{2}};
  return {.term = 1.0 * KeepOut{}, .between = {uav2, BodyId{0}}, .felt_by = {uav2}, .name = "bad"};
}
MakeSolver fails_with_bad() {
  return fails_where([](const Team& team) { return couplings_called(team, "bad") > 0; });
}

TEST(TeamSwitcher, ATeamThatCannotBeMadeLeavesNoTrace) {
  const Team all = event_team(3);
  const Reported reported =
      fly_failing(all,
                  {{at(0.1, AddCoupling{bad_coupling()}), at(0.2, RetuneTerm{.name = "sees1", .weight = 0.7}),
                    at(0.3, RemoveTerm{"off2"})}},
                  fails_with_bad());
  EXPECT_EQ(reported.ignored, std::vector<std::size_t>{0});
  EXPECT_EQ(reported.in_force, (std::vector<std::size_t>{1, 2}));
  EXPECT_EQ(couplings_called(reported.team, "bad"), 0);
  EXPECT_EQ(couplings_called(reported.team, "off2"), 0);
  EXPECT_EQ(reported.team.couplings().size(), all.couplings().size() - 1);
}

TEST(TeamSwitcher, WhereMemoryFailedOnceALaterEventGoesOnFromTheTeamThereWas) {
  const Team all = event_team(3);
  int made = 0;
  const Reported reported =
      fly_failing(all, {{at(0.1, RemoveTerm{"off1"}), at(0.2, RetuneTerm{.name = "sees1", .weight = 0.7})}},
                  fails_where([&made](const Team&) { return ++made == 2; }));
  EXPECT_EQ(reported.ignored, std::vector<std::size_t>{0});
  EXPECT_EQ(reported.in_force, std::vector<std::size_t>{1});
  EXPECT_EQ(couplings_called(reported.team, "off1"), 1) << "the keep-out whose removal failed is still there";
}

TEST(TeamSwitcher, OfSeveralEventsAtOnceOnlyThoseThatCannotBeAreIgnored) {
  const Team all = event_team(4);
  const Reported reported = fly_failing(all,
                                        {{at(0.1, RemoveBody{BodyId{3}, Afterwards::land}),
                                          at(0.1, AddCoupling{bad_coupling()}), at(0.1, RemoveTerm{"off2"})}},
                                        fails_with_bad());
  EXPECT_EQ(reported.ignored, std::vector<std::size_t>{1});
  EXPECT_EQ(reported.in_force, (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(reported.team.agents().size(), 3U);
  EXPECT_EQ(couplings_called(reported.team, "off2"), 0);
}

TEST(TeamSwitcher, ARampEndsAlsoWhenAnIgnoredEventOccursAtItsEnd) {
  const Team all = event_team(3);
  for (int k = 18; k < 26; ++k) {
    const Reported reported =
        fly_failing(all, {{at(0.1, RemoveTerm{"off1"}, 0.1), at(0.01 * k, AddCoupling{bad_coupling()})}},
                    fails_with_bad());
    EXPECT_EQ(reported.ignored, std::vector<std::size_t>{1}) << k;
    EXPECT_EQ(reported.team.couplings().size(), all.couplings().size() - 1) << k;
  }
}

TEST(TeamSwitcher, AHundredEventsAtOnceAreAllTold) {
  const Team all = event_team(3);
  Script script;
  for (int i = 0; i < 100; ++i) {
    script.events.push_back(
        {.name = "", .trigger = AtTime{0.1}, .actions = {}, .enter = "stage" + std::to_string(i) + ":in"});
  }
  const Reported reported = fly_failing(all, script, newton_riccati_of(Horizon{}));
  EXPECT_EQ(reported.in_force.size(), 100U);
}

TEST(TeamSwitcher, ASolverOfOnesOwnThatHandsOverItsPlanFliesThroughEvents) {
  const Team all = event_team(4);
  const TeamFlight flight = fly_script(
      all, event_start(all),
      {{at(0.5, RemoveBody{BodyId{3}, Afterwards::hold}),
        at(1.0, RetuneTerm{.name = "sees1", .weight = 0.7}, 0.3), at(1.6, AddBody{BodyId{3}}, 0.3)}},
      2.5, {}, false, {}, gradient_planner_of(Horizon{}));
  EXPECT_TRUE(flight.outcome.finite);
  EXPECT_EQ(period_of(flight, EventKind::event_in_force), 51U);
  EXPECT_EQ(period_of(flight, EventKind::event_ignored), flight.flown.size());
  EXPECT_EQ(flight.flown[51].presence[3], Presence::hold);
  EXPECT_EQ(flight.flown[170].presence[3], Presence::steered);
  EXPECT_LE(largest_jump(flight, 45, flight.flown.size(), 0, 12), 0.3)
      << "those who stay go on with their plan";
  for (const FlownPeriod& period : flight.flown) EXPECT_TRUE(gives_plan(period.solver.status)) << period.time;
}

/// Keeps the plan with which it is asked for its first update.
class WatchedPlanner final : public GradientPlanner {
 public:
  struct Begin {
    Team team;
    std::vector<double> plan;
  };
  WatchedPlanner(Team team, std::vector<Begin>& begins)
      : GradientPlanner(std::move(team), Horizon{}), begins_(begins) {}
  Solution solve(double time, std::span<const double> states) noexcept override {
    if (!begun_) begins_.push_back({ocp().team(), whole_plan()});
    begun_ = true;
    return GradientPlanner::solve(time, states);
  }

 private:
  std::vector<Begin>& begins_;
  bool begun_ = false;
};

TEST(TeamSwitcher, AfterEachChangeThoseWhoStayBeginWithTheirPlanAndOthersAtTheirReference) {
  const Team all = event_team(4);
  std::vector<WatchedPlanner::Begin> begins;
  const TeamFlight flight =
      fly_script(all, event_start(all),
                 {{at(0.5, RemoveBody{BodyId{3}, Afterwards::hold}),
                   at(1.0, RetuneTerm{.name = "sees1", .weight = 0.7}), at(1.5, AddBody{BodyId{3}})}},
                 2.0, {}, false, {},
                 [&](Team team) { return std::make_unique<WatchedPlanner>(std::move(team), begins); });
  ASSERT_EQ(begins.size(), 4U);
  for (std::size_t change = 1; change < begins.size(); ++change) {
    const Team& team = begins[change].team;
    const FlownPeriod& requested = flight.flown[50 * change];
    for (const Agent& agent : team.agents()) {
      const bool is_new = change == 3 && agent.name == "uav3";
      const int in_team = team.input_offset(team.find(agent.name)),
                in_all = all.input_offset(all.find(agent.name));
      for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(begins[change].plan[static_cast<std::size_t>(in_team + i)],
                  is_new ? agent.u_ref[static_cast<std::size_t>(i)]
                         : requested.u[static_cast<std::size_t>(in_all + i)])
            << "change " << change << ", " << agent.name;
      }
    }
  }
}

TEST(TeamSwitcher, ASolverThatCannotHandOverItsPlanIsRefusedWithItsNameAndTheNeed) {
  EXPECT_EQ(refusal_of([] {
              TeamSwitcher(ActiveTeam(event_team(2)), {},
                           [](const Team& team) { return std::make_unique<Cgmres>(team, Horizon{}); });
            }),
            "the solver cgmres cannot hand over its plan, which a team that changes in flight needs, "
            "expected one that "
            "can, such as newton_riccati");
}

TEST(TeamSwitcher, AScriptWithFaultsIsRefusedWithTheEvent) {
  const auto made = [](TeamEvent event) {
    return refusal_of(
        [&] { TeamSwitcher(ActiveTeam(event_team(2)), {{event}}, newton_riccati_of(Horizon{})); });
  };
  EXPECT_THAT(made(at(1.0, AddBody{BodyId{1}})), HasSubstr("event 0: at = 1: \"uav1\" is there already"));
  TeamEvent named = at(-1.0, RemoveTerm{"sees1"});
  named.name = "early";
  EXPECT_THAT(made(named), HasSubstr("event 0 \"early\": at = -1"));
}

}  // namespace
}  // namespace sightline
