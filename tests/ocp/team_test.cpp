#include "sightline/team.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

/// Two robots and an obstacle.
struct Trio {
  Team team;
  AgentId uav0 = team.add(Multirotor{});
  AgentId uav1 = team.add(AngleMultirotor{});
  BodyId rock = team.add(Obstacle{"rock"});
};

TEST(Team, BodiesWithoutANameAreNumbered) {
  Team team;
  EXPECT_EQ(team.name(team.add(Multirotor{})), "uav0");
  EXPECT_EQ(team.name(team.add(Obstacle{})), "obstacle0");
  EXPECT_EQ(team.name(team.add(AngleMultirotor{})), "uav1");
  EXPECT_EQ(team.name(team.add(Obstacle{})), "obstacle1");
  EXPECT_EQ(team.name(team.add(Multirotor{}, {.name = "scout"})), "scout");
}

TEST(Team, LimitsThatAreLeftOutAreTheModels) {
  Team team;
  const VelocityMultirotor drone = VelocityMultirotor::ar_drone();
  const std::vector<double> own = {drone.v_max, drone.v_max, drone.climb_max, drone.yaw_max},
                            given = {1, 2, 3, 0.5};
  const auto limits = [&](AgentId id) { return team.agent(id).limits; };
  const auto plain = limits(team.add(drone));
  EXPECT_EQ(plain.u_max().at(0), own);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(plain.u_min().at(0)[i], -own[i]);
  const auto half = limits(team.add(drone, {.u_min = {-1, -2, -3, -0.5}}));
  EXPECT_EQ(half.u_min().at(0), (std::vector<double>{-1, -2, -3, -0.5}));
  EXPECT_EQ(half.u_max().at(0), own);
  EXPECT_EQ(limits(team.add(drone, {.u_max = std::array<double, 4>{1, 2, 3, 0.5}})).u_max().at(0), given);
}

TEST(Team, StatesAndInputsFollowOneAnotherWithoutGaps) {
  Random random(1);
  for (int k = 0; k < 100; ++k) {
    Team team;
    int nx = 0, nu = 0, agents = 0;
    for (int i = 0; i < 10; ++i) {
      const auto kind = random() % 3;
      const BodyId id = kind == 0   ? team.add(Multirotor{})
                        : kind == 1 ? team.add(AngleMultirotor{})
                                    : team.add(Obstacle{});
      EXPECT_EQ(id.index, i);
      EXPECT_EQ(team.state_offset(id), nx);
      EXPECT_EQ(team.input_offset(id), nu);
      EXPECT_EQ(team.is_agent(id), kind < 2);
      if (team.is_agent(id)) {
        EXPECT_EQ(team.agent(id).name, team.name(id));
        EXPECT_EQ(&team.agent(id), &team.agents()[static_cast<std::size_t>(agents++)]);
      }
      nx += team.model(id).nx();
      nu += team.model(id).nu();
    }
    EXPECT_EQ(team.bodies(), 10);
    EXPECT_EQ(team.nx(), nx);
    EXPECT_EQ(team.nu(), nu);
    EXPECT_EQ(static_cast<int>(team.agents().size()), agents);
  }
}

TEST(Team, WhatIsNotSaidOfAnAgentIsZeroOrOne) {
  Team team;
  const Agent& agent = team.agent(team.add(Multirotor{}));
  EXPECT_EQ(agent.Q, std::vector<double>(7, 0.0));
  EXPECT_EQ(agent.R, std::vector<double>(4, 1.0));
  EXPECT_EQ(agent.Q_f, std::vector<double>(7, 0.0));
  EXPECT_EQ(agent.u_ref, std::vector<double>(4, 0.0));
  EXPECT_EQ(agent.limits.u_min()[0], std::vector<double>(4, -1.0));
  EXPECT_EQ(agent.limits.u_max()[0], std::vector<double>(4, 1.0));
}

TEST(Team, ACouplingIsFeltByAllItsRobotsUnlessSaidOtherwise) {
  Trio t;
  t.team.couple(0.4 * KeepOut{}, {t.uav0, t.uav1});
  t.team.couple(0.4 * KeepOut{}, {t.rock, t.uav1});
  t.team.couple(0.4 * KeepOut{}, {t.uav0, t.uav1}, felt_by(t.uav1));
  t.team.couple(0.4 * KeepOut{}, {t.uav0, t.uav1}, felt_by({t.uav1, t.uav0}));
  ASSERT_EQ(t.team.couplings().size(), 4u);
  EXPECT_EQ(t.team.couplings()[0].felt_by, (std::vector{t.uav0, t.uav1}));
  EXPECT_EQ(t.team.couplings()[1].felt_by, std::vector{t.uav1});
  EXPECT_EQ(t.team.couplings()[2].felt_by, std::vector{t.uav1});
  EXPECT_EQ(t.team.couplings()[3].felt_by, (std::vector{t.uav1, t.uav0}));
  EXPECT_EQ(t.team.couplings()[1].between.first, t.rock);
  EXPECT_EQ(t.team.couplings()[0].term.weight, 0.4);
}

/// An agent that may be added, to be spoilt.
Agent sound() {
  return {.name = "a",
          .model = Multirotor{},
          .Q = std::vector<double>(7, 1.0),
          .R = std::vector<double>(4, 1.0),
          .Q_f = {},
          .limits = {std::vector<double>(4, -1.0), std::vector<double>(4, 1.0)}};
}

/// What the team says to an agent that `spoil` has changed.
std::string refusal_after(const std::function<void(Agent&)>& spoil) {
  return refusal_of([&] {
    Team team;
    Agent agent = sound();
    spoil(agent);
    team.add(std::move(agent));
  });
}

TEST(Team, AnUnsoundAgentIsRefusedByFieldValueAndRange) {
  EXPECT_EQ(refusal_after([](Agent&) {}), "");
  EXPECT_EQ(refusal_after([](Agent& a) { a.Q.pop_back(); }), "a.Q has 6 entries, expected 7");
  EXPECT_EQ(refusal_after([](Agent& a) { a.Q_f = {1, 2}; }), "a.Q_f has 2 entries, expected 7");
  EXPECT_EQ(refusal_after([](Agent& a) { a.Q[3] = -0.5; }), "a.Q = -0.5, expected >= 0");
  EXPECT_EQ(refusal_after([](Agent& a) { a.Q[3] = not_a_number; }), "a.Q = nan, expected >= 0");
  EXPECT_EQ(refusal_after([](Agent& a) { a.R[0] = 0; }), "a.R = 0, expected > 0");
  EXPECT_EQ(refusal_after([](Agent& a) { a.R[0] = infinite; }), "a.R = inf, expected > 0");
  EXPECT_EQ(refusal_after([](Agent& a) {
              a.u_ref = {0, 0};
            }),
            "a.u_ref has 2 entries, expected 4 finite numbers");
  EXPECT_EQ(refusal_after([](Agent& a) {
              a.u_ref = {0, 0, 0, not_a_number};
            }),
            "a.u_ref has 4 entries, expected 4 finite numbers");
  EXPECT_EQ(refusal_after([](Agent& a) {
              a.limits = {std::vector{-1.0}, std::vector{1.0}};
            }),
            "a.u_min has 1 entries, expected 4");
}

TEST(Team, ANameIsGivenOnce) {
  Trio t;
  EXPECT_EQ(refusal_of([&] { t.team.add(Obstacle{"rock"}); }),
            "the name \"rock\" is given twice, expected one body of a name");
  EXPECT_EQ(refusal_of([&] { t.team.add(Multirotor{}, {.name = "rock"}); }),
            "the name \"rock\" is given twice, expected one body of a name");
}

TEST(Team, AnUnsoundCouplingIsRefused) {
  Trio t;
  const auto couple = [&](const Weighted& term, Between between, std::vector<AgentId> felt) {
    return refusal_of([&] { t.team.couple(term, between, std::move(felt)); });
  };
  const Weighted term = 0.4 * KeepOut{};
  const Between both{t.uav0, t.uav1};
  EXPECT_EQ(couple(term, {t.uav0, BodyId{7}}, {t.uav0}),
            "body 7 is not in the team, expected an id that add() returned");
  EXPECT_EQ(couple(-0.5 * KeepOut{}, both, {t.uav0}), "weight = -0.5 of keep_out, expected >= 0");
  EXPECT_EQ(couple(1.0 * AltitudeBand{}, both, {t.uav0}),
            "altitude_band sees one robot alone, expected a potential between two bodies");
  EXPECT_EQ(couple(term, {t.uav0, t.uav0}, {t.uav0}), "\"uav0\" is coupled with itself, expected two bodies");
  EXPECT_EQ(couple(term, both, {}),
            "the coupling keep_out of \"uav0\" and \"uav1\" is felt by no robot, expected at least one robot "
            "of the two");
  EXPECT_EQ(couple(term, {t.uav0, t.rock}, {t.uav1}),
            "felt_by names \"uav1\", expected a robot of between = [\"uav0\", \"rock\"]");
  EXPECT_EQ(couple(term, {t.uav0, t.rock}, {AgentId{t.rock}}),
            "felt_by names \"rock\", expected a robot of between = [\"uav0\", \"rock\"]");
  EXPECT_NE(couple(term, both, {t.uav0, t.uav0}), "") << "felt twice";
  EXPECT_TRUE(t.team.couplings().empty());
}

TEST(Team, WhatLooksPastAThirdBodyAndNothingElseHasOne) {
  Trio t;
  const Region past("abs(observer.p_x - third.p_x) > 1 m");
  const auto couple = [&](const Region& region, BodyId third) {
    return refusal_of([&] {
      t.team.couple({.term = 1.0 * region, .between = {t.uav0, t.uav1}, .felt_by = {t.uav0}, .third = third});
    });
  };
  EXPECT_EQ(couple(past, {}),
            "region looks past a third body, expected a coupling that names one as its third");
  EXPECT_EQ(couple(Region("distance > 1 m"), t.rock),
            "region does not look past the third body \"rock\", expected a potential that does, or none");
  EXPECT_EQ(couple(past, t.uav1), "the third body of region is \"uav1\", expected another than its two");
  EXPECT_TRUE(t.team.couplings().empty());
  EXPECT_EQ(couple(past, t.rock), "");
  EXPECT_FALSE(
      alike(t.team.couplings()[0], {.term = 1.0 * past, .between = {t.uav0, t.uav1}, .felt_by = {t.uav0}}));
}

TEST(Team, TwoThingsThatAreNotControlledFeelNothing) {
  Trio t;
  const BodyId tree = t.team.add(Obstacle{"tree"});
  EXPECT_EQ(refusal_of([&] {
              t.team.couple(1.0 * KeepOut{}, {t.rock, tree});
            }),
            "the coupling keep_out of \"rock\" and \"tree\" is felt by no robot, expected at least one robot "
            "of the two");
}

TEST(Team, AnUnsoundConstraintIsRefused) {
  Trio t;
  const auto constrain = [&](const Weighted& term, AgentId agent) {
    return refusal_of([&] { t.team.constrain(term, agent); });
  };
  EXPECT_EQ(constrain(1.0 * AltitudeBand{}, AgentId{t.rock}), "\"rock\" is not controlled, expected a robot");
  EXPECT_EQ(constrain(1.0 * KeepOut{}, t.uav0),
            "keep_out lies between two bodies, expected a potential of one robot");
  EXPECT_EQ(constrain(1.0 * AltitudeBand{}, AgentId{}),
            "body -1 is not in the team, expected an id that add() returned");
  EXPECT_TRUE(t.team.constraints().empty());
}

TEST(Team, ABarrierIsListedUnderItsRobotAndRefusedWhereItDoesNotFit) {
  Trio t;
  const RelaxedBarrier speed{SpeedLimit{0.8}, 0.02, 0.1}, disc{InputDisc{.i = 2, .j = 3}, 0.02, 0.1};
  t.team.constrain(speed, t.uav1);
  t.team.constrain(disc, t.uav1);
  EXPECT_EQ(t.team.barriers(t.uav0).size(), 0u);
  ASSERT_EQ(t.team.barriers(t.uav1).size(), 2u);
  EXPECT_EQ(t.team.barriers(t.uav1)[0].limit.name(), "speed");
  EXPECT_EQ(t.team.barriers(t.uav1)[1].limit.name(), "input_disc");
  const auto constrain = [&](const RelaxedBarrier& barrier, AgentId agent) {
    return refusal_of([&] { t.team.constrain(barrier, agent); });
  };
  EXPECT_EQ(constrain({SpeedLimit{}, -1.0, 0.1}, t.uav0), "speed.mu = -1, expected > 0");
  EXPECT_EQ(constrain({InputDisc{.i = 1, .j = 4}}, t.uav0),
            "input_disc reads 0 states and 5 inputs, \"uav0\" has 7 and 4, expected as many at least");
}

TEST(InputLimits, HoldFromTheirTimeToTheNextAndTheFirstBefore) {
  const InputLimits limits({1, 2, 3}, {{-1}, {-2}, {-3}}, {{1}, {0.5}, {0.25}});
  const auto at = [&](double t) {
    double u_min = 0, u_max = 0;
    limits.at(t, {&u_min, 1}, {&u_max, 1});
    return std::pair(u_min, u_max);
  };
  EXPECT_EQ(at(-100), std::pair(-1.0, 1.0));
  EXPECT_EQ(at(1.0), std::pair(-1.0, 1.0));
  EXPECT_EQ(at(1.999), std::pair(-1.0, 1.0));
  EXPECT_EQ(at(2.0), std::pair(-2.0, 0.5));
  EXPECT_EQ(at(3.0), std::pair(-3.0, 0.25));
  EXPECT_EQ(at(1e9), std::pair(-3.0, 0.25));
}

TEST(InputLimits, WhatIsNoLimitIsRefused) {
  using Rows = std::vector<std::vector<double>>;
  const auto constant = [](std::vector<double> u_min, std::vector<double> u_max) {
    return refusal_of([&] { InputLimits(std::move(u_min), std::move(u_max)); });
  };
  const auto timed = [](std::vector<double> times, Rows u_min, Rows u_max) {
    return refusal_of([&] { InputLimits(std::move(times), std::move(u_min), std::move(u_max)); });
  };
  EXPECT_EQ(constant({-1, 0.5}, {1, 0.5}),
            "limits: u_min[1] = 0.5, u_max[1] = 0.5, expected u_min < u_max, both finite");
  EXPECT_EQ(constant({-infinite}, {1}),
            "limits: u_min[0] = -inf, u_max[0] = 1, expected u_min < u_max, both finite");
  EXPECT_EQ(constant({-1}, {not_a_number}),
            "limits: u_min[0] = -1, u_max[0] = nan, expected u_min < u_max, both finite");
  EXPECT_EQ(constant({-1}, {1, 1}), "limits: u_min has 1 entries, u_max has 2, expected as many in all");
  EXPECT_EQ(timed({0, 1}, {{-1}, {-1, -1}}, {{1}, {1, 1}}),
            "limits: u_min has 2 entries, u_max has 2, expected as many in all");
  EXPECT_EQ(timed({0, 1}, {{-1}}, {{1}}),
            "limits have 2 times, 1 u_min and 1 u_max, expected as many of each");
  for (const double second : {1.0, 0.5}) {
    EXPECT_EQ(timed({1, second}, {{-1}, {-1}}, {{1}, {1}}),
              fmt::format("limits.times = {} after 1, expected finite and rising", second));
  }
  EXPECT_EQ(timed({infinite}, {{-1}}, {{1}}), "limits.times = inf, expected finite and rising");
}

TEST(Team, AReferenceOfAnotherLengthIsRefused) {
  Team team;
  EXPECT_THROW(team.add(Multirotor{}, {.x_ref = std::array<double, 3>{1, 2, 3}}), std::invalid_argument);
  EXPECT_THROW(team.add(AngleMultirotor{}, {.x_ref = std::array<double, 7>{}}), std::invalid_argument);
  EXPECT_THROW(team.add(Multirotor{}, {.x_ref = [](double) { return std::array<double, 6>{}; }}),
               std::invalid_argument);
  EXPECT_NO_THROW(team.add(Multirotor{}, {.x_ref = std::array<double, 7>{}}));
  EXPECT_NO_THROW(team.add(AngleMultirotor{}, {.x_ref = Circle{}}));
}

/// A chain of integrators: a robot of as many states as one likes.
struct Long {
  static constexpr std::size_t nx = 70, nu = 1;
  static constexpr std::string_view name = "long";
  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    std::array<S, nx> rate;
    rate[0] = u[0];
    for (std::size_t i = 1; i < nx; ++i) rate[i] = x[i - 1];
    return rate;
  }
  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[nx - 1], S(0.0), S(0.0)}, {S(1.0), S(0.0)}};
  }
  template <class S>
  std::array<S, nx> at_rest(const Pose<S>& pose) const {
    std::array<S, nx> x;
    x.fill(S(0.0));
    x[nx - 1] = pose.p.x;
    return x;
  }
};

TEST(Team, AReferenceIsReplacedUnderTheConditionsOfAdding) {
  Trio trio;
  const auto replace = [&](AgentId id, std::size_t length) {
    trio.team.set_reference(id, Reference(std::vector<double>(length, 0.5)));
  };
  const int nx = trio.team.nx();
  replace(trio.uav1, static_cast<std::size_t>(trio.team.model(trio.uav1).nx()));
  EXPECT_NE(trio.team.agent(trio.uav1).x_ref.length(), 0u);
  EXPECT_EQ(trio.team.agent(trio.uav0).x_ref.length(), Reference().length());
  EXPECT_EQ(trio.team.nx(), nx);
  EXPECT_NE(refusal_of([&] { replace(trio.uav1, 3); }).find("uav1.x_ref has 3 numbers"), std::string::npos);
  EXPECT_THROW(replace(AgentId{trio.rock}, 6), std::out_of_range);
}

TEST(Team, ARobotOfMoreStatesThanAPoseSuitsWantsThemAllAsItsReference) {
  Team team;
  try {
    team.add(Long{}, {.name = "snake"});
    ADD_FAILURE() << "a pose was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(
        error.what(),
        "snake.x_ref is a pose of a robot of 70 states, expected all of its states: a pose suits at most 64");
  }
  const AgentId snake = team.add(Long{}, {.x_ref = std::vector<double>(70, 0.5), .name = "snake"});
  std::vector<double> x(70);
  team.agent(snake).x_ref(0.0, team.model(snake), x);
  EXPECT_EQ(x, std::vector<double>(70, 0.5));
  EXPECT_THROW(Reference::between(std::vector<double>(70, 0.5), Reference{}, {}), std::invalid_argument);
}

TEST(Team, AnIdThatIsNoneOfItIsRefused) {
  Team team;
  const AgentId robot = team.add(Multirotor{});
  const BodyId ball = team.add(Obstacle{"ball"});
  for (const BodyId none : {BodyId{}, BodyId{2}, BodyId{-7}, BodyId{1 << 30}}) {
    EXPECT_THROW((void)team.is_agent(none), std::out_of_range);
    EXPECT_THROW((void)team.agent(none), std::out_of_range);
    EXPECT_THROW((void)team.name(none), std::out_of_range);
    EXPECT_THROW((void)team.model(none), std::out_of_range);
    EXPECT_THROW((void)team.state_offset(none), std::out_of_range);
    EXPECT_THROW((void)team.input_offset(none), std::out_of_range);
  }
  EXPECT_THROW((void)team.agent(ball), std::out_of_range);
  EXPECT_NO_THROW((void)team.agent(robot));
}

TEST(Team, TheScaleOfAnInputIsHalfItsRangeOrWhatItCostsWhereItIsAsGoodAsUnlimited) {
  Agent agent{.name = "a",
              .model = Multirotor{},
              .Q = std::vector<double>(7, 0.0),
              .R = {1.0, 4.0, 1.0, 100.0},
              .Q_f = {},
              .limits = InputLimits({-1.0, -0.4, -1e6, -0.05}, {1.0, 0.8, 1e9, 0.05})};
  EXPECT_EQ(input_scales(agent), (std::vector<double>{1.0, 0.6000000000000001, 1.0, 0.05}));
  agent.limits = InputLimits(std::vector<double>{0.0, 2.0}, {{-1, -1, -1, -1}, {-0.2, -3, 0, -1}},
                             {{1, 1, 1, 1}, {0.2, 3, 0.5, 1}});
  EXPECT_EQ(input_scales(agent), (std::vector<double>{1.0, 3.0, 1.0, 1.0})) << "the widest there will be";
}

}  // namespace
}  // namespace sightline
