#include "sightline/safety/carry.hpp"

#include <gtest/gtest.h>

#include <array>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"

namespace sightline {
namespace {

TEST(Carry, UnderAConstantPushAPointGoesAsHalfItsSquareOfTime) {
  const Model point(PointMass{});
  const std::array<double, 3> none{};
  const InputHistory history(4, none);
  std::vector<double> x(static_cast<std::size_t>(point.nx())),
      rows(RungeKuttaScratch::rows_needed * x.size());
  point.at_rest({{1, 2, 3}, {1, 0}}, x.data());
  carry(point, x, history, 0, 0.0, 0.73, {2.0, -1.0, 0.5}, rows);
  const double s = 0.5 * 0.73 * 0.73;
  EXPECT_NEAR(x[0], 1 + 2 * s, 1e-12);
  EXPECT_NEAR(x[1], 2 - s, 1e-12);
  EXPECT_NEAR(x[2], 3 + 0.5 * s, 1e-12);
}

TEST(Carry, InTwoPartsIsWhatItIsInOne) {
  const Model robot(Multirotor{});
  std::array<double, 4> u{};
  InputHistory history(16, u);
  for (int k = 0; k < 10; ++k) {
    u = {0.1 * k, -0.5, 0.3, 0.8 - 0.1 * k};
    history.record(0.1 * k, u);
  }
  std::vector<double> whole = {0, 0, 1, 0.6, 0.8, 0.2, 0.1}, parts = whole,
                      rows(RungeKuttaScratch::rows_needed * whole.size());
  const auto last = carry(robot, whole, history, 0, 0.05, 0.95, {0.5, 0, 0}, rows);
  ASSERT_EQ(last.size(), u.size());
  EXPECT_EQ(last[0], u[0]);
  carry(robot, parts, history, 0, 0.05, 0.4, {0.5, 0, 0}, rows);
  carry(robot, parts, history, 0, 0.4, 0.95, {0.5, 0, 0}, rows);
  for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_NEAR(whole[i], parts[i], 1e-12);
  // No time is no step.
  const std::vector<double> before = parts;
  EXPECT_TRUE(carry(robot, parts, history, 0, 0.5, 0.5, {}, rows).empty());
  EXPECT_EQ(parts, before);
}

}  // namespace
}  // namespace sightline
