#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "sightline/supervisor.hpp"
#include "sightline/world.hpp"
#include "tests/support/adversary.hpp"

namespace sightline {
namespace {

using test::highest;
using test::lowest;
using Numbers = std::vector<double>;

const Numbers rest(4, 0.0);

// Flies under the brake for some seconds, at 100 Hz.
Sight<double> braked(const Model& model, Numbers x, const Vec3<double>& velocity, double seconds) {
  Brake brake(model, Numbers(static_cast<std::size_t>(model.nu()), 0.0), 0.4);
  Numbers u(static_cast<std::size_t>(model.nu()), 9.0), scratch(5 * x.size());
  for (int k = 0; k < std::lround(seconds / 0.01); ++k) {
    brake(x, velocity, lowest, highest, u);
    for (const double value : u) EXPECT_LE(std::abs(value), 1.0);
    rk4_step([&](auto z, auto rate) { model.f(z.data(), u.data(), rate.data()); }, x, 0.01, {scratch});
    EXPECT_TRUE(model.normalise(x.data()));
  }
  return model.sight(x.data(), u.data());
}

Numbers random_state(RandomStream& chance) {
  const auto draw = [&] { return 2.0 * chance.uniform() - 1.0; };
  const double psi = 3.1 * draw();
  return {5 * draw(), 5 * draw(), 5 * draw(), std::cos(psi), std::sin(psi), 2 * draw(), 2 * draw()};
}

TEST(Brake, FromAnyStateTheVelocityBecomesTheWantedOne) {
  RandomStream chance(3, StreamId::gust, 0);
  for (int trial = 0; trial < 300; ++trial) {
    const Numbers x = random_state(chance);
    for (const Vec3<double>& wanted :
         {Vec3<double>{}, Vec3<double>{0, 0, -0.3}, Vec3<double>{0.4, -0.2, 0.1}}) {
      const Sight<double> sight = braked(Multirotor{}, x, wanted, 5.0);
      ASSERT_LT(norm(sight.v - wanted), 1e-3);
    }
  }
}

TEST(Brake, HoldsTheSameWhateverTheModelCallsItsHeading) {
  RandomStream chance(4, StreamId::gust, 0);
  for (int trial = 0; trial < 50; ++trial) {
    const Numbers x = random_state(chance);
    const Numbers angle = {x[0], x[1], x[2], std::atan2(x[4], x[3]), x[5], x[6]};
    const Sight<double> a = braked(Multirotor{}, x, {}, 2.0), b = braked(AngleMultirotor{}, angle, {}, 2.0);
    ASSERT_LT(norm(a.p - b.p), 1e-6);
    ASSERT_LT(norm(a.v - b.v), 1e-6);
  }
}

TEST(Brake, DoesNotTurn) {
  const Numbers x = {0, 0, 1, 0.6, 0.8, 1.0, -1.0};
  const Sight<double> sight = braked(Multirotor{}, x, {}, 3.0);
  EXPECT_NEAR(sight.d.x, 0.6, 1e-9);
  EXPECT_NEAR(sight.d.y, 0.8, 1e-9);
}

// Rolls forward and turns; cannot climb.
struct RollingCart {
  static constexpr int nx = 4, nu = 2;
  static constexpr std::string_view name = "cart";
  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    return {x[2] * u[0], x[3] * u[0], -(x[3] * u[1]), x[2] * u[1]};
  }
  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], S(0.0)}, {x[2], x[3]}};
  }
  std::array<double, nx> at_rest(const Pose<double>& p) const { return {p.p.x, p.p.y, p.d.x, p.d.y}; }
  static constexpr int heading_at = 2;
};

TEST(Brake, ARobotOnTheGroundThatIsToLandStands) {
  Brake brake(RollingCart{}, Numbers(2, 0.0), 0.4);
  Numbers u = {1.0, 1.0};
  brake(Numbers{1, 2, 0.8, 0.6}, {0, 0, -0.3}, Numbers(2, -1.0), Numbers(2, 1.0), u);
  EXPECT_NEAR(u[0], 0.0, 1e-6);
  EXPECT_NEAR(u[1], 0.0, 1e-6);
}

TEST(Brake, StatesThatAreNotFiniteGiveTheInputAtRest) {
  Brake brake(Multirotor{}, rest, 0.4);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e300}) {
    for (std::size_t i = 0; i < 7; ++i) {
      Numbers x = {0, 0, 1, 1, 0, 0, 0}, u(4, NAN);
      x[i] = bad;
      brake(x, {}, lowest, highest, u);
      for (const double value : u) ASSERT_LE(std::abs(value), 1.0) << i << " " << bad;
    }
  }
}

}  // namespace
}  // namespace sightline
