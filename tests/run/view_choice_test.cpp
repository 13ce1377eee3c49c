#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/events.hpp"
#include "sightline/potential.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/team_flight.hpp"

namespace sightline {
namespace {

/// Eight robots on circles of their own, two of which know their places; the others look at one of
/// all.
struct ManyViews {
  Team team;
  Script script;
  std::vector<double> x0;

  ManyViews() {
    ViewChoice choice{.name = "who", .dwell = 0.5};
    ViewVariance variance{.step = 1.0};
    for (int i = 0; i <= 8; ++i) variance.values.push_back(0.02 * i * i);
    for (int i = 0; i < 8; ++i) {
      const int row = i / 3;
      const Circle circle{.centre = {1.8 * (i % 3) - 1.8, 1.8 * row - 1.8, 1.0 + 0.1 * i},
                          .radius = 0.6 + 0.1 * i,
                          .rate = (i % 2 == 0 ? 0.5 : -0.4)};
      const AgentId robot =
          team.add(Multirotor{},
                   {.Q = {1.5, 1.5, 1.6, i < 2 ? 1.0 : 0.0, i < 2 ? 1.0 : 0.0, 0.1, 0.1}, .x_ref = circle});
      const Vec3<double> p = circle.centre + Vec3<double>{circle.radius, 0, 0};
      x0.insert(x0.end(), {p.x, p.y, p.z, 1.0, 0.0, 0.0, 0.0});
      choice.targets.push_back(robot);
      if (i >= 2) choice.observers.push_back(robot);
    }
    choice.variances.assign(48, variance);
    const std::vector<double> u(static_cast<std::size_t>(team.nu()));
    choice.first = ViewChooser::first(choice, team, {.t = 0.0, .x = x0, .u = u, .ages = {}, .presence = {}});
    best(
        team, script,
        [](Between) { return std::vector<Weighted>{1.0 * Bearing{.alpha = 0.5, .width = 0.1, .tilt = 0.2}}; },
        choice, 1.0);
  }
};

/// Greatest change of an input from one period to the next, in [from, until) s.
double greatest_step(const TeamFlight& flight, double from, double until) {
  double step = 0.0;
  for (std::size_t k = 1; k < flight.flown.size(); ++k) {
    if (flight.flown[k].time < from || flight.flown[k].time >= until) continue;
    for (std::size_t i = 0; i < flight.flown[k].u.size(); ++i)
      step = std::max(step, std::abs(flight.flown[k].u[i] - flight.flown[k - 1].u[i]));
  }
  return step;
}

TEST(ViewChoice, RobotsTurnToOthersInFlightWithoutAStepOfTheirInputs) {
  const ManyViews many;
  const TeamFlight flight = fly_script(many.team, many.x0, many.script, 20.0);
  std::vector<double> turned;
  std::vector<double> last(8, -1e9);
  for (const FlownPeriod& period : flight.flown) {
    for (const Event& event : period.events) {
      EXPECT_NE(event.kind, EventKind::event_ignored);
      if (event.kind != EventKind::event_in_force) continue;
      turned.push_back(period.time);
      const auto number = static_cast<std::size_t>(event.value);
      const auto& of = std::get<HandOver>(many.script.events[number].actions[0]);
      const auto robot = static_cast<std::size_t>(of.observer.index);
      EXPECT_GE(period.time - last[robot], 0.5 - 1e-9) << "within its dwell";
      last[robot] = period.time;
    }
  }
  EXPECT_GE(turned.size(), 6U);
  double at_turns = 0.0;
  for (const double t : turned)
    if (t > 1.0) at_turns = std::max(at_turns, greatest_step(flight, t - 1e-9, t + 0.03));
  // A new potential at full weight moves them by up to 1 at once.
  EXPECT_LE(at_turns, 0.3);
  EXPECT_LE(greatest_step(flight, 1.0, 20.0), 0.3);
}

TEST(ViewChoice, RobotsThatComeAndGoAreLeftAndTakenUpAgain) {
  ManyViews many;
  const auto at_time = [&](double t, Action action) {
    many.script.events.push_back({.name = "", .trigger = AtTime{t}, .actions = {std::move(action)}});
  };
  at_time(2.0, RemoveBody{BodyId{0}});
  at_time(3.0, RemoveBody{BodyId{5}});
  at_time(5.0, AddBody{BodyId{5}});
  at_time(6.0, RemoveBody{BodyId{3}, Afterwards::hold});
  const TeamFlight flight = fly_script(many.team, many.x0, many.script, 8.0);
  EXPECT_NEAR(flight.flown.back().time, 7.99, 1e-6);
  std::array<int, 8> target{};
  for (std::size_t i = 0; i < 6; ++i) target[i + 2] = many.script.choices[0].first[i];
  for (const FlownPeriod& period : flight.flown) {
    for (const Event& event : period.events) {
      EXPECT_NE(event.kind, EventKind::event_ignored) << period.time;
      if (event.kind != EventKind::event_in_force) continue;
      const auto* turn =
          std::get_if<HandOver>(&many.script.events[static_cast<std::size_t>(event.value)].actions[0]);
      if (turn != nullptr && !turn->couplings.empty())
        target[static_cast<std::size_t>(turn->observer.index)] = turn->couplings[0].between.second.index;
    }
    // Within its dwell and a period nobody looks at who has left.
    if (period.time > 2.7) {
      EXPECT_EQ(std::count(target.begin() + 2, target.end(), 0), 0) << period.time;
    }
  }
}

TEST(ViewChoice, TheSameFlightTwiceIsTheSameToTheBit) {
  const ManyViews many;
  const TeamFlight a = fly_script(many.team, many.x0, many.script, 3.0),
                   b = fly_script(many.team, many.x0, many.script, 3.0);
  ASSERT_EQ(a.flown.size(), b.flown.size());
  EXPECT_EQ(a.flown.back().x, b.flown.back().x);
  EXPECT_EQ(a.flown.back().u, b.flown.back().u);
}

}  // namespace
}  // namespace sightline
