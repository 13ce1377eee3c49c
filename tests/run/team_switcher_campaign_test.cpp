/// The bumpless law: any sequence of events on any team leaves a flight that is finite, within its
/// limits, and the same each time.
#include <gtest/gtest.h>
#include <malloc.h>

#include "tests/support/campaign.hpp"
#include "tests/support/event_team.hpp"
#include "tests/support/random.hpp"
#include "tests/support/team_flight.hpp"

namespace sightline {
namespace {

struct Sequence {
  Team all;
  std::vector<double> x0;
  std::vector<Presence> presence;
  Script script;
  std::vector<TimedSignal> signals;
};

Action random_action(Random& random, int robots) {
  const BodyId body{static_cast<int>(random() % static_cast<unsigned>(robots))};
  const BodyId other{static_cast<int>(random() % static_cast<unsigned>(robots))};
  const std::string number = std::to_string(body.index);
  switch (random() % 9) {
    case 0:
    case 1:
      return RemoveBody{body, static_cast<Afterwards>(random() % 3)};
    case 2:
    case 3:
      return AddBody{body};
    case 4:
      return RetuneTerm{.name = "sees" + number, .weight = uniform(random, 0.0, 1.0)};
    case 5:
      return RetuneTerm{.name = "off" + number,
                        .potential = Potential(KeepOut{.d_min = uniform(random, 0.6, 1.2)})};
    case 6:
      return SetReference{AgentId{body},
                          Circle{.centre = random_point(random, 2.0), .radius = 0.3, .rate = 0.3}};
    case 7:
      return RetuneAgent{.agent = AgentId{body}, .R = std::vector<double>(4, uniform(random, 0.5, 2.0))};
    default:
      return Observe{AgentId{body}, other};
  }
}

Trigger random_trigger(Random& random, int robots, double duration) {
  const BodyId a{static_cast<int>(random() % static_cast<unsigned>(robots))}, b{(a.index + 1) % robots};
  switch (random() % 4) {
    case 0:
      return Signal{random() % 2 == 0 ? "red" : "green"};
    case 1:
      return Condition{DistanceOf{a, b}, Condition::Side::above, uniform(random, 0.5, 2.0), 0.05,
                       uniform(random, 0.0, 0.2)};
    default:
      return AtTime{0.01 * static_cast<double>(random() % static_cast<unsigned>(100 * duration))};
  }
}

Sequence random_sequence(Random& random, double duration) {
  Sequence s;
  const int robots = 2 + static_cast<int>(random() % 15), leaders = 1 + static_cast<int>(random() % 2);
  s.all = event_team(robots, std::min(leaders, robots - 1));
  s.x0 = event_start(s.all, std::min(leaders, robots - 1));
  for (double& x : s.x0) x += uniform(random, -0.05, 0.05);
  s.presence.assign(static_cast<std::size_t>(robots), Presence::steered);
  for (int i = 1; i < robots; ++i) {
    if (random() % 5 == 0) s.presence[static_cast<std::size_t>(i)] = Presence::absent;
  }
  for (std::uint64_t n = 1 + random() % 8; n > 0; --n) {
    TeamEvent event{.name = "", .trigger = random_trigger(random, robots, duration)};
    event.actions.push_back(random_action(random, robots));
    if (random() % 3 == 0) event.actions.push_back(random_action(random, robots));
    if (random() % 2 == 0) event.ramp = uniform(random, 0.0, 1.0);
    Script longer = s.script;
    longer.events.push_back(event);
    if (faults_of(longer, ActiveTeam(s.all, s.presence)).empty()) s.script = longer;
  }
  s.signals = {{uniform(random, 0.0, duration), "red"}, {uniform(random, 0.0, duration), "green"}};
  return s;
}

TEST(TeamSwitcherCampaign, AnySequenceOfEventsIsFlownWithinAllLimitsAndTheSameEachTime) {
  constexpr double duration = 1.5;
  const int sequences = whole_campaign() ? 500 : 20;
  Random random(2026);
  int in_force = 0, ignored = 0;
  for (int k = 0; k < sequences; ++k) {
    const Sequence s = random_sequence(random, duration);
    const TeamFlight a = fly_script(s.all, s.x0, s.script, duration, s.presence, false, s.signals);
    const TeamFlight b = fly_script(s.all, s.x0, s.script, duration, s.presence, false, s.signals);
    ASSERT_TRUE(a.outcome.finite) << k;
    ASSERT_EQ(a.outcome.refused, 0) << k;
    ASSERT_EQ(a.flown.size(), b.flown.size());
    for (std::size_t i = 0; i < a.flown.size(); ++i) {
      ASSERT_EQ(a.flown[i].x, b.flown[i].x) << k;
      ASSERT_EQ(a.flown[i].u, b.flown[i].u) << k;
      ASSERT_EQ(a.flown[i].presence, b.flown[i].presence) << k;
      for (const double u : a.flown[i].u) ASSERT_LE(std::abs(u), 1.0) << k;
      for (const double x : a.flown[i].x) ASSERT_TRUE(std::isfinite(x)) << k;
      ASSERT_NE(a.flown[i].solver.status, Status::not_finite) << k;
      for (const Event& event : a.flown[i].events) {
        in_force += event.kind == EventKind::event_in_force;
        ignored += event.kind == EventKind::event_ignored;
      }
    }
  }
  RecordProperty("in_force", in_force);
  RecordProperty("ignored", ignored);
  EXPECT_GT(in_force, 2 * sequences);
  EXPECT_GT(ignored, 0);
}

TEST(TeamSwitcherCampaign, TeamsThatFollowOneAnotherDoNotHoardMemory) {
  const Team all = event_team(6, 2);
  TeamEvent go{.name = "",
               .trigger = AfterTime{0.05},
               .actions = {Observe{AgentId{BodyId{2}}, BodyId{0}}},
               .stage = "start",
               .enter = "there",
               .ramp = 0.02};
  TeamEvent back{.name = "",
                 .trigger = AfterTime{0.05},
                 .actions = {Observe{AgentId{BodyId{2}}, BodyId{1}}},
                 .stage = "there",
                 .enter = "start",
                 .ramp = 0.02};
  const auto memory_after = [&](double duration) {
    const std::size_t before = mallinfo2().uordblks;
    std::size_t most = 0;
    const Horizon horizon;
    TeamSwitcher team_switcher(ActiveTeam(all), {{go, back}}, newton_riccati_of(horizon));
    ModelWorld world(all, event_start(all, 2));
    SimulatedClock clock;
    const Controllers controllers = {*team_switcher.present().solver};
    SpscQueue<Sample> sink(static_cast<std::size_t>(duration / horizon.dt) + 8,
                           sized_sample(all, controllers, &team_switcher));
    most = mallinfo2().uordblks - before;
    Loop loop(world, controllers, clock, sink,
              {.duration = duration, .path_interval = 0.0, .team_switcher = &team_switcher});
    (void)loop.run();
    return static_cast<double>(mallinfo2().uordblks - before) - static_cast<double>(most);
  };
  const double once = memory_after(1.0), often = memory_after(whole_campaign() ? 60.0 : 6.0);
  EXPECT_LT(std::abs(often - once), 200e3) << "of " << once << " bytes";
}

}  // namespace
}  // namespace sightline
