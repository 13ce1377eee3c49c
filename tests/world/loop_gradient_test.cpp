// Derivatives of a closed loop's cost against central differences of whole flights.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sightline/worlds.hpp"
#include "tests/support/changed_team.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using Values = std::vector<double>;
constexpr Horizon horizon{.T = 1.0, .N = 10, .dt = 0.05};
constexpr int loop_periods = 40;

/// Cost of a flight: half of the last robot's squared distance from a moving place, a part of the
/// first heading, and of the inputs. Adds its derivatives to by_x and by_u.
double cost_of(const LoopGradient& loop, Values& by_x, Values& by_u) {
  double sum = 0.0;
  for (int k = 0; k <= loop_periods; ++k) {
    const auto x = loop.x(k);
    const std::size_t p = x.size() - 7, first = static_cast<std::size_t>(k) * x.size();
    const Values place = {0.5 * std::cos(0.05 * k), 0.2, 1.0};
    sum += 0.3 * x[4];
    by_x[first + 4] += 0.3;
    for (std::size_t i = 0; i < 3; ++i) {
      const double off = x[p + i] - place[i];
      sum += 0.5 * off * off;
      by_x[first + p + i] += off;
    }
    if (k == loop_periods) break;
    for (std::size_t i = 0; i < loop.u(k).size(); ++i) {
      sum += 0.1 * loop.u(k)[i] * loop.u(k)[i];
      by_u[static_cast<std::size_t>(k) * loop.u(k).size() + i] += 0.2 * loop.u(k)[i];
    }
  }
  return sum;
}

double flown_cost(const Team& team, int delay, const Values& x0) {
  LoopGradient loop(Ocp(team, horizon), delay);
  EXPECT_TRUE(loop.fly(x0, loop_periods));
  Values by_x((loop_periods + 1) * x0.size()), by_u(static_cast<std::size_t>(loop_periods * team.nu()));
  return cost_of(loop, by_x, by_u);
}

void expect_slopes(paper::Variant variant, int delay) {
  const Team team = paper::team(variant);
  const Values x0 = {-0.6, -0.3, 0.6, 1, 0, 0, 0, 0, 0, 0.5, 1, 0, 0, 0};
  LoopGradient loop(Ocp(team, horizon), delay);
  Values by_x((loop_periods + 1) * x0.size()), by_u(static_cast<std::size_t>(loop_periods * team.nu()));
  ASSERT_TRUE(loop.fly(x0, loop_periods));
  EXPECT_GT(cost_of(loop, by_x, by_u), 1.0);
  EXPECT_EQ(loop.differentiate(by_x, by_u), 0);
  const auto difference = [](auto&& f, double step) {
    return (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step);
  };
  const auto expect_near = [](double exact, double measured, const std::string& name) {
    EXPECT_NEAR(exact, measured, 1e-6 * (1.0 + std::fabs(measured))) << name;
  };
  for (std::size_t i = 0; i < x0.size(); ++i) {
    if (i == 3 || i == 10) continue;  // along the heading
    const auto at_change = [&](double by) {
      Values x = x0;
      x[i] += by;
      if (i == 4 || i == 11) x[i - 1] = std::sqrt(1.0 - x[i] * x[i]);
      return flown_cost(team, delay, x);
    };
    expect_near(loop.by_start()[i], difference(at_change, 1e-4), "state " + std::to_string(i));
  }
  int compared = 0;
  for (std::size_t p = 0; p < loop.parameters().size(); p += 3) {
    const std::string& name = loop.parameters()[p].name;
    const double here = loop.parameters()[p].value;
    // The inputs before the first delayed command are constants, although they are u*.
    if (name.find("x_ref") != std::string::npos || (delay > 0 && name.find("u_ref") != std::string::npos))
      continue;
    const double step = 1e-3 * (here != 0 ? std::fabs(here) : 0.1);
    if (here == 0 && name.find("Q") != std::string::npos) continue;  // none below 0
    const auto at_change = [&](double by) { return flown_cost(changed_team(team, name, by), delay, x0); };
    expect_near(loop.by_parameters()[p], difference(at_change, step), name);
    ++compared;
  }
  EXPECT_GE(compared, 8);
}

TEST(LoopGradient, IsTheCentralDifferenceOfFlights) {
  expect_slopes(paper::Variant::joint, 0);
  expect_slopes(paper::Variant::masked, 0);
}

TEST(LoopGradient, CountsTheDelayOfCommands) { expect_slopes(paper::Variant::joint, 2); }

TEST(LoopGradient, FollowsItsOwnFlightToTheSameDerivatives) {
  const Team team = paper::team(paper::Variant::joint);
  const Values x0 = {-0.6, -0.3, 0.6, 1, 0, 0, 0, 0, 0, 0.5, 1, 0, 0, 0};
  LoopGradient own(Ocp(team, horizon)), following(Ocp(team, horizon));
  ASSERT_TRUE(own.fly(x0, loop_periods));
  Values states, by_x((loop_periods + 1) * x0.size()),
      by_u(static_cast<std::size_t>(loop_periods * team.nu()));
  for (int k = 0; k <= loop_periods; ++k) states.insert(states.end(), own.x(k).begin(), own.x(k).end());
  following.follow(states);
  cost_of(own, by_x, by_u);
  EXPECT_EQ(own.differentiate(by_x, by_u), 0);
  EXPECT_EQ(following.differentiate(by_x, by_u), 0);
  for (std::size_t p = 0; p < own.by_parameters().size(); ++p)
    EXPECT_EQ(own.by_parameters()[p], following.by_parameters()[p]) << own.parameters()[p].name;
}

TEST(LoopGradient, HoldsTheDisturbancesOfAFlightThatItFollows) {
  const Values x0 = {-0.6, -0.3, 0.6, 1, 0, 0, 0, 0, 0, 0.5, 1, 0, 0, 0};
  constexpr const char* name = "couple[0].weight";
  const auto follow = [&](const Team& team, LoopGradient& loop) {
    NewtonRiccatiOptions options;
    options.max_newton_steps = 30, options.start_steps = 100, options.tolerance = 1e-9;
    NewtonRiccati solver(Ocp(team, horizon), options);
    Plant plant(team, x0, {.disturbances = {.wind = {-0.3, 0.1, 0.0}}});
    Values states = x0;
    for (int k = 0; k < loop_periods; ++k) {
      EXPECT_TRUE(plant.step(solver.solve(k * horizon.dt, plant.x()).u, horizon.dt));
      states.insert(states.end(), plant.x().begin(), plant.x().end());
    }
    loop.follow(states);
  };
  const auto cost_at = [&](double by) {
    const Team team = changed_team(paper::team(paper::Variant::joint), name, by);
    LoopGradient loop{Ocp(team, horizon)};
    follow(team, loop);
    Values by_x((loop_periods + 1) * x0.size()), by_u(static_cast<std::size_t>(loop_periods * team.nu()));
    return cost_of(loop, by_x, by_u);
  };
  const Team team = paper::team(paper::Variant::joint);
  LoopGradient loop{Ocp(team, horizon)};
  follow(team, loop);
  Values by_x((loop_periods + 1) * x0.size()), by_u(static_cast<std::size_t>(loop_periods * team.nu()));
  cost_of(loop, by_x, by_u);
  EXPECT_EQ(loop.differentiate(by_x, by_u), 0);
  const double measured = (cost_at(1e-3) - cost_at(-1e-3)) / 2e-3;
  for (std::size_t p = 0; p < loop.parameters().size(); ++p)
    if (loop.parameters()[p].name == name) {
      EXPECT_NEAR(loop.by_parameters()[p], measured, 0.02 * std::fabs(measured));
    }
}

TEST(LoopGradient, RefusesAPartOfAState) {
  LoopGradient loop(Ocp(paper::team(paper::Variant::joint), horizon));
  EXPECT_EQ(refusal_of([&] { loop.follow(Values(15)); }),
            "follow: x has 15 numbers, expected at least two states of 14");
}

}  // namespace
}  // namespace sightline
