#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sightline/base.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

/// x after `steps` steps over the time T.
template <class F>
std::vector<double> integrate(F f, std::vector<double> x, double T, int steps) {
  std::vector<double> rows(5 * x.size());
  for (int k = 0; k < steps; ++k) rk4_step(f, x, T / steps, {rows});
  return x;
}

TEST(Integrate, ACubicRateIsIntegratedExactly) {
  Random random(1);
  for (int k = 0; k < 500; ++k) {
    const auto c = uniform_array<4>(random, -2, 2);
    const double T = uniform(random, 0.1, 2.0);
    // x = (time, integral of c0 + c1 t + c2 t^2 + c3 t^3)
    const auto f = [&](std::span<const double> x, std::span<double> rate) {
      rate[0] = 1.0;
      rate[1] = c[0] + x[0] * (c[1] + x[0] * (c[2] + x[0] * c[3]));
    };
    const double exact = T * (c[0] + T * (c[1] / 2 + T * (c[2] / 3 + T * c[3] / 4)));
    EXPECT_LE(relative_error(integrate(f, {0.0, 0.0}, T, 1)[1], exact), 1e-14);
  }
}

TEST(Integrate, AStateOfAKnownLengthHasTheSameBits) {
  Random random(4);
  for (int k = 0; k < 500; ++k) {
    const auto x = uniform_array<3>(random, -2, 2);
    const double s = uniform(random, 0.001, 0.5);
    const auto rates = [](const auto& z) {
      return std::array<double, 3>{z[1] * z[2], -std::sin(z[0]), z[0] / 3 - z[2]};
    };
    const auto written = [&](std::span<const double> z, std::span<double> rate) {
      const auto r = rates(z);
      std::copy(r.begin(), r.end(), rate.begin());
    };
    const std::array<double, 3> after = rk4_step(rates, x, s);
    EXPECT_EQ(integrate(written, {x.begin(), x.end()}, s, 1), std::vector(after.begin(), after.end()));
  }
}

TEST(Integrate, ALinearStepIsTheExponentialToFourthOrder) {
  Random random(2);
  for (int k = 0; k < 500; ++k) {
    const double a = uniform(random, -3, 3), s = uniform(random, 0, 1), z = a * s;
    const auto f = [&](std::span<const double> x, std::span<double> rate) { rate[0] = a * x[0]; };
    const double series = 1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4)));
    EXPECT_LE(relative_error(integrate(f, {1.0}, s, 1)[0], series), 1e-14);
  }
}

TEST(Integrate, HalfTheStepLeavesASixteenthOfTheError) {
  const auto pendulum = [](std::span<const double> x, std::span<double> rate) {
    rate[0] = x[1];
    rate[1] = -std::sin(x[0]);
  };
  const double exact = integrate(pendulum, {1.0, 0.0}, 3.0, 4096)[0];
  const auto error = [&](int steps) {
    return std::fabs(integrate(pendulum, {1.0, 0.0}, 3.0, steps)[0] - exact);
  };
  for (const int steps : {32, 64, 128}) EXPECT_NEAR(error(steps) / error(2 * steps), 16.0, 2.0);
}

TEST(Integrate, EachComponentStandsForItself) {
  const auto f = [](std::span<const double> x, std::span<double> rate) {
    for (std::size_t i = 0; i < x.size(); ++i) rate[i] = x[i] * std::cos(x[i]);
  };
  Random random(3);
  std::vector<double> x(17);
  for (double& v : x) v = uniform(random, -2, 2);
  const auto together = integrate(f, x, 1.0, 4);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_EQ(together[i], integrate(f, {x[i]}, 1.0, 4)[0]);
}

}  // namespace
}  // namespace sightline
