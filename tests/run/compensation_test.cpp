#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sightline/loop.hpp"
#include "sightline/robots.hpp"
#include "sightline/solvers.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/error.hpp"
#include "tests/support/period.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/sample_sink.hpp"
#include "tests/support/valid.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;
using Numbers = std::vector<double>;
using test::control_period;
constexpr double half_period = 0.005;

// A robot of each kind alone in the world, and what its inputs reach.
struct Alone {
  template <RobotModel M>
  explicit Alone(const M& robot) {
    const Model model(robot);
    team.add(robot);
    start.resize(static_cast<std::size_t>(model.nx()));
    model.at_rest({{0.3, -0.2, 1.0}, {0.6, 0.8}}, start.data());
    most.assign(model.u_max().begin(), model.u_max().end());
  }

  Team team;
  Numbers start, most;
};

std::vector<Alone> all_kinds() {
  return {Alone(Multirotor{}), Alone(AngleMultirotor{}), Alone(VelocityMultirotor{}),
          Alone(OmniRover{}),  Alone(Unicycle{}),        Alone(PointMass{})};
}

// Random commands within half of the limits, each for 0.2 s.
class Wandering {
 public:
  explicit Wandering(Numbers most) : most_(std::move(most)), u_(most_.size()) {}
  const Numbers& operator()(int k) {
    for (std::size_t i = 0; k % 20 == 0 && i < u_.size(); ++i)
      u_[i] = std::uniform_real_distribution<double>(-0.5, 0.5)(random_) * most_[i];
    return u_;
  }

 private:
  std::mt19937_64 random_{7};
  Numbers most_, u_;
};

// What follows the robot's commands before the solver: measured now, and where the plant is.
struct Watched {
  Watched(const Alone& of, const RobotCompensation& how, const Disturbances& disturbances)
      : team(of.team),
        compensation(of.team, {how}, control_period),
        plant(of.team, of.start, {.disturbances = disturbances, .period = half_period}),
        command(of.most) {}

  void step() {
    const double t = control_period * k;
    const ValidStates seen = test::valid(team, plant.x(), t);
    compensation.look(BodyId{0}, seen);
    const auto now = compensation.ahead(t, seen);
    met.emplace_back(now.begin(), now.end());
    const Numbers& u = command(k++);
    compensation.record(t, u);
    for (int half = 0; half < 2; ++half) {
      states.emplace_back(plant.x().begin(), plant.x().end());
      EXPECT_TRUE(plant.step(u, half_period));
    }
  }

  Team team;
  Compensation compensation;
  Plant plant;
  Wandering command;
  std::vector<Numbers> met, states;  // of each period, of each half of one
  int k = 0;
};

TEST(Compensation, OfAKnownDelayGivesTheStateThatTheCommandWillMeet) {
  for (const Alone& alone : all_kinds()) {
    for (const double delay : {0.0, 0.07, 0.155, 0.4}) {
      SCOPED_TRACE(fmt::format("{} after {} s", alone.team.model(BodyId{0}).name(), delay));
      Watched watched(alone, {BodyId{0}, delay}, {.input_delay = delay});
      EXPECT_EQ(watched.compensation.lead(), delay);
      for (int k = 0; k < 300; ++k) watched.step();
      const auto later = static_cast<std::size_t>(std::lround(delay / half_period));
      for (std::size_t k = 0; 2 * k + later < watched.states.size(); ++k)
        ASSERT_LT(largest_difference(watched.met[k], watched.states[2 * k + later]), 1e-7) << "at " << k;
    }
  }
}

TEST(Compensation, FindsTheWindThatTheCommandsDoNotExplain) {
  const Vec3<double> wind = {0.6, -0.3, 0.2};
  for (const Alone& alone : {Alone(Multirotor{}), Alone(AngleMultirotor{}), Alone(VelocityMultirotor{})}) {
    SCOPED_TRACE(alone.team.model(BodyId{0}).name());
    Watched watched(alone, {BodyId{0}, 0.05, 0.5}, {.wind = wind, .input_delay = 0.05});
    for (int k = 0; k < 1000; ++k) watched.step();
    const Vec3<double> w = watched.compensation.disturbance(BodyId{0});
    const bool pushed_up = alone.team.model(BodyId{0}).name() == VelocityMultirotor::name;
    EXPECT_NEAR(w.x, wind.x, 0.01);
    EXPECT_NEAR(w.y, wind.y, 0.01);
    EXPECT_NEAR(w.z, pushed_up ? wind.z : 0.0, 0.01);
    watched.compensation.forget(BodyId{0});
    EXPECT_EQ(watched.compensation.disturbance(BodyId{0}).x, 0.0);
  }
}

// How far a robot stands from where it is asked to be, after 20 s in a wind of which it knows
// nothing.
template <RobotModel M>
double offset(const M& robot, const Vec3<double>& wind, double gain,
              const std::vector<RobotCompensation>& how) {
  Team team;
  const Alone alone(robot);
  std::array<double, M::nx> Q{};
  Q[0] = Q[1] = Q[2] = 1.5;
  team.add(robot, {.Q = Q, .x_ref = alone.start});
  NewtonRiccati solver(team, {.T = 1.0, .N = 20, .dt = control_period});
  ModelWorld world(team, alone.start,
                   {.disturbances = {.wind = wind, .input_delay = 0.1, .input_gain = gain}});
  SimulatedClock clock;
  test::SampleSink nowhere(sized_sample(team, {solver}));
  std::optional<Compensation> compensation;
  if (!how.empty()) compensation.emplace(team, how, control_period);
  Loop loop(world, {solver}, clock, nowhere,
            {.duration = 20.0, .compensation = compensation ? &*compensation : nullptr});
  loop.run();
  const auto x = world.x();
  return norm(x[0] - alone.start[0], x[1] - alone.start[1]);
}

TEST(Compensation, LeavesNoOffsetInWindFromAnywhereEvenWithAWrongGain) {
  for (int i = 0; i < 8; ++i) {
    const double from = 0.25 * 3.141592653589793 * i;
    const Vec3<double> wind = {0.75 * std::cos(from), 0.75 * std::sin(from), 0.0};
    for (const double gain : {0.7, 1.0, 1.5}) {
      SCOPED_TRACE(fmt::format("wind from {} rad, gain {}", from, gain));
      const RobotCompensation how = {BodyId{0}, 0.1, 0.5};
      EXPECT_GT(offset(Multirotor{}, wind, gain, {}), 0.1);
      EXPECT_LT(offset(Multirotor{}, wind, gain, {how}), 1e-3);
      EXPECT_LT(offset(VelocityMultirotor{}, wind, gain, {how}), 1e-3);
    }
  }
}

// A robot with its own states is told the rest of its state and of its lean. Both together are what
// it has in the wind.
TEST(Compensation, TellsHowWhatItAddsMakesARobotLean) {
  const Vec3<double> wind = {0.6, -0.3, 0.0};
  for (const Alone& alone : {Alone(Multirotor{}), Alone(AngleMultirotor{}), Alone(VelocityMultirotor{}),
                             Alone(HoverMultirotor{}), Alone(LaggingHoverMultirotor{}), Alone(PointMass{})}) {
    const Model& model = alone.team.model(BodyId{0});
    SCOPED_TRACE(fmt::format("{} of {} states", model.name(), model.nx()));
    Watched watched(alone, {BodyId{0}, 0.0, 0.3}, {.wind = wind});
    for (int k = 0; k < 1000; ++k) watched.step();
    const Vec3<double> w = watched.compensation.disturbance(BodyId{0});
    const Numbers& rest = watched.met.back();
    Numbers whole = rest, u(watched.compensation.added().begin(), watched.compensation.added().end());
    for (std::size_t i = 0; i < whole.size(); ++i) whole[i] += watched.compensation.held()[i];
    const Sight<double> without = model.sight(rest.data(), Numbers(u.size()).data()),
                        with = model.sight(whole.data(), u.data());
    const Vec2<double> lean = watched.compensation.lean()[0];
    EXPECT_NEAR(lean.x, with.lean.x - without.lean.x, 1e-6);
    EXPECT_NEAR(lean.y, with.lean.y - without.lean.y, 1e-6);
    // It leans against the wind.
    const Vec2<double> in_G = model.turns() ? rotate(without.d, lean) : lean;
    EXPECT_NEAR(in_G.x, -w.x / gravity, 1e-4);
    EXPECT_NEAR(in_G.y, -w.y / gravity, 1e-4);
    EXPECT_NEAR(w.x, wind.x, 0.02);
    watched.compensation.forget(BodyId{0});
    EXPECT_EQ(norm(watched.compensation.lean()[0].x, watched.compensation.lean()[0].y), 0.0);
    for (const double held : watched.compensation.held()) EXPECT_EQ(held, 0.0);
  }
}

// How far a robot is from its circle after 20 s, in a wind and with a gain of which it knows
// nothing.
double beside_its_circle(FeedForwardFrom feed_forward, double gain, std::string_view solver_name) {
  const Circle circle = {.centre = {0, 0, 1}, .radius = 0.5, .rate = 0.3};
  const Alone alone(HoverMultirotor{});
  Team team;
  team.add(HoverMultirotor{}, {.Q = {1.5, 1.5, 1.6, 0, 0, 0, 0}, .x_ref = circle});
  const Horizon horizon = {.T = 1.0, .N = 20, .dt = control_period};
  std::unique_ptr<Solver> solver;
  if (solver_name == "cgmres") solver = std::make_unique<Cgmres>(team, horizon);
  if (solver_name == "newton_riccati") solver = std::make_unique<NewtonRiccati>(team, horizon);
  if (solver_name == "parts")
    solver = std::make_unique<PartitionedSolver>(team, Partition{{AgentId{{0}}}}, [&](const Team& t) {
      return std::make_unique<NewtonRiccati>(t, horizon);
    });
  ModelWorld world(team, alone.start,
                   {.disturbances = {.wind = {0.4, -0.3, 0}, .input_delay = 0.1, .input_gain = gain}});
  SimulatedClock clock;
  test::SampleSink nowhere(sized_sample(team, {*solver}));
  Compensation compensation(team, {{BodyId{0}, 0.1, 0.5, feed_forward}}, control_period);
  Loop(world, {*solver}, clock, nowhere, {.duration = 20.0, .compensation = &compensation}).run();
  const auto x = world.x();
  return norm(x[0] - circle(20.0).p.x, x[1] - circle(20.0).p.y);
}

TEST(Compensation, FeedsACircleForwardThatAPlanWouldCutWhateverTheGain) {
  for (const std::string_view solver : {"newton_riccati", "parts", "cgmres"}) {
    for (const double gain : {1 / 0.7, 1.0, 1 / 1.5}) {
      SCOPED_TRACE(fmt::format("{}, gain {}", solver, gain));
      const double fed = beside_its_circle(FeedForwardFrom::reference, gain, solver);
      EXPECT_LT(fed, 0.01);
      EXPECT_LT(fed, 0.5 * beside_its_circle(FeedForwardFrom::none, gain, solver));
    }
  }
}

TEST(Compensation, TakesNoMoreOfAnInputThanItsPart) {
  const Alone alone(Multirotor{});
  Watched watched(alone, {BodyId{0}, 0.0, 0.1}, {.wind = {50.0, 20.0, 0.0}});
  for (int k = 0; k < 300; ++k) watched.step();
  double most = 0.0;
  for (const double u : watched.compensation.added()) most = std::max(most, std::abs(u));
  EXPECT_NEAR(most, Compensation::most_part, 1e-12);
}

// Keeps the applied inputs of a flight, and what the solver asked for.
struct Inputs final : test::SampleSink {
  using SampleSink::SampleSink;
  void publish() noexcept override { applied.push_back(sample_.u), requested.push_back(sample_.raw_u); }

  std::vector<Numbers> applied, requested;
};

// A robot sent 3 m away in a wind, by a solver that knows what is added.
Inputs flown_in_wind(const std::vector<double>& rate_max) {
  Team team;
  const Alone alone(Multirotor{});
  Numbers there = alone.start;
  there[0] += 2.0, there[1] -= 2.0;
  team.add(Multirotor{}, {.Q = {3, 3, 3, 0, 0, 0, 0}, .x_ref = there, .rate_max = rate_max});
  NewtonRiccati solver(team, {.T = 1.0, .N = 20, .dt = control_period});
  ModelWorld world(team, alone.start, {.disturbances = {.wind = {0.7, 0.3, 0.0}}});
  SimulatedClock clock;
  Inputs inputs(sized_sample(team, {solver}));
  Compensation compensation(team, {{BodyId{0}, 0.0, 0.5}}, control_period);
  Loop loop(world, {solver}, clock, inputs, {.duration = 10.0, .compensation = &compensation});
  const LoopOutcome outcome = loop.run();
  EXPECT_EQ(outcome.refused, 0);
  EXPECT_LT(norm(world.x()[0] - there[0], world.x()[1] - there[1]), 0.02);
  return inputs;
}

double fastest(const std::vector<Numbers>& u) {
  double most = 0.0;
  for (std::size_t k = 1; k < u.size(); ++k)
    most = std::max(most, largest_difference(u[k], u[k - 1]) / control_period);
  return most;
}

TEST(Compensation, LeavesTheSolverTheRestOfTheLimitsAndItAsksForNoMore) {
  const Inputs inputs = flown_in_wind({});
  double most = 0.0;
  for (std::size_t k = 0; k < inputs.applied.size(); ++k) {
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_LE(std::abs(inputs.applied[k][i]), 1.0);
      most = std::max(most, std::abs(inputs.applied[k][i]));
    }
  }
  EXPECT_EQ(most, 1.0);
}

TEST(Compensation, AndTheRateOfInputsHoldTogether) {
  EXPECT_GT(fastest(flown_in_wind({}).applied), 2.5);
  EXPECT_LT(fastest(flown_in_wind({1, 1, 1, 1}).applied), 1.0 + 1e-9);
}

TEST(Compensation, DoesNotTakeWhatIsNoMeasurement) {
  const Alone alone(Multirotor{});
  Watched watched(alone, {BodyId{0}, 0.0, 0.5}, {});
  for (int k = 0; k < 100; ++k) watched.step();
  Numbers broken(watched.plant.x().begin(), watched.plant.x().end());
  broken[5] = std::nan("");
  watched.compensation.look(BodyId{0}, test::valid(alone.team, broken, 1.0));
  EXPECT_LT(norm(watched.compensation.disturbance(BodyId{0})), 1e-6);
  // A wild one moves the estimate by no more than its share of the greatest rate.
  broken[5] = 1e6;
  watched.compensation.look(BodyId{0}, test::valid(alone.team, broken, 1.0));
  EXPECT_LT(norm(watched.compensation.disturbance(BodyId{0})), 20.0 * control_period / 0.5);
}

TEST(Compensation, CarriesOnWhatNobodySteersOverTheLongestDelay) {
  Team team;
  team.add(Multirotor{}, {.name = "quick"});
  team.add(Multirotor{}, {.name = "slow"});
  team.add(Obstacle{.name = "passing"});
  Compensation compensation(team, {{BodyId{0}, 0.1}, {BodyId{1}, 0.3}}, control_period);
  const Numbers x = {0, 0, 1, 1, 0, 0.5, 0, /**/ 0, 2, 1, 1, 0, 0, 0, /**/ 5, 5, 1, -1.0, 0.5, 0};
  const auto met = compensation.ahead(0.0, test::valid(team, x));
  EXPECT_NEAR(met[14], 5 - 0.3, 1e-12);
  EXPECT_NEAR(met[15], 5 + 0.15, 1e-12);
  EXPECT_GT(met[0], 0.045);
  EXPECT_LT(met[0], 0.05);
}

TEST(Compensation, RefusesWhatCannotBe) {
  Team team;
  team.add(Multirotor{}, {.name = "uav0"});
  team.add(Obstacle{.name = "rock"});
  const auto refusal = [&](const std::vector<RobotCompensation>& robots) {
    return refusal_of([&] { Compensation(team, robots, control_period); });
  };
  EXPECT_EQ(refusal({{BodyId{0}, 0.2, 0.5}}), "");
  EXPECT_THAT(refusal({{BodyId{1}, 0.2}}), HasSubstr("body 1 is compensated, expected a robot of the team"));
  EXPECT_THAT(refusal({{BodyId{0}}, {BodyId{0}}}), HasSubstr("uav0 is compensated twice, expected once"));
  EXPECT_THAT(refusal({{BodyId{0}, 1.5}}), HasSubstr("command_delay of uav0 = 1.5, expected 0 to 1 s"));
  EXPECT_THAT(refusal({{BodyId{0}, 0.0, 0.01}}),
              HasSubstr("disturbance_time of uav0 = 0.01, expected 0.05 to 60 s"));
}

}  // namespace
}  // namespace sightline
