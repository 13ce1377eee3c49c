#include "sightline/safety/authority.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "tests/support/adversary.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/robots.hpp"

namespace sightline {
namespace {

using test::highest;
using test::lowest;

/// A cart whose two commands accelerate it along the axes of G, whatever its heading.
struct CommandedCart {
  static constexpr int nx = 6, nu = 3;
  static constexpr std::string_view name = "cart";

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    return {x[2], x[3], 2.0 * u[0] - 0.4 * x[2], 1.2 * u[1] - 0.4 * x[3], -(x[5] * u[2]), x[4] * u[2]};
  }
  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], S(0.0)}, {x[4], x[5]}};
  }
  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, 0, 0, pose.d.x, pose.d.y};
  }
  static constexpr int heading_at = 4;
};

/// A point mass whose climb is braked by its cube.
struct DraggedClimb {
  static constexpr int nx = 6, nu = 3;
  static constexpr std::string_view name = "dragged_climb";

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    return {x[3], x[4], x[5], u[0] - x[3], u[1] - x[4], u[2] - x[5] - x[5] * x[5] * x[5]};
  }
  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {S(1.0), S(0.0)}};
  }
  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, 0, 0, 0};
  }
};

TEST(Authority, OfARobotThatClimbsLateIsItsLagAndWhereItTurnsLateNoCorner) {
  for (const VelocityFrame frame : {VelocityFrame::heading, VelocityFrame::level}) {
    const Model px4{VelocityMultirotor{.frame = frame}};
    const Authority a = authority_of(px4, px4.u_min(), px4.u_max());
    EXPECT_NEAR(a.climb_lag, 0.35, 1e-4);
    EXPECT_NEAR(a.climb, 1.0, 1e-3);
    EXPECT_TRUE(a.climbs);
    EXPECT_EQ(a.thrust_count, 0);
    EXPECT_GT(a.acceleration, 2.0);
  }
  const Model at_once{Multirotor{}};
  EXPECT_EQ(authority_of(at_once, at_once.u_min(), at_once.u_max()).climb_lag, 0.0);
}

TEST(Authority, OfTheMultirotorIsItsDragAndTheThrustOfOneAxis) {
  for (const Model& model : {Model(Multirotor{}), Model(AngleMultirotor{})}) {
    const Authority a = authority_of(model, lowest, highest);
    EXPECT_NEAR(a.drag, 0.5092, 1e-3);
    EXPECT_NEAR(a.acceleration, 1.458, 2e-3);
    EXPECT_TRUE(a.climbs);
    EXPECT_TRUE(a.turns);
    ASSERT_EQ(a.thrust_count, 2);
    EXPECT_NEAR(std::hypot(a.thrusts[0].x, a.thrusts[0].y), 1.458, 2e-3);
    EXPECT_NEAR(dot(a.thrusts[0], a.thrusts[1]), 0.0, 1e-6);
  }
}

TEST(Authority, FollowsTheLimitsOfTheInputs) {
  const std::array<double, 4> half = {0.5, 1, 1, 1}, minus = {-1, -1, -1, -1};
  EXPECT_NEAR(authority_of(Multirotor{}, minus, half).acceleration, 0.729, 2e-3);
}

TEST(Authority, OfNarrowerLimitsIsThePartThatTheLeastInputHasLeft) {
  const Authority a = authority_of(Multirotor{}, lowest, highest);
  const std::array<double, 4> less = {-1.3, -1, -1, -1}, more = {0.7, 1, 1, 1};
  EXPECT_EQ(a.part(lowest, highest), 1.0);
  EXPECT_NEAR(a.part(less, more), 0.7, 1e-6);
  EXPECT_NEAR(authority_of(Multirotor{}, std::array{-0.7, -1.0, -1.0, -1.0}, std::array{0.7, 1.0, 1.0, 1.0})
                  .acceleration,
              0.7 * a.acceleration, 2e-3);
  // Yaw neither pushes nor climbs.
  EXPECT_EQ(a.part(std::array{-1.0, -1.0, -1.0, -0.1}, highest), 1.0);
  EXPECT_EQ(a.part(std::array{-1.0, -1.0, 0.0, -1.0}, highest), 0.05);
}

TEST(Authority, OfThrustsInGDoesNotTurnWithTheHeading) {
  const Authority a = authority_of(CommandedCart{}, std::span(lowest).first(3), std::span(highest).first(3));
  EXPECT_FALSE(a.turns);
  EXPECT_FALSE(a.climbs);
  EXPECT_NEAR(a.drag, 0.4, 1e-3);
  EXPECT_NEAR(a.acceleration, 1.2, 2e-3);
  EXPECT_EQ(a.thrust_count, 2);
}

// Any model of the kind: with u the least command that gives it, v' is -c v + b m, at any speed and
// heading.
TEST(Authority, CanBeHadInEveryDirectionAtEverySpeed) {
  Random random(1);
  for (int k = 0; k < 50; ++k) {
    Multirotor robot;
    robot.b_f = uniform(random, 1.0, 2.0);
    robot.b_s = uniform(random, 1.0, 2.0);
    robot.a_f = uniform(random, -0.6, -0.45);
    robot.a_s = uniform(random, -0.6, -0.45);
    const Authority can = authority_of(robot, lowest, highest);
    for (int j = 0; j < 100; ++j) {
      const double heading = uniform(random, -3.2, 3.2), angle = uniform(random, -3.2, 3.2);
      const Vec2<double> d = {std::cos(heading), std::sin(heading)};
      const Vec2<double> v_V = {uniform(random, -1.5, 1.5), uniform(random, -1.5, 1.5)}, v = rotate(d, v_V);
      const Vec2<double> a = {-can.drag * v.x + can.acceleration * std::cos(angle),
                              -can.drag * v.y + can.acceleration * std::sin(angle)};
      const Vec2<double> a_V = rotate<double>({d.x, -d.y}, a);
      const double u_f = (a_V.x - robot.a_f * v_V.x) / robot.b_f;
      const double u_s = -(a_V.y - robot.a_s * v_V.y) / robot.b_s;
      EXPECT_LE(std::abs(u_f), 1.0 + 2e-3);
      EXPECT_LE(std::abs(u_s), 1.0 + 2e-3);
    }
  }
}

TEST(Authority, OfAMultirotorWhoseVelocityStaysInGWhileItYawsIsThatOfEquation24) {
  const HoverMultirotor hover;
  const Multirotor paper{hover.b_z, hover.b_psi, hover.a_f, hover.b_f, hover.a_s, hover.b_s};
  const Authority own = authority_of(hover, lowest, highest), known = authority_of(paper, lowest, highest);
  EXPECT_NEAR(own.climb, known.climb, 1e-6);
  EXPECT_NEAR(own.drag, known.drag, 1e-3);
  EXPECT_GE(own.acceleration, known.acceleration - 1e-3)
      << "the paper's has to hold its velocity up against the yaw";
}

TEST(Authority, RobotsMoveAlikeWhateverTheirStrengthAndLimitsButNotUnderOtherDrag) {
  const Authority usual = authority_of(Multirotor{}, lowest, highest);
  const std::array<double, 4> low = {-0.2, -0.2, -1, -1}, high = {0.2, 0.2, 1, 1};
  EXPECT_TRUE(moves_alike(usual, authority_of(Multirotor{}, low, high)));
  Authority other = usual;
  other.acceleration *= 2, other.push *= 3, other.rise *= 2;
  EXPECT_TRUE(moves_alike(usual, other));
  other.drag *= 1.001;
  EXPECT_FALSE(moves_alike(usual, other));
  EXPECT_FALSE(moves_alike(
      usual, authority_of(CommandedCart{}, std::span(lowest).first(3), std::span(highest).first(3))));
}

/// A unicycle whose turn rate lags, or whose drag is quadratic.
struct OddUnicycle {
  static constexpr int nx = 7, nu = 2;
  static constexpr std::string_view name = "odd_unicycle";
  bool lags = false, quadratic = false;

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const S rate = lags ? x[6] : 1.5 * u[1], v = x[5], drag = quadratic ? v * v * v : 2.5 * v;
    return {v * x[3],
            v * x[4],
            S(0.0),
            -(x[4] * rate),
            x[3] * rate,
            2.5 * u[0] - drag,
            5.0 * (1.5 * u[1] - x[6])};
  }
  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[3], x[4]}};
  }
  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, pose.d.x, pose.d.y, 0.0, 0.0};
  }
  static constexpr int heading_at = 3;
};

TEST(Authority, OfARobotThatDrivesAlongItsHeadingIsThatOfItsFormula) {
  Random random(9);
  for (int i = 0; i < 50; ++i) {
    const double c = uniform(random, 0.0, 4.0), b = uniform(random, 0.3, 5.0),
                 turn = uniform(random, 0.2, 4.0);
    const std::array<double, 2> low = {-uniform(random, 0.1, 2), -1}, high = {uniform(random, 0.1, 2), 1};
    const Authority can = authority_of(Unicycle{.b_psi = turn, .a_f = -c, .b_f = b}, low, high);
    EXPECT_TRUE(can.drives());
    EXPECT_EQ(can.drive, 0);
    EXPECT_NEAR(can.drag, c, 1e-3);
    EXPECT_NEAR(can.acceleration, b * std::min(-low[0], high[0]), 1e-3);
    EXPECT_GE(can.push, b * std::max(-low[0], high[0]) - 1e-3);
  }
  const Authority of_angle =
      authority_of(test::Unicycle{}, std::span(lowest).first(2), std::span(highest).first(2));
  EXPECT_TRUE(of_angle.drives());
  EXPECT_NEAR(of_angle.drag, 0.8, 1e-3);
  EXPECT_NEAR(of_angle.acceleration, 1.5, 1e-3);
  EXPECT_FALSE(authority_of(OmniRover{}, std::span(lowest).first(3), std::span(highest).first(3)).drives());
  EXPECT_FALSE(moves_alike(
      of_angle, authority_of(Unicycle{}, std::span(lowest).first(2), std::span(highest).first(2))));
}

TEST(Authority, IsRefusedWhereARobotCanNeitherFleeAnyWayNorBrakeAlongItsHeading) {
  const auto of_limits = [](const Model& model) {
    return refusal_of([&] { authority_of(model, model.u_min(), model.u_max()); });
  };
  const auto no_way = [](std::string_view name) {
    return fmt::format(
        "barrier: the commands of \"{}\" do not accelerate it in every horizontal direction at once, "
        "expected a "
        "robot that can flee any way, or one that drives along its heading",
        name);
  };
  EXPECT_EQ(refusal_of([] { authority_of(test::Quadrotor{}, lowest, highest); }), no_way("test_quadrotor"));
  EXPECT_EQ(of_limits(OddUnicycle{}), "");
  EXPECT_EQ(of_limits(OddUnicycle{.lags = true}), no_way("odd_unicycle"));
  EXPECT_EQ(of_limits(OddUnicycle{.quadratic = true}), no_way("odd_unicycle"));
  const std::array<double, 2> no_reverse = {0, -1};
  EXPECT_EQ(refusal_of([&] { authority_of(Unicycle{}, no_reverse, std::span(highest).first(2)); }),
            no_way("unicycle"));
  EXPECT_EQ(of_limits(LaggingHoverMultirotor{}), "");
  EXPECT_EQ(of_limits(DraggedClimb{}),
            "barrier: the height of \"dragged_climb\" follows its commands neither at once nor by one lag, "
            "expected a "
            "vertical velocity that is commanded");
  const std::array<double, 4> one_sided = {0, -1, -1, -1};
  EXPECT_THROW(authority_of(Multirotor{}, one_sided, highest), std::invalid_argument);
}

}  // namespace
}  // namespace sightline
