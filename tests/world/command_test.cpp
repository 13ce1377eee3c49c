#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <type_traits>
#include <vector>

#include "sightline/model.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

using Numbers = std::vector<double>;

constexpr double control_period = 0.01;

// A robot whose inputs change slowly, one whose inputs may jump, and a body that is no robot.
Team slow_and_quick() {
  Team team;
  team.add(Multirotor{}, {.name = "slow", .rate_max = {0.5, 0.5, 0.5, 0.5}});
  team.add(Obstacle{.name = "wall"});
  team.add(Multirotor{}, {.u_ref = {0.3, 0, 0, 0}, .u_min = {0.1, -1, -1, -1}, .name = "quick"});
  return team;
}

std::vector<InputLimits> both(double most) { return {2, InputLimits(Numbers(4, -most), Numbers(4, most))}; }

static_assert(!std::is_constructible_v<Command, std::span<const double>>, "only a gate makes commands");
static_assert(!std::is_default_constructible_v<Command>, "only a gate makes commands");
static_assert(!std::is_copy_constructible_v<CommandGate>, "a gate points into itself");

TEST(CommandGate, EachCommandIsFiniteAndWithinTheLimitsWhateverIsAsked) {
  CommandGate gate(slow_and_quick(), control_period);
  std::mt19937_64 random(1);
  const Numbers wild = {0.0, -0.0, 0.5, -3.0, 1e300, -infinity, infinity, std::nan(""), 5e-324};
  const auto any = [&] { return wild[random() % wild.size()]; };
  for (int k = 0; k < 20000; ++k) {
    const double most = 0.05 * static_cast<double>(1 + random() % 20);
    const std::vector<InputLimits> limits = both(most);
    gate.set_limits(limits);
    gate.open(control_period * k);
    Numbers u(8), added(8);
    for (double& v : u) v = any();
    for (double& v : added) v = k % 2 == 0 ? 0.0 : any();
    if (k % 3 == 0) gate.keep_limits_and_rates(u, added);
    const Command command = gate.pass(u, added);
    ASSERT_EQ(command.size(), 8U);
    for (const double v : command) ASSERT_LE(std::abs(v), most);
  }
}

TEST(CommandGate, WhatIsGoodPassesBitForBit) {
  CommandGate gate(slow_and_quick(), control_period);
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> within(0.1, 1.0);
  for (int k = 0; k < 1000; ++k) {
    Numbers u(8);
    for (double& v : u) v = within(random);
    u[1] = -0.0, u[4] = 1.0, u[5] = -1.0;
    gate.open(control_period * k);
    const Command command = gate.pass(u, {});
    for (std::size_t i = 0; i < u.size(); ++i) {
      ASSERT_EQ(command[i], u[i]);
      ASSERT_EQ(std::signbit(command[i]), std::signbit(u[i]));
    }
    ASSERT_TRUE(gate.replaced().empty());
  }
}

TEST(CommandGate, ARobotWhoseInputIsNotFiniteHoldsItsLastCommandAndIsReported) {
  CommandGate gate(slow_and_quick(), control_period);
  (void)gate.pass(Numbers{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8}, {});
  const Command command = gate.pass(Numbers{0, 0, 0, 0, 0.9, std::nan(""), 0.9, 0.9}, {});
  EXPECT_EQ(Numbers(command.begin(), command.end()), (Numbers{0, 0, 0, 0, 0.5, 0.6, 0.7, 0.8}));
  ASSERT_EQ(gate.replaced().size(), 1U);
  EXPECT_EQ(gate.replaced()[0], BodyId{2});
  // As little does a sum that is not finite pass; limits that narrowed meanwhile hold for what goes
  // on.
  const std::vector<InputLimits> narrow = both(0.55);
  gate.set_limits(narrow);
  gate.open(control_period);
  const Command later = gate.pass(Numbers(8, 0.0), Numbers{0, 0, 0, 0, 0, 0, 0, infinity});
  EXPECT_EQ(Numbers(later.begin() + 4, later.end()), (Numbers{0.5, 0.55, 0.55, 0.55}));
}

TEST(CommandGate, ANumberBeyondItsLimitIsReplacedByTheLimitButNotReportedForARoundingError) {
  CommandGate gate(slow_and_quick(), control_period);
  EXPECT_EQ(gate.pass(Numbers{1 + 1e-12, 0, 0, 0, 0.1, 0, 0, 0}, {})[0], 1.0);
  EXPECT_TRUE(gate.replaced().empty());
  EXPECT_EQ(gate.pass(Numbers{1.001, 0, 0, 0, 0.1, 0, 0, 0}, {})[0], 1.0);
  ASSERT_EQ(gate.replaced().size(), 1U);
  EXPECT_EQ(gate.replaced()[0], BodyId{0});
  EXPECT_EQ(gate.pass(Numbers{0, 0, 0, 0, 0.1, 0, -1.001, 0}, {})[6], -1.0);
  ASSERT_EQ(gate.replaced().size(), 1U) << "those of this pass alone";
  EXPECT_EQ(gate.replaced()[0], BodyId{2});
}

TEST(CommandGate, LimitsComeBeforeRatesAndRatesHoldAsFarAsLimitsLeaveRoom) {
  CommandGate gate(slow_and_quick(), control_period);
  std::vector<InputLimits> limits = both(1.0);
  const auto fly = [&](double requested, double added) {
    gate.set_limits(limits);
    gate.open(0.0);
    Numbers u(8, requested);
    const Numbers sum(8, added);
    gate.keep_limits_and_rates(u, sum);
    (void)gate.pass(u, sum);
    EXPECT_TRUE(gate.replaced().empty());
    EXPECT_NEAR(gate.applied()[4],
                std::clamp(requested + added, -limits[1].u_max()[0][0], limits[1].u_max()[0][0]), 1e-15)
        << "no rate";
    return gate.applied()[0];
  };
  double before = 0.0;
  for (int k = 0; k < 100; ++k) {
    const double now = fly(2.0, k < 50 ? 0.0 : 0.3);
    ASSERT_NEAR(now, before + 0.005, 1e-12);
    before = now;
  }
  limits = both(0.2);
  EXPECT_EQ(fly(2.0, 0.0), 0.2) << "followed at once";
  limits = both(1.0);
  EXPECT_NEAR(fly(2.0, 0.1), 0.205, 1e-12) << "from there the rate holds again";
}

TEST(CommandGate, LimitsThatRiseOrFallPastAnInputCarryItAlongWhateverIsAsked) {
  for (const double side : {1.0, -1.0}) {
    CommandGate gate(slow_and_quick(), control_period);
    const std::vector<InputLimits> limits(2, side > 0 ? InputLimits(Numbers(4, 0.5), Numbers(4, 1.0))
                                                      : InputLimits(Numbers(4, -1.0), Numbers(4, -0.5)));
    gate.set_limits(limits);
    gate.open(0.0);
    Numbers u(8, -2.0 * side);
    gate.keep_limits_and_rates(u, {});
    EXPECT_EQ(u, Numbers(8, 0.5 * side));
  }
}

TEST(CommandGate, EachRobotHasItsOwnLimitsAtTheTimeOfThePeriod) {
  CommandGate gate(slow_and_quick(), control_period);
  const std::vector<InputLimits> limits = {
      InputLimits({0.0, 1.0}, {Numbers(4, -0.5), Numbers(4, -0.25)}, {Numbers(4, 0.5), Numbers(4, 0.25)}),
      InputLimits(Numbers(4, -0.75), Numbers(4, 0.125))};
  gate.set_limits(limits);
  gate.open(0.5);
  EXPECT_EQ(gate.pass(Numbers(8, 1.0), {})[0], 0.5);
  EXPECT_EQ(gate.applied()[4], 0.125);
  gate.open(1.0);
  EXPECT_EQ(gate.pass(Numbers(8, -1.0), {})[0], -0.25);
  EXPECT_EQ(gate.applied()[4], -0.75);
}

TEST(CommandGate, ARobotRestsWithinItsLimitsOfThatTime) {
  CommandGate gate(slow_and_quick(), control_period);
  const InputLimits narrows({0.0, 1.0}, {Numbers(4, -1.0), Numbers(4, -1.0)},
                            {Numbers(4, 1.0), Numbers(4, 0.25)});
  const std::vector<InputLimits> limits = {narrows, narrows};
  gate.set_limits(limits);
  Numbers u(8, 0.7);
  gate.rest(BodyId{2}, 0.5, u);
  EXPECT_EQ(u, (Numbers{0.7, 0.7, 0.7, 0.7, 0.3, 0, 0, 0}));
  gate.rest(BodyId{2}, 1.0, u);
  EXPECT_EQ(u[4], 0.25);
  gate.rest(BodyId{1}, 1.0, u);
  EXPECT_EQ(u, (Numbers{0.7, 0.7, 0.7, 0.7, 0.25, 0, 0, 0})) << "a wall has no inputs";
}

TEST(CommandGate, BeforeAnyCommandRobotsHaveTheirOwnInputsWithinTheirLimits) {
  Team team;
  team.add(Multirotor{}, {.u_ref = {0.5, -0.5, 0, 0}, .u_max = {0.25, 1, 1, 1}, .name = "a"});
  CommandGate gate(team, control_period);
  EXPECT_EQ(Numbers(gate.applied().begin(), gate.applied().end()), (Numbers{0.25, -0.5, 0, 0}));
}

}  // namespace
}  // namespace sightline
