#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/error.hpp"
#include "tests/support/period.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/two_robots.hpp"

namespace sightline {
namespace {

using test::control_period;
using test::two_robots;
using Numbers = std::vector<double>;

// A team of both robot models and an obstacle, so that offsets matter.
Team both_models() {
  Team team;
  team.add(AngleMultirotor{});
  team.add(Obstacle{.name = "wall"});
  team.add(Multirotor{});
  return team;
}
const Numbers mixed_start = {0,    0,   1,        3.0, 0.2, -0.1, /**/ 3, 2,   1, 0.3,
                             -0.2, 0.1, /**/ 1.5, 0,   1.2, 0.6,  0.8,    0.1, 0};

// Random commands that hold for 0.2 s.
Numbers command(int k, std::size_t nu) {
  std::mt19937_64 random(static_cast<unsigned>(k / 20));
  std::uniform_real_distribution<double> within(-1, 1);
  Numbers u(nu);
  for (double& v : u) v = within(random);
  return u;
}

Numbers fly(const Team& team, const Numbers& x0, const PlantOptions& options, int steps) {
  Plant plant(team, x0, options);
  Numbers trajectory;
  for (int k = 0; k < steps; ++k) {
    plant.step(command(k, static_cast<std::size_t>(team.nu())), control_period);
    trajectory.insert(trajectory.end(), plant.x().begin(), plant.x().end());
  }
  return trajectory;
}

const Numbers apart = {-0.6, -0.3, 0.6, 1, 0, 0, 0, /**/ 0.9, -0.3, 0.6, 1, 0, 0, 0};

TEST(Plant, UndisturbedIsOneRungeKuttaStepOfEachModelBitForBit) {
  const Team team = both_models();
  Plant plant(team, mixed_start);
  Numbers x = mixed_start, scratch(5 * 7);
  for (int i = 0; i < team.bodies(); ++i)
    ASSERT_TRUE(team.model(BodyId{i}).normalise(&x[0] + team.state_offset({i})));
  for (int k = 0; k < 500; ++k) {
    const Numbers u = command(k, 8);
    ASSERT_TRUE(plant.step(u, control_period));
    for (int i = 0; i < team.bodies(); ++i) {
      const Model& model = team.model(BodyId{i});
      double* const part = &x[0] + team.state_offset(BodyId{i});
      const double* const input = u.data() + team.input_offset(BodyId{i});
      const auto f = [&](std::span<const double> at, std::span<double> rate) {
        model.f(at.data(), input, rate.data());
      };
      rk4_step(f, {part, static_cast<std::size_t>(model.nx())}, control_period, {scratch});
      ASSERT_TRUE(model.normalise(part));
    }
    ASSERT_EQ(Numbers(plant.x().begin(), plant.x().end()), x) << "after step " << k;
  }
}

TEST(Plant, ConvergesWithTheFourthOrderOfTheStep) {
  const Numbers u = {0.7, -0.4, 0.3, 0.9, -0.5, 0.6, 0.1, -0.8};
  const auto after_one_second = [&](int steps) {
    Plant plant(two_robots(), apart);
    for (int k = 0; k < steps; ++k) plant.step(u, 1.0 / steps);
    return Numbers(plant.x().begin(), plant.x().end());
  };
  const Numbers exact = after_one_second(2000);
  double previous = largest_difference(after_one_second(5), exact);
  for (const int steps : {10, 20, 40}) {
    const double error = largest_difference(after_one_second(steps), exact);
    EXPECT_NEAR(std::log2(previous / error), 4.0, 0.4) << steps << " steps";
    previous = error;
  }
}

TEST(Plant, APeriodLongerThanALagOfTheModelIsIntegratedInParts) {
  Team team;
  team.add(LaggingHoverMultirotor{.tau = 0.05, .tau_z = 0.03, .tau_psi = 0.02});
  Numbers start(static_cast<std::size_t>(team.nx()));
  team.model(BodyId{0}).at_rest({{0, 0, 1}, {1, 0}}, start.data());
  for (const double period : {0.05, 0.1, 0.2, 0.35, 0.5}) {
    Plant whole(team, start), fine(team, start);
    const int parts = static_cast<int>(std::lround(period / 0.001));
    for (int k = 0; k < 40; ++k) {
      const Numbers u = command(20 * k, 4);
      ASSERT_TRUE(whole.step(u, period)) << period;
      for (int part = 0; part < parts; ++part) ASSERT_TRUE(fine.step(u, 0.001));
      ASSERT_LT(largest_difference(whole.x(), fine.x()), 0.01 * (1 + k * period))
          << period << " s, step " << k;
    }
  }
}

TEST(Plant, HeadingsStayOnTheCircleUnderAnyDisturbance) {
  const PlantOptions options{.seed = 3,
                             .disturbances = {.wind = {0.1, 0.2, 0},
                                              .gust_sigma = 0.5,
                                              .airflow = {.amplitude = 0.5},
                                              .input_delay = 0.055,
                                              .yaw_lag = 0.2}};
  Plant plant(both_models(), mixed_start, options);
  for (int k = 0; k < 2000; ++k) {
    ASSERT_TRUE(plant.step(command(k, 8), control_period));
    ASSERT_NEAR(std::hypot(plant.x()[15], plant.x()[16]), 1.0, 1e-15);
    ASSERT_LE(std::abs(plant.x()[3]), std::numbers::pi);
  }
}

TEST(Plant, TheSameSeedFliesTheSameAndAnotherDoesNot) {
  PlantOptions options{.seed = 1, .disturbances = {.gust_sigma = 0.2, .airflow = {.amplitude = 0.15}}};
  const Numbers first = fly(two_robots(), apart, options, 300);
  EXPECT_EQ(fly(two_robots(), apart, options, 300), first);
  options.seed = 2;
  EXPECT_GT(largest_difference(fly(two_robots(), apart, options, 300), first), 1e-3);
}

TEST(Plant, ManyBodiesMoveTheSameWhateverTheThreads) {
  Team team;
  Numbers x0;
  for (int i = 0; i < PlantOptions::shared_from; i += 3) {
    const std::string number = std::to_string(i);
    team.add(AngleMultirotor{}, {.name = "angle" + number});
    team.add(Obstacle{.name = "wall" + number});
    team.add(Multirotor{}, {.name = "uav" + number});
    x0.insert(x0.end(), mixed_start.begin(), mixed_start.end());
  }
  std::vector<Presence> presence(static_cast<std::size_t>(team.bodies()), Presence::steered);
  for (std::size_t i = 0; i < presence.size(); i += 7) presence[i] = Presence::absent;
  const auto flown = [&](int threads) {
    PlantOptions options{
        .seed = 3,
        .disturbances = {.wind = {0.1, 0.2, 0}, .gust_sigma = 0.5, .input_delay = 0.055, .yaw_lag = 0.2},
        .pool = threads > 1 ? std::make_shared<ThreadPool>(threads) : nullptr};
    Plant plant(team, x0, options);
    for (int k = 0; k < 50; ++k) {
      if (k == 20) plant.set_presence(presence);
      EXPECT_TRUE(plant.step(command(k, size(team.nu())), control_period));
    }
    return Numbers(plant.x().begin(), plant.x().end());
  };
  const Numbers alone = flown(1);
  for (const int threads : {2, 5}) EXPECT_EQ(flown(threads), alone) << threads << " threads";
}

TEST(Plant, OneDisturbanceMoreLeavesTheOthersNumbersAsTheyWere) {
  // A wake too weak to move a bit still draws from its stream.
  PlantOptions options{.disturbances = {.gust_sigma = 0.2}};
  const Numbers gusts_alone = fly(two_robots(), apart, options, 300);
  options.disturbances.airflow.amplitude = 1e-300;
  EXPECT_EQ(fly(two_robots(), apart, options, 300), gusts_alone);
}

TEST(Plant, ASteadyWindBlowsTheRobotToItsTerminalVelocityAndNoObstacle) {
  Plant plant(both_models(), mixed_start, {.disturbances = {.wind = {0.1, 0, 0}}});
  const Numbers still(8, 0.0);
  for (int k = 0; k < 4000; ++k) plant.step(still, control_period);
  const Multirotor robot;
  const auto v = plant.team().model(BodyId{2}).sight(&plant.x()[12], still.data()).v;
  EXPECT_NEAR(v.x, 0.1 / -robot.a_f, 1e-6);
  EXPECT_NEAR(v.y, 0.0, 1e-6);
  EXPECT_DOUBLE_EQ(plant.x()[9], 0.3);
  EXPECT_NEAR(plant.x()[6], 3 + 0.3 * 40, 1e-9);
}

TEST(Plant, AnInputDelayShiftsTheResponseByTheDelayWhereverItFalls) {
  // A velocity under a held input grows linearly at first order; without drag the climb is exact.
  for (const double delay : {0.0, 0.01, 0.06, 0.063, 0.0999, 0.5}) {
    Plant late(two_robots(), apart, {.disturbances = {.input_delay = delay}});
    const Numbers climb = {0, 0, 1, 0, 0, 0, 1, 0};
    for (int k = 0; k < 100; ++k) {
      late.step(climb, control_period);
      const double expected = 0.6 + std::max(0.0, (k + 1) * control_period - delay);
      ASSERT_NEAR(late.x()[2], expected, 1e-12) << "delay " << delay << ", step " << k;
    }
  }
}

TEST(Plant, ALaggingYawCommandApproachesExponentially) {
  const Multirotor robot;
  for (const double lag : {0.2, 0.004}) {
    Team team;
    team.add(AngleMultirotor{});
    Plant plant(team, {0, 0, 0, 0, 0, 0}, {.disturbances = {.yaw_lag = lag}});
    const Numbers turn = {0, 0, 0, 0.5};
    for (int k = 1; k <= 150; ++k) {
      plant.step(turn, control_period);
      const double t = k * control_period, psi = robot.b_psi * 0.5 * (t - lag * (1 - std::exp(-t / lag)));
      ASSERT_NEAR(plant.x()[3], psi, 1e-4 * lag) << "lag " << lag << ", t = " << t;
    }
  }
}

TEST(Plant, AYawLagIsThatOfTheInputThatTurnsTheRobotWhateverItIsCalled) {
  const auto turned = [](const std::string& input, double lag) {
    const TextRobot car = {.states = {"p_x", "p_y", "p_z", "psi", "v"},
                           .inputs = {"a", input},
                           .f = {"v * cos(psi)", "v * sin(psi)", "0", input, "a"},
                           .position = {"p_x", "p_y", "p_z"},
                           .heading = {"psi"}};
    Team team;
    const Model model = car.model();
    team.add(Agent{.name = "car",
                   .model = model,
                   .Q = Numbers(5, 0.0),
                   .R = Numbers(2, 1.0),
                   .Q_f = Numbers(5, 0.0),
                   .u_ref = Numbers(2, 0.0),
                   .limits = InputLimits(Numbers(2, -1.0), Numbers(2, 1.0))});
    Plant plant(team, {0, 0, 0, 0, 0}, {.disturbances = {.yaw_lag = lag}});
    for (int k = 0; k < 50; ++k) plant.step(Numbers{0.2, 0.5}, control_period);
    return Numbers(plant.x().begin(), plant.x().end());
  };
  EXPECT_EQ(turned("omega", 0.5), turned("u_psi", 0.5));
  EXPECT_LT(turned("omega", 0.5)[3], 0.6 * turned("omega", 0.0)[3]);
}

TEST(Plant, TheInputGainScalesWhatTheInputsDo) {
  Plant weak(two_robots(), apart, {.disturbances = {.input_gain = 0.8}});
  Plant model(two_robots(), apart);
  Numbers u = {0.5, 0.25, 1, -0.75, 0, 0, 0, 0}, scaled = u;
  for (double& v : scaled) v *= 0.8;
  for (int k = 0; k < 100; ++k) {
    weak.step(u, control_period);
    model.step(scaled, control_period);
  }
  EXPECT_THAT(weak.x(), testing::ElementsAreArray(model.x()));
}

TEST(Plant, WheelsThatSlipLoseTheirPartOfWayAndTurnAndNoVelocity) {
  Team team;
  team.add(OmniRover{});
  team.add(Unicycle{});
  team.add(Multirotor{});
  const Numbers start = {0, 0, 0, 1, 0, 0, 0, /**/ 5, 0, 0, 1, 0, 0, /**/ 9, 0, 1, 1, 0, 0, 0};
  const Numbers u = {0.8, 0, 0, /**/ 0.8, 0, /**/ 0.8, 0, 0, 0};
  Plant gripping(team, start), slipping(team, start, {.disturbances = {.slip = 0.3}});
  for (int k = 0; k < 200; ++k) {
    EXPECT_TRUE(gripping.step(u, 0.01));
    EXPECT_TRUE(slipping.step(u, 0.01));
  }
  const auto a = gripping.x(), b = slipping.x();
  EXPECT_NEAR(b[0], 0.7 * a[0], 1e-12);
  EXPECT_EQ(b[5], a[5]);
  EXPECT_NEAR(b[7] - 5, 0.7 * (a[7] - 5), 1e-12);
  for (std::size_t i = 13; i < 20; ++i) EXPECT_EQ(b[i], a[i]);
  EXPECT_THROW(Plant(team, start, {.disturbances = {.slip = 0.95}}), std::invalid_argument);
}

TEST(Plant, WhatIsAbsentRestsWhereItIsAndDisturbsNobody) {
  const Disturbances wakes{.airflow = {.amplitude = 2.0, .distance = 1.5, .frequency = 0.5}};
  const Numbers near = {0, 0, 1, 1, 0, 0, 0, /**/ 0.5, 0, 1, 1, 0, 0.3, 0};
  Plant alone(two_robots(), near, {.disturbances = wakes});
  const std::vector<Presence> presence = {Presence::steered, Presence::absent};
  alone.set_presence(presence);
  for (int k = 0; k < 100; ++k) {
    Numbers u(8, 0.0);
    u[4] = 1.0;
    ASSERT_TRUE(alone.step(u, control_period));
  }
  for (std::size_t i = 0; i < near.size(); ++i)
    EXPECT_NEAR(alone.x()[i], near[i], 1e-100) << "no wake, no motion";
  alone.set_presence(std::vector<Presence>(2, Presence::steered));
  ASSERT_TRUE(alone.step(Numbers(8, 0.0), control_period));
  EXPECT_NE(alone.x()[7], near[7]);
  EXPECT_NE(alone.x()[0], near[0]);
}

/// Moves one robot a metre along x each time, and writes down what it is told.
class Strides final : public RobotDynamics {
 public:
  explicit Strides(BodyId robot) : robot_(robot) {}
  bool moves(BodyId robot) const noexcept override { return robot == robot_; }
  void begin(BodyId, double t, const double*) noexcept override { begun.push_back(t); }
  void steer(BodyId robot, const double* u, const Vec3<double>& acceleration) noexcept override {
    EXPECT_EQ(robot, robot_);
    ++requested_;
    received.push_back(u[0]);
    pushed.push_back(acceleration.x);
  }
  void move(double t) noexcept override {
    if (requested_ == 0) return;
    EXPECT_EQ(std::exchange(requested_, 0), 1) << "it is told once, then moved";
    until.push_back(t);
  }
  void show(BodyId robot, double* x) const noexcept override {
    EXPECT_EQ(robot, robot_);
    x[0] += 1.0;
  }
  Numbers begun, until, received, pushed;

 private:
  BodyId robot_;
  int requested_ = 0;
};

TEST(Plant, OtherDynamicsMoveTheirRobotWithTheCommandsDelaysAndDisturbancesOfThePlant) {
  Strides strides(BodyId{1});
  Plant plant(
      two_robots(), apart,
      {.disturbances = {.wind = {0.5, 0, 0}, .input_delay = 0.014, .input_gain = 2.0}, .dynamics = &strides});
  Plant models(two_robots(), apart,
               {.disturbances = {.wind = {0.5, 0, 0}, .input_delay = 0.014, .input_gain = 2.0}});
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(plant.step(Numbers(8, 0.1 * (k + 1)), control_period));
    models.step(Numbers(8, 0.1 * (k + 1)), control_period);
  }
  // The first command comes into force at 14 ms, the second at 24 ms.
  EXPECT_EQ(strides.begun, Numbers{0.0});
  EXPECT_THAT(strides.until,
              testing::Pointwise(testing::DoubleNear(1e-12), Numbers{0.01, 0.014, 0.02, 0.024, 0.03}));
  EXPECT_EQ(strides.received, (Numbers{0, 0, 0.2, 0.2, 0.4}));
  EXPECT_EQ(strides.pushed, Numbers(5, 0.5));
  EXPECT_EQ(plant.x()[7], apart[7] + 5.0);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(plant.x()[i], models.x()[i]);
  for (std::size_t i = 8; i < 14; ++i) EXPECT_EQ(plant.x()[i], apart[i]);
}

TEST(Plant, OtherDynamicsBeginAnewWhenTheirRobotJoinsAndAreNotAskedWhileItIsAway) {
  Strides strides(BodyId{1});
  Plant plant(two_robots(), apart, {.dynamics = &strides});
  const auto presence = [&](Presence second) {
    plant.set_presence(std::vector<Presence>{Presence::steered, second});
    ASSERT_TRUE(plant.step(Numbers(8, 0.5), control_period));
  };
  presence(Presence::steered), presence(Presence::absent), presence(Presence::absent);
  EXPECT_EQ(strides.until.size(), 1u);
  EXPECT_EQ(plant.x()[7], apart[7] + 1.0);
  presence(Presence::steered);
  EXPECT_THAT(strides.begun, testing::Pointwise(testing::DoubleNear(1e-12), Numbers{0.0, 0.03}));
  EXPECT_EQ(plant.x()[7], apart[7] + 1.0) << "from the start again";
}

TEST(Plant, AStepThatCannotBeIsToldAndLeavesTheWorldAsItWas) {
  Plant plant(two_robots(), apart);
  for (const double no_time : {0.0, -0.01, not_a_number, infinite, 1e300})
    EXPECT_FALSE(plant.step(Numbers(8, 0.5), no_time)) << no_time;
  for (const std::size_t inputs : {0U, 7U, 9U})
    EXPECT_FALSE(plant.step(Numbers(inputs, 0.5), control_period)) << inputs;
  EXPECT_EQ(Numbers(plant.x().begin(), plant.x().end()), apart);
  EXPECT_EQ(plant.time(), 0.0);
  EXPECT_TRUE(plant.step(Numbers(8, 0.5), control_period));
}

TEST(Plant, RefusesAStartOrADisturbanceThatCannotBe) {
  const auto refusal = [](const Numbers& x0, const PlantOptions& options) {
    return refusal_of([&] { Plant(two_robots(), x0, options); });
  };
  Numbers no_heading = apart, not_finite = apart;
  no_heading[10] = 0.0;
  not_finite[0] = std::nan("");
  EXPECT_EQ(refusal({1, 2, 3}, {}), "the plant's start has 3 numbers, expected 14");
  EXPECT_THAT(refusal(no_heading, {}), testing::HasSubstr("\"b\" is not a state"));
  EXPECT_THAT(refusal(not_finite, {}), testing::HasSubstr("\"a\" is not a state"));
  EXPECT_THAT(refusal(apart, {.disturbances = {.yaw_lag = -1}}),
              testing::HasSubstr("yaw_lag = -1, expected"));
  EXPECT_EQ(refusal(apart, {}), "");
}

}  // namespace
}  // namespace sightline
