#include "sightline/barrier.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "cli/allocations.hpp"
#include "sightline/robots.hpp"
#include "tests/support/adversary.hpp"
#include "tests/support/period.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/robots.hpp"

namespace sightline {
namespace {

using test::barrier;
using test::control_period;
using test::highest;
using test::lowest;
using test::State;
using test::VehicleInput;

State random_state(Random& random, double speed) {
  const double psi = uniform(random, -std::numbers::pi, std::numbers::pi);
  return {
      uniform(random, -3, 3), uniform(random, -3, 3),         uniform(random, 0.5, 3),       std::cos(psi),
      std::sin(psi),          uniform(random, -speed, speed), uniform(random, -speed, speed)};
}

Vec3<double> position(const State& x) { return {x[0], x[1], x[2]}; }

/// An uncooperative neighbour whose reserve is `reserve`, in any direction.
Neighbour uncooperative_at(const Barrier& filter, const State& x, double reserve, Random& random) {
  Neighbour n{.d_hard = uniform(random, 0.4, 1.2), .speed_max = uniform(random, 0.0, 1.5)};
  const Vec3<double> direction = test::any_direction(random, true);
  double near = 0.1, far = 30.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (near + far);
    n.p = position(x) + middle * direction;
    (filter.reserve(x, n) < reserve ? near : far) = middle;
  }
  n.p = position(x) + far * direction;
  return n;
}

/// Whether the robot stays out of reach of the uncooperative neighbour until it is the faster one.
/// Its model flies with one pair of full thrusts, height and heading held.
bool can_flee(const State& from, const Neighbour& n) {
  for (const double u_f : {-1.0, 1.0}) {
    for (const double u_s : {-1.0, 1.0}) {
      State x = from;
      bool safe = true;
      for (int k = 0; safe && k < 800; ++k) {
        test::fly(Multirotor{}, x, {u_f, u_s, 0, 0}, control_period, [&](const Vec3<double>& p, double t) {
          safe = safe && norm(p - n.p) >= n.d_hard + n.speed_max * (control_period * k + t);
        });
      }
      if (safe) return true;
    }
  }
  return false;
}

TEST(Barrier, ReserveIsAPromiseThatTheRobotItselfCanKeep) {
  const Barrier filter = barrier({.authority = 1.0});
  Random random(1);
  int beyond = 0;
  for (int k = 0; k < 2000; ++k) {
    const State x = random_state(random, 2.0);
    EXPECT_TRUE(can_flee(x, uncooperative_at(filter, x, 0.0, random)));
    // And no much smaller one than there is.
    beyond += can_flee(x, uncooperative_at(filter, x, -0.1, random));
  }
  EXPECT_LE(beyond, 40);
}

// The argument of the barrier, tick by tick: whatever is commanded and wherever the uncooperative
// neighbour goes.
TEST(Barrier, UsesUpItsReserveNoFasterThanItsRate) {
  const Barrier filter = barrier();
  Random random(2);
  for (int k = 0; k < 20000; ++k) {
    State x = random_state(random, 2.0);
    Neighbour n = uncooperative_at(filter, x, k % 2 == 0 ? 0.0 : uniform(random, 0.0, 0.1), random);
    const double before = filter.reserve(x, n);
    VehicleInput u = k % 3 == 0 ? test::towards(x, n.p) : uniform_array<4>(random, -1, 1);
    const BarrierResult result = filter.filter(x, std::span(&n, 1), lowest, highest, u);
    EXPECT_FALSE(result.conflict);
    EXPECT_NEAR(result.reserve, before, 1e-12);
    const Vec3<double> r = position(x) - n.p;
    const Vec3<double> goes = k % 2 == 0 ? (1 / norm(r)) * r : test::any_direction(random, true);
    test::fly(Multirotor{}, x, u, control_period, [](const Vec3<double>&, double) {});
    n.p = n.p + control_period * n.speed_max * goes;
    EXPECT_GE(filter.reserve(x, n), (1 - filter.options().rate * control_period) * before - 2e-3);
  }
}

TEST(Barrier, LeavesACommandAloneBitForBitThatIsSafe) {
  const Barrier filter = barrier({.floor = 0.0, .ceiling = 10.0, .world = 100.0});
  Random random(3);
  for (int k = 0; k < 2000; ++k) {
    const State x = random_state(random, 1.0);
    const Neighbour n = uncooperative_at(filter, x, uniform(random, 4.0, 8.0), random);
    const VehicleInput wanted = uniform_array<4>(random, -1, 1);
    VehicleInput u = wanted;
    const BarrierResult result = filter.filter(x, std::span(&n, 1), lowest, highest, u);
    EXPECT_FALSE(result.active);
    EXPECT_EQ(u, wanted);
  }
}

TEST(Barrier, KeepsTheDistanceToWhatStandsStill) {
  const Barrier filter = barrier();
  for (const double start : {1.5, 4.0, 9.0}) {
    State x = {0, 0, 1, 0.8, 0.6, 0, 0};
    const Neighbour n{.p = {start, 0.2, 1.3}, .d_hard = 0.6, .speed_max = 0.0};
    double nearest = 1e9;
    for (int k = 0; k < 1500; ++k) {
      VehicleInput u = test::towards(x, n.p);
      filter.filter(x, std::span(&n, 1), lowest, highest, u);
      test::fly(Multirotor{}, x, u, control_period,
                [&](const Vec3<double>& p, double) { nearest = std::min(nearest, norm(p - n.p)); });
    }
    EXPECT_GE(nearest, 0.6 + 0.5 * filter.options().margin);
    EXPECT_LE(nearest, 0.65);
  }
}

TEST(Barrier, AddsThreeSigmaAndWhatOldDataMayHide) {
  const Barrier filter = barrier();
  Random random(4);
  for (int k = 0; k < 500; ++k) {
    const State x = random_state(random, 1.0);
    Neighbour n = uncooperative_at(filter, x, 1.0, random);
    const double fresh = filter.reserve(x, n);
    n.sigma = 0.05;
    EXPECT_NEAR(filter.reserve(x, n), fresh - 0.15, 1e-9);
    n.sigma = 0.0;
    n.age = 0.1;
    EXPECT_NEAR(filter.reserve(x, n), fresh - 0.1 * n.speed_max, 1e-9);
  }
  Neighbour peer{.p = {5, 0, 1}, .behavior = Behavior::cooperative};
  const State x = {0, 0, 1, 1, 0, 1.5, 0};
  const double fresh = filter.reserve(x, peer);
  peer.age = 0.1;
  EXPECT_LT(filter.reserve(x, peer), fresh - 0.05);
  EXPECT_LT(barrier({.velocity_sigma = 0.05}).reserve(x, peer), filter.reserve(x, peer) - 0.05);
}

TEST(Barrier, KeepsFloorCeilingAndTheWorldsBounds) {
  const Barrier filter = barrier({.floor = 0.3, .ceiling = 3.0, .world = 5.0});
  Random random(5);
  for (int k = 0; k < 60; ++k) {
    State x = random_state(random, 2.0);
    VehicleInput wanted = uniform_array<4>(random, -1, 1);
    double low = 1e9, high = 0, out = 0;
    for (int i = 0; i < 800; ++i) {
      if (i % 100 == 0) wanted = uniform_array<4>(random, -1, 1);
      if (k % 2 == 0) wanted = test::towards(x, {k % 4 == 0 ? 50.0 : -50.0, 30, k % 4 == 0 ? -9.0 : 9.0});
      VehicleInput u = wanted;
      filter.filter(x, {}, lowest, highest, u);
      test::fly(Multirotor{}, x, u, control_period, [&](const Vec3<double>& p, double) {
        low = std::min(low, p.z);
        high = std::max(high, p.z);
        out = std::max({out, std::abs(p.x), std::abs(p.y)});
      });
    }
    EXPECT_GE(low, 0.3 - 1e-9);
    EXPECT_LE(high, 3.0 + 1e-9);
    EXPECT_LE(out, 5.0 + 1e-3);
    if (k % 2 == 0) {
      EXPECT_GE(out, 4.9);
    }
  }
}

TEST(Barrier, KeepsItsMarginBesideTheWalls) {
  const Barrier filter = barrier({.floor = 0.3, .ceiling = 2.0, .wall_margin = 0.1});
  for (const double climb : {-1.0, 1.0}) {
    State x = {0, 0, 1, 1, 0, 0, 0};
    for (int k = 0; k < 500; ++k) {
      VehicleInput u = {0, 0, climb, 0};
      EXPECT_FALSE(filter.filter(x, {}, lowest, highest, u).conflict);
      test::fly(Multirotor{}, x, u, control_period, [](const Vec3<double>&, double) {});
    }
    EXPECT_NEAR(x[2], climb < 0 ? 0.4 : 1.9, 1e-3);
  }
  EXPECT_THROW(barrier({.floor = 0.3, .ceiling = 0.4, .wall_margin = 0.1}), std::invalid_argument);
}

TEST(Barrier, KeepsTheFloorWhateverPressesFromAbove) {
  const Barrier filter = barrier({.floor = 0.3, .ceiling = 2.0, .world = 3.0});
  Random random(10);
  int conflicts = 0;
  for (int k = 0; k < 200; ++k) {
    State x = random_state(random, 0.5);
    x[2] = uniform(random, 0.35, 1.9);
    std::array<Neighbour, 4> others;
    for (Neighbour& n : others) {
      n = {.p = position(x) + uniform(random, 0.1, 1.0) * test::any_direction(random, true),
           .d_hard = 0.6,
           .speed_max = 1.0};
      if (k % 2 == 0) n.p.z = x[2] + uniform(random, 0.0, 0.5);
    }
    for (int i = 0; i < 100; ++i) {
      VehicleInput u = {0, 0, -1, 0};
      conflicts += filter.filter(x, others, lowest, highest, u).conflict;
      test::fly(Multirotor{}, x, u, control_period, [&](const Vec3<double>& p, double) {
        EXPECT_GE(p.z, 0.3 - 1e-9);
        EXPECT_LE(p.z, 2.0 + 1e-9);
      });
    }
  }
  EXPECT_GT(conflicts, 1000);
}

TEST(Barrier, KeepsFloorAndCeilingBeforeADistanceThatIsLost) {
  const Barrier filter = barrier({.floor = 0.3, .ceiling = 2.0});
  for (const double side : {1.0, -1.0}) {  // floor, one above; ceiling, one below
    State x = {0, 0, side > 0 ? 0.3 : 2.0, 1, 0, 0, 0};
    const Neighbour threat{.p = {0.05, 0, x[2] + 0.3 * side}, .d_hard = 0.6, .speed_max = 0.0};
    VehicleInput u = {0, 0, 0, 0};
    EXPECT_TRUE(filter.filter(x, std::span(&threat, 1), lowest, highest, u).conflict);
    const double z = x[2];
    test::fly(Multirotor{}, x, u, control_period, [](const Vec3<double>&, double) {});
    EXPECT_GE(side * x[2], side * z - 1e-9);
  }
}

// A robot that just stops before a bound of the world, and a body behind it that it can only leave
// by going on.
TEST(Barrier, KeepsTheBoundsOfTheWorldBeforeADistanceThatIsLost) {
  constexpr double world = 5.0;
  const Barrier filter = barrier({.world = world});
  for (const Vec2<double>& outward : {Vec2<double>{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    State x = {4.6 * outward.x, 4.6 * outward.y, 1.0, 1, 0, 0.9 * outward.x, 0.9 * outward.y};
    int conflicts = 0;
    for (int k = 0; k < 300; ++k) {
      const Neighbour threat{
          .p = {x[0] - 0.5 * outward.x, x[1] - 0.5 * outward.y, 1.0}, .d_hard = 0.6, .speed_max = 0.0};
      VehicleInput u = {outward.x, outward.y, 0, 0};
      conflicts += filter.filter(x, std::span(&threat, 1), lowest, highest, u).conflict;
      test::fly(Multirotor{}, x, u, control_period, [&](const Vec3<double>& p, double) {
        EXPECT_LE(outward.x * p.x + outward.y * p.y, world + 1e-9);
      });
    }
    EXPECT_GT(conflicts, 100);
  }
}

TEST(Barrier, TellsAConflictAndDividesIt) {
  const Barrier filter = barrier();
  const State x = {0, 0, 1, 1, 0, 0, 0};
  const std::array<Neighbour, 2> both = {Neighbour{.p = {0.7, 0, 1}}, Neighbour{.p = {-0.8, 0, 1}}};
  VehicleInput u = {1, 0.3, 0, 0};
  const BarrierResult result = filter.filter(x, both, lowest, highest, u);
  EXPECT_TRUE(result.conflict);
  EXPECT_TRUE(result.active);
  EXPECT_GT(result.violation, 1e-3);
  EXPECT_LT(result.reserve, 0.0);
  EXPECT_LT(u[0], 0.0);
  EXPECT_GE(result.neighbour, 0);
  EXPECT_TRUE(all_finite(u));
}

TEST(Barrier, NamesWhatIsTightest) {
  const Barrier filter = barrier({.floor = 0.3, .ceiling = 5.0, .world = 20.0});
  const std::array<Neighbour, 2> others = {Neighbour{.p = {8, 0, 1}}, Neighbour{.p = {0, 2.2, 1}}};
  VehicleInput u = {0, 1, 0, 0};
  BarrierResult result = filter.filter(State{0, 0, 1, 1, 0, 0, 0}, others, lowest, highest, u);
  EXPECT_EQ(result.neighbour, 1);
  EXPECT_EQ(result.wall, Wall::none);
  u = {0, 0, -1, 0};
  result = filter.filter(State{0, 0, 0.31, 1, 0, 0, 0}, {}, lowest, highest, u);
  EXPECT_TRUE(result.active);
  EXPECT_EQ(result.neighbour, -1);
  EXPECT_EQ(to_string(result.wall), "floor");
  u = {1, 0, 0, 0};
  result = filter.filter(State{19.9, 0, 1, 1, 0, 0.5, 0}, {}, lowest, highest, u);
  EXPECT_EQ(to_string(result.wall), "x_max");
}

TEST(Barrier, HeedsThePressingOnesOfAHundred) {
  const Barrier filter = barrier();
  Random random(6);
  for (int k = 0; k < 50; ++k) {
    const State x = random_state(random, 1.0);
    std::vector<Neighbour> threats;
    for (int i = 0; i < 100; ++i) {
      threats.push_back({.p = position(x) + uniform(random, 12, 20) * test::any_direction(random, true)});
    }
    const Neighbour threat = uncooperative_at(filter, x, 0.0, random);
    const std::size_t at = random() % threats.size();
    threats[at] = threat;
    VehicleInput alone = test::towards(x, threat.p), u = alone;
    const BarrierResult one = filter.filter(x, std::span(&threat, 1), lowest, highest, alone);
    const BarrierResult result = filter.filter(x, threats, lowest, highest, u);
    EXPECT_EQ(u, alone);
    EXPECT_EQ(result.reserve, one.reserve);
    EXPECT_EQ(result.neighbour, static_cast<int>(at));
  }
}

TEST(Barrier, GivesFiniteCommandsWithinTheLimitsWhateverItIsTold) {
  const Barrier filter = barrier({.floor = 0.3, .ceiling = 10, .world = 100});
  constexpr double inf = std::numeric_limits<double>::infinity(), nan = not_a_number;
  constexpr std::array<double, 10> odd = {nan, inf, -inf, 1e300, -1e300, 1e160, 5e-324, -0.0, 1e7, 0.0};
  Random random(7);
  for (int k = 0; k < 50000; ++k) {
    State x = random_state(random, 3.0);
    std::array<Neighbour, 3> others;
    for (Neighbour& n : others) {
      n = {.p = position(x) + uniform(random, 0.3, 4) * test::any_direction(random, true)};
      if (k % 2 == 0) n.behavior = Behavior::cooperative;
    }
    VehicleInput u = uniform_array<4>(random, -1, 1);
    const auto any = [&] { return odd[random() % odd.size()]; };
    for (int i = 0; i < 2; ++i) {
      Neighbour& n = others[random() % 3];
      const std::array<double*, 11> fields = {&n.p.x,    &n.p.y, &n.p.z,       &n.v.x,   &n.v.y,
                                              &n.d_hard, &n.age, &n.speed_max, &n.sigma, &n.acceleration_max,
                                              &n.tie};
      switch (random() % 3) {
        case 0:
          *fields[random() % fields.size()] = any();
          break;
        case 1:
          x[random() % x.size()] = any();
          break;
        default:
          u[random() % u.size()] = any();
      }
    }
    filter.filter(x, others, lowest, highest, u);
    for (const double c : u) {
      EXPECT_GE(c, -1.0);
      EXPECT_LE(c, 1.0);
    }
  }
}

TEST(Barrier, TellsAConflictOfNumbersThatAreNone) {
  const Barrier filter = barrier();
  Neighbour n{.p = {3, not_a_number, 1}};
  VehicleInput u = {0.5, 0, 0, 0};
  EXPECT_TRUE(filter.filter(State{0, 0, 1, 1, 0, 0, 0}, std::span(&n, 1), lowest, highest, u).conflict);
  n.p.y = 0;
  EXPECT_FALSE(filter.filter(State{0, 0, 1, 1, 0, 0, 0}, std::span(&n, 1), lowest, highest, u).conflict);
  EXPECT_TRUE(
      filter.filter(State{0, 0, infinite, 1, 0, 0, 0}, std::span(&n, 1), lowest, highest, u).conflict);
}

TEST(Barrier, AllocatesNothing) {
  if (!cli::counts_allocations()) return;
  const Barrier filter = barrier({.floor = 0.3, .ceiling = 10, .world = 100});
  Random random(8);
  std::array<Neighbour, 16> others;
  for (int k = 0; k < 200; ++k) {
    const State x = random_state(random, 1.0);
    for (Neighbour& n : others) n = uncooperative_at(filter, x, 0.0, random);
    VehicleInput u = uniform_array<4>(random, -1, 1);
    const std::int64_t before = cli::allocations();
    filter.filter(x, others, lowest, highest, u);
    EXPECT_EQ(cli::allocations(), before);
  }
}

// Both filter, each knowing of the other what it measures; both are told to go for the other.
TEST(Barrier, TwoRobotsThatAreSentIntoEachOtherKeepTheirDistance) {
  const Barrier filter = barrier({.floor = 0.3, .world = 100.0});
  Random random(9);
  for (int k = 0; k < 40; ++k) {
    const test::Swarm swarm{
        .robots = 2,
        .nominal = k % 2 == 0 ? test::Swarm::Nominal::at_each_other : test::Swarm::Nominal::random,
        .head_on = k % 4 == 0,
        .duration = 8.0};
    const test::SwarmOutcome outcome = test::fly_swarm(filter, swarm, random());
    EXPECT_GE(outcome.nearest, swarm.d_hard);
    EXPECT_EQ(outcome.conflicts, 0);
  }
}

// The halves of a pair are of one sum: one robot flies any command, the other provides the rest.
TEST(Barrier, ProvidesWhatTheOtherRobotLacksOfTheirDistance) {
  const Barrier filter = barrier();
  Random random(6);
  const auto seen = [](const State& x, double tie) {
    return Neighbour{.p = position(x),
                     .v = {x[5] * x[3] - x[6] * x[4], x[5] * x[4] + x[6] * x[3], 0.0},
                     .d_hard = 0.6,
                     .tie = tie,
                     .behavior = Behavior::cooperative};
  };
  int provided = 0, missed = 0;
  for (int k = 0; k < 4000; ++k) {
    const State a = random_state(random, 1.0);
    State b = random_state(random, 1.0);
    const Vec3<double> direction = test::any_direction(random, true);
    const double wanted = uniform(random, 0.0, 0.1);
    double near = 0.1, far = 10.0;
    const auto set_distance = [&](double distance) {
      const Vec3<double> p = position(a) + distance * direction;
      b[0] = p.x, b[1] = p.y, b[2] = p.z;
      return filter.reserve(a, seen(b, 1.0));
    };
    for (int halving = 0; halving < 40; ++halving) {
      const double middle = 0.5 * (near + far);
      (set_distance(middle) < wanted ? near : far) = middle;
    }
    const double before = set_distance(far);
    const VehicleInput u_a = uniform_array<4>(random, -1, 1), u_wanted = uniform_array<4>(random, -1, 1);
    for (const bool provides : {true, false}) {
      Neighbour of_b = seen(a, -1.0);
      const double lacks = filter.lacked(a, seen(b, 1.0), lowest, highest, u_a);
      if (provides) of_b.lacks = lacks;
      VehicleInput u_b = u_wanted;
      if (filter.filter(b, std::span(&of_b, 1), lowest, highest, u_b).conflict) continue;
      State a_then = a, b_then = b;
      test::fly(Multirotor{}, a_then, u_a, control_period, [](const Vec3<double>&, double) {});
      test::fly(Multirotor{}, b_then, u_b, control_period, [](const Vec3<double>&, double) {});
      const double least = (1 - filter.options().rate * control_period) * before - 2e-3,
                   after = filter.reserve(a_then, seen(b_then, 1.0));
      if (!provides) {
        missed += after < least;
        continue;
      }
      EXPECT_GE(after, least) << "pair " << k;
      provided += lacks > 0;
    }
  }
  EXPECT_GT(provided, 400);
  EXPECT_GT(missed, 400);
}

TEST(Barrier, TwoRobotsInOnePlacePart) {
  const Barrier filter = barrier();
  std::array<State, 2> x = {State{0, 0, 1, 1, 0, 0, 0}, State{0, 0, 1, 1, 0, 0, 0}};
  for (int k = 0; k < 300; ++k) {
    std::array<VehicleInput, 2> u{};
    for (std::size_t i = 0; i < 2; ++i) {
      const Neighbour other{.p = position(x[1 - i]),
                            .v = {x[1 - i][5], x[1 - i][6], 0},
                            .d_hard = 0.6,
                            .tie = i == 0 ? 1.0 : -1.0,
                            .behavior = Behavior::cooperative};
      filter.filter(x[i], std::span(&other, 1), lowest, highest, u[i]);
    }
    for (std::size_t i = 0; i < 2; ++i)
      test::fly(Multirotor{}, x[i], u[i], control_period, [](const Vec3<double>&, double) {});
  }
  EXPECT_GE(norm(position(x[0]) - position(x[1])), 0.6);
}

TEST(Barrier, WithPartOfItsLimitsHeldForWindItKeepsTheDistanceFromFartherAway) {
  const Barrier barrier(Multirotor{}, lowest, highest, control_period);
  test::Duel duel{.start = 6.0, .duration = 10.0, .added = {0.3, -0.2, 0.1, 0.0}};
  for (const auto pursuit : {test::Pursuit::turns_each_half_second, test::Pursuit::aims_ahead}) {
    for (const bool spatial : {false, true}) {
      duel.pursuit = pursuit, duel.spatial = spatial;
      for (std::uint64_t seed = 0; seed < 25; ++seed)
        EXPECT_GE(test::duel(barrier, duel, seed).nearest, duel.d_hard) << "seed " << seed;
    }
  }
}

// A robot of px4's numbers flies at a pursuer that is as fast in height as in the plane, up, down
// and at random.
TEST(Barrier, KeepsTheDistanceAndTheFloorOfARobotThatClimbsAndTurnsLate) {
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    const Model px4{VelocityMultirotor{.frame = seed < 60 ? VelocityFrame::heading : VelocityFrame::level}};
    const Barrier late(px4, px4.u_min(), px4.u_max(), control_period, {.floor = 0.3});
    Random random(seed);
    std::vector<double> x(static_cast<std::size_t>(px4.nx())), u(4), wanted(4);
    const double psi = uniform(random, -3, 3);
    px4.at_rest({{0, 0, uniform(random, 0.4, 2.5)}, {std::cos(psi), std::sin(psi)}}, x.data());
    Neighbour other{.p = Vec3<double>{0, 0, x[2]} + 4.0 * test::any_direction(random, true),
                    .d_hard = 1.0,
                    .speed_max = 1.5};
    if (late.reserve(x, other) < 0) continue;
    Vec3<double> v{};
    double nearest = 1e9, lowest_height = 1e9;
    for (int k = 0; k < 1000; ++k) {
      const Vec3<double> p = {x[0], x[1], x[2]};
      if (k % (seed % 2 == 0 ? 50 : 1) == 0) {
        const Vec3<double> aim =
            p - other.p + (seed % 2 == 0 ? 0.8 : 0.0) * test::any_direction(random, true);
        v = (1.5 / std::max(norm(aim), 1e-9)) * aim;
      }
      if (k % 50 == 0) {
        for (std::size_t i = 0; i < 4; ++i) wanted[i] = uniform(random, -1, 1) * px4.u_max()[i];
        if (seed % 3 == 0) wanted[2] = -1.0;
        if (seed % 3 == 1) wanted[2] = other.p.z > p.z ? 1.0 : -1.0;
      }
      u = wanted;
      EXPECT_FALSE(late.filter(x, std::span(&other, 1), px4.u_min(), px4.u_max(), u).conflict)
          << seed << " at " << k;
      px4.step(x.data(), u.data(), control_period);
      (void)px4.normalise(x.data());
      other.p = other.p + control_period * v;
      nearest = std::min(nearest, norm(Vec3<double>{x[0], x[1], x[2]} - other.p));
      lowest_height = std::min(lowest_height, x[2]);
    }
    EXPECT_GE(nearest, 1.0) << seed;
    EXPECT_GE(lowest_height, 0.3 - 1e-6) << seed;
  }
}

TEST(Barrier, RefusesOptionsOutOfRange) {
  const auto said = [](const BarrierOptions& options) { return refusal_of([&] { barrier(options); }); };
  EXPECT_EQ(said({.floor = 1, .ceiling = 0.5}), "barrier: ceiling = 0.5, expected above the floor");
  EXPECT_EQ(said({.world = -1}), "barrier: world = -1, expected > 0 m");
  EXPECT_EQ(said({.margin = -0.1}), "barrier: margin = -0.1, expected >= 0 m");
  EXPECT_EQ(said({.rate = 200}), "barrier: rate = 200, expected in (0, 1 / dt] 1/s");
  EXPECT_EQ(said({.authority = 1.1}), "barrier: authority = 1.1, expected in (0, 1]");
  EXPECT_EQ(said({.share = 0}), "barrier: share = 0, expected in (0, 1]");
  EXPECT_EQ(said({.velocity_sigma = not_a_number}), "barrier: velocity_sigma = nan, expected >= 0 m/s");
  EXPECT_THAT(refusal_of([] { Barrier(test::Quadrotor{}, lowest, highest, control_period); }),
              testing::HasSubstr("expected a robot that can flee any way"));
}

}  // namespace
}  // namespace sightline
