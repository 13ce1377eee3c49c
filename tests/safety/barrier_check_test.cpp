// The guarantee of docs/safety.md at periods from 1 ms to the longest, against bodies and robots
// that do their worst.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sightline/barrier.hpp"
#include "sightline/robots.hpp"
#include "tests/support/adversary.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

/// Flights at any period of commands of any robot that a barrier accepts, against bodies that turn
/// at will; and of two robots that meet. Distances are taken every 5 ms at least; whoever flies
/// here starts at the edge of what is safe.
namespace sightline::test {
namespace {

/// The rate that a scenario of this period gets.
Barrier barrier_of(const Model& model, double period, BarrierOptions options = {}) {
  options.rate = std::min(options.rate, 1.0 / period);
  return Barrier(model, model.u_min(), model.u_max(), period, options);
}

struct ChaseOutcome {
  bool began = false;                                        ///< within the guarantee
  double spare = std::numeric_limits<double>::infinity();    ///< least distance less d_hard, at any time [m]
  double lowest = std::numeric_limits<double>::infinity();   ///< least height [m]
  double farthest = 0.0;                                     ///< greatest |p_x| and |p_y| [m]
  double reserve = std::numeric_limits<double>::infinity();  ///< least [m]
  int conflicts = 0;
};

/// A robot under commands that do their worst.
class Chased {
 public:
  Chased(const Model& robot, const Barrier& filter, double period, double speed, double height,
         Random& random)
      : model(robot),
        barrier(filter),
        x(static_cast<std::size_t>(robot.nx())),
        u(static_cast<std::size_t>(robot.nu())),
        wanted_(u.size()),
        period_(period),
        kind_(static_cast<int>(random() % 4)),
        hold_(1 + static_cast<int>(random() % 20)) {
    const double psi = uniform(random, -std::numbers::pi, std::numbers::pi);
    model.at_rest({{0, 0, height}, {std::cos(psi), std::sin(psi)}}, x.data());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::string_view state = model.states()[i];
      if (state == "v_f" || state == "v_s") x[i] = uniform(random, -speed, speed);
    }
  }

  Sight<double> sight() const { return model.sight(x.data(), u.data()); }
  /// Straight at a point, the same while it spins, at random, or from limit to limit.
  BarrierResult command(const Vec3<double>& goal, std::span<const Neighbour> neighbours, Random& random) {
    const auto low = model.u_min(), high = model.u_max();
    if (kind_ < 2) {
      const Sight<double> self = sight();
      const Vec3<double> r = goal - self.p;
      const Vec2<double> r_V = rotate<double>({self.d.x, -self.d.y}, {r.x, r.y});
      const double length = std::max({std::abs(r_V.x), std::abs(r_V.y), std::abs(r.z), 1e-9});
      const double left = model.name() == "velocity_multirotor" ? 1.0 : -1.0;  // u_s > 0
      const std::array<double, 4> straight = {r_V.x / length, left * r_V.y / length, r.z / length,
                                              kind_ == 0                ? 0.0
                                              : turns_ / hold_ % 2 == 0 ? 1.0
                                                                        : -1.0};
      for (std::size_t i = 0; i < u.size(); ++i) wanted_[i] = straight[i] * high[i];
    } else if (turns_ % hold_ == 0) {
      for (std::size_t i = 0; i < u.size(); ++i)
        wanted_[i] = kind_ == 2 ? uniform(random, low[i], high[i]) : random() % 2 == 0 ? low[i] : high[i];
    }
    ++turns_;
    u = wanted_;
    return barrier.filter(x, neighbours, low, high, u, maneuver_);
  }
  void fly(double time) {
    model.step(x.data(), u.data(), time);
    (void)model.normalise(x.data());
  }
  int parts() const { return std::max(8, static_cast<int>(period_ / 0.005)); }

  const Model& model;
  const Barrier& barrier;
  std::vector<double> x, u;

 private:
  std::vector<double> wanted_;
  double period_;
  int kind_, hold_, turns_ = 0;
  EvasiveManeuver maneuver_{};
};

/// How far apart, along a direction, a reserve is `wanted` [m].
template <class ReserveAt>
double distance_of(double wanted, const ReserveAt& reserve_at) {
  double near = 0.1, far = 60.0;
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (near + far);
    (reserve_at(middle) < wanted ? near : far) = middle;
  }
  return far;
}

struct Chase {
  double period = 0.01, speed_max = 1.5, duration = 6.0;
  int bodies = 1;
};

ChaseOutcome chase(const Model& model, const Barrier& barrier, const Chase& c, std::uint64_t seed) {
  Random random(seed);
  ChaseOutcome outcome;
  Chased robot(model, barrier, c.period, uniform(random, 0.0, 2.5), uniform(random, 0.5, 3.0), random);
  const Vec3<double> start = robot.sight().p;
  const double d_hard = uniform(random, 0.3, 1.2), wanted = random() % 2 == 0 ? 0.0 : uniform(random, 0, 0.3);
  std::vector<Neighbour> bodies(static_cast<std::size_t>(c.bodies));
  for (Neighbour& body : bodies) {
    body.d_hard = d_hard;
    body.speed_max = c.speed_max * (random() % 2 == 0 ? 1.0 : uniform(random, 0, 1));
    const Vec3<double> direction = any_direction(random, random() % 3 != 0);
    const double far = distance_of(wanted, [&](double distance) {
      body.p = start + distance * direction;
      return barrier.reserve(robot.x, body);
    });
    body.p = start + (far + (c.bodies > 1 ? uniform(random, 0, 1) : 0.0)) * direction;
    outcome.began = outcome.began || norm(body.p - start) > 9.0;  // from beyond the reach of one plan
  }
  if (c.bodies > 1 && outcome.began) return {};
  const int pursuit = static_cast<int>(random() % 3), hold = 1 + static_cast<int>(random() % 12);
  std::vector<Vec3<double>> v(bodies.size());
  for (int k = 0; k < static_cast<int>(c.duration / c.period); ++k) {
    const auto farther = [&](const Neighbour& a, const Neighbour& b) {
      return norm(a.p - robot.sight().p) < norm(b.p - robot.sight().p);
    };
    const Vec3<double> goal = std::min_element(bodies.begin(), bodies.end(), farther)->p;
    const BarrierResult result = robot.command(goal, bodies, random);
    if (k == 0) outcome.began = result.reserve >= 0 && !result.surrounded;
    if (!outcome.began) return {};
    outcome.reserve = std::min(outcome.reserve, result.reserve);
    outcome.conflicts += result.conflict;
    for (int part = 0; part < robot.parts(); ++part) {
      const Sight<double> seen = robot.sight();
      const double time = c.period / robot.parts();
      for (std::size_t j = 0; j < bodies.size(); ++j) {
        Neighbour& body = bodies[j];
        if (pursuit == 2 || (part == 0 && k % hold == 0)) {
          Vec3<double> aim = seen.p - body.p;
          if (pursuit == 1) aim = aim + (norm(aim) / std::max(body.speed_max, 0.1)) * seen.v;
          const double stray = pursuit == 2 ? 0.0 : 0.8 * uniform(random, 0, 1);
          const Vec3<double> along =
              (1 / std::max(norm(aim), 1e-9)) * aim + stray * any_direction(random, true);
          const double part_of_speed = random() % 6 == 0 ? uniform(random, 0, 1) : 1.0;
          v[j] = (part_of_speed * body.speed_max / std::max(norm(along), 1e-9)) * along;
        }
        body.p = body.p + time * v[j];
      }
      robot.fly(time);
      const Vec3<double> p = robot.sight().p;
      for (const Neighbour& body : bodies)
        outcome.spare = std::min(outcome.spare, norm(p - body.p) - body.d_hard);
      outcome.lowest = std::min(outcome.lowest, p.z);
      outcome.farthest = std::max({outcome.farthest, std::abs(p.x), std::abs(p.y)});
    }
  }
  return outcome;
}

/// Two cooperative robots, whose drag is the same, and whose accelerations need not be.
ChaseOutcome meet(const std::array<const Model*, 2>& models, const std::array<const Barrier*, 2>& barriers,
                  double period, std::uint64_t seed) {
  Random random(seed);
  ChaseOutcome outcome;
  const double d_hard = uniform(random, 0.3, 1.2), height = uniform(random, 0.5, 3.0),
               other_height = std::max(0.31, height + (random() % 2 == 0 ? 0.0 : uniform(random, -0.5, 0.5))),
               wanted = random() % 2 == 0 ? 0.0 : uniform(random, 0, 0.3);
  std::array<Chased, 2> robots = {
      Chased(*models[0], *barriers[0], period, uniform(random, 0, 2.5), height, random),
      Chased(*models[1], *barriers[1], period, uniform(random, 0, 2.5), other_height, random)};
  const auto neighbour = [&](std::size_t i) {
    const Sight<double> other = robots[1 - i].sight();
    return Neighbour{.p = other.p,
                     .v = other.v,
                     .d_hard = d_hard,
                     .part = barriers[1 - i]->acceleration() / barriers[i]->acceleration(),
                     .tie = i == 0 ? 1.0 : -1.0,
                     .behavior = Behavior::cooperative};
  };
  const double angle = uniform(random, -std::numbers::pi, std::numbers::pi);
  const auto reserve_at = [&](double distance) {
    robots[1].x[0] = distance * std::cos(angle), robots[1].x[1] = distance * std::sin(angle);
    return barriers[0]->reserve(robots[0].x, neighbour(0));
  };
  reserve_at(distance_of(wanted, reserve_at));
  for (int k = 0; k < static_cast<int>(6.0 / period); ++k) {
    const std::array<Neighbour, 2> others = {neighbour(0), neighbour(1)};
    for (std::size_t i = 0; i < 2; ++i) {
      const BarrierResult result = robots[i].command(others[i].p, std::span(&others[i], 1), random);
      if (k == 0 && i == 0) outcome.began = result.reserve >= 0;
      outcome.reserve = std::min(outcome.reserve, result.reserve);
      outcome.conflicts += result.conflict;
    }
    for (int part = 0; part < robots[0].parts(); ++part) {
      for (Chased& robot : robots) robot.fly(period / robots[0].parts());
      outcome.spare = std::min(outcome.spare, norm(robots[0].sight().p - robots[1].sight().p) - d_hard);
    }
  }
  return outcome;
}

}  // namespace
}  // namespace sightline::test

namespace sightline {
namespace {

using test::barrier_of;
using test::ChaseOutcome;

/// From 1 ms to the longest, as many of each factor of ten.
double any_period(Random& random) {
  return std::min(Barrier::longest_period, std::pow(10.0, uniform(random, -3.0, -0.3)));
}

/// Robots whose plans are exact.
Model any_robot(Random& random) {
  switch (random() % 5) {
    case 0:
      return HoverMultirotor{};
    case 1:
      return AngleMultirotor{};
    case 2:
      return LaggedMultirotor<Lags::climb>{.yaw_max = 0.3};
    case 3: {
      const double drag = uniform(random, 0.35, 0.55), b = uniform(random, 1.4, 3.0);
      return Multirotor{.b_psi = uniform(random, 0.5, 2.0), .a_f = -drag, .b_f = b, .a_s = -drag, .b_s = b};
    }
    default:
      return Multirotor{};
  }
}

int flights(int whole) { return runs(whole, 40); }

TEST(BarrierCheck, OneBodyIsKeptAwayAtEveryPeriodUpToTheLongest) {
  int flown = 0;
  for (int i = 0; i < flights(20000); ++i) {
    Random random(static_cast<std::uint64_t>(i));
    // Short periods take as many updates more.
    const double period = i % 8 == 0 ? any_period(random) : uniform(random, 0.02, Barrier::longest_period);
    const Model robot = any_robot(random);
    const Barrier barrier = barrier_of(robot, period, {.floor = 0.3, .world = 1000.0});
    const ChaseOutcome outcome =
        test::chase(robot, barrier, {.period = period}, static_cast<std::uint64_t>(i) + 1);
    if (!outcome.began) continue;
    ++flown;
    EXPECT_GE(outcome.spare, 0.0) << robot.name() << " at " << period << " s, seed " << i;
    EXPECT_GE(outcome.lowest, 0.3 - 1e-6) << robot.name() << " at " << period << " s, seed " << i;
    EXPECT_GE(outcome.reserve, -2e-3) << robot.name() << " at " << period << " s, seed " << i;
    EXPECT_EQ(outcome.conflicts, 0) << robot.name() << " at " << period << " s, seed " << i;
  }
  EXPECT_GT(flown, flights(20000) * 9 / 10);
}

TEST(BarrierCheck, SeveralBodiesAreKeptAwayAtEveryPeriodUpToTheLongest) {
  int flown = 0;
  for (int i = 0; i < flights(8000); ++i) {
    Random random(static_cast<std::uint64_t>(i));
    const double period = uniform(random, 0.02, Barrier::longest_period);
    const Model robot = i % 2 == 0 ? Model(Multirotor{}) : Model(AngleMultirotor{});
    const Barrier barrier = barrier_of(robot, period, {.floor = 0.3, .world = 1000.0});
    const ChaseOutcome outcome = test::chase(robot, barrier, {.period = period, .bodies = 2 + i % 3},
                                             static_cast<std::uint64_t>(i) + 1);
    flown += outcome.began;
    EXPECT_TRUE(!outcome.began || outcome.spare >= 0.0)
        << outcome.spare << " m at " << period << " s, seed " << i;
  }
  EXPECT_GT(flown, flights(8000) / 2);
}

TEST(BarrierCheck, TwoRobotsKeepApartAtEveryPeriodAlsoWhereOneIsStronger) {
  for (int i = 0; i < flights(20000); ++i) {
    Random random(static_cast<std::uint64_t>(i));
    const double period = i % 8 == 0 ? any_period(random) : uniform(random, 0.02, Barrier::longest_period);
    const double b = i % 2 == 0 ? 1.458 : uniform(random, 1.0, 3.0);
    const Model one = Multirotor{},
                other = i % 3 == 0 ? Model(AngleMultirotor{}) : Model(Multirotor{.b_f = b, .b_s = b});
    const BarrierOptions walls{.floor = 0.3, .world = 1000.0};
    const Barrier first = barrier_of(one, period, walls), second = barrier_of(other, period, walls);
    const ChaseOutcome outcome =
        test::meet({&one, &other}, {&first, &second}, period, static_cast<std::uint64_t>(i) + 1);
    EXPECT_GE(outcome.spare, 0.0) << "at " << period << " s, seed " << i;
    EXPECT_EQ(outcome.conflicts, 0) << "at " << period << " s, seed " << i;
  }
}

TEST(BarrierCheck, FloorCeilingAndABoundOfTheWorldAreKeptBetweenSamplesAtEveryPeriod) {
  for (int i = 0; i < flights(4000); ++i) {
    Random random(static_cast<std::uint64_t>(i));
    const double period = uniform(random, 0.01, Barrier::longest_period);
    const Model robot = any_robot(random);
    const Barrier barrier = barrier_of(robot, period, {.floor = 0.3, .ceiling = 3.0, .world = 6.0});
    test::Chased flown(robot, barrier, period, 0.0, uniform(random, 0.5, 2.5), random);
    for (int k = 0; k < static_cast<int>(12.0 / period); ++k) {
      // At a bound, up and down; never into a corner of two.
      const Vec3<double> p = flown.sight().p;
      flown.command({i % 2 == 0 ? 50.0 : -50.0, 0.0, k / 20 % 2 == 0 ? 9.0 : -9.0}, {}, random);
      if (std::abs(p.y) > 2.0) break;
      for (int part = 0; part < flown.parts(); ++part) {
        flown.fly(period / flown.parts());
        const Vec3<double> now = flown.sight().p;
        ASSERT_GE(now.z, 0.3 - 1e-6) << robot.name() << " at " << period << " s, seed " << i;
        ASSERT_LE(now.z, 3.0 + 1e-6) << robot.name() << " at " << period << " s, seed " << i;
        ASSERT_LE(std::abs(now.x), 6.0 + 1e-6) << robot.name() << " at " << period << " s, seed " << i;
      }
    }
  }
}

TEST(BarrierCheck, ALongerPeriodIsRefusedWithTheLongest) {
  EXPECT_EQ(refusal_of([] { Barrier(Multirotor{}, test::lowest, test::highest, 0.6, {.rate = 1.0}); }),
            "barrier: period = 0.6, expected in (0, 0.5] s, the longest for which the hard distance is "
            "guaranteed");
}

}  // namespace
}  // namespace sightline
