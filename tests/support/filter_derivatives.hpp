/// The linear parts of a filter of poses against central differences of its nonlinear ones.
#pragma once

#include <gtest/gtest.h>

#include "sightline/estimate/attitude_filter.hpp"
#include "sightline/estimate/heading_filter.hpp"
#include "tests/support/random.hpp"

namespace sightline::test {

/// b less a, as the error state has it; for small turns between the two.
template <class State>
auto difference(const State& a, const State& b) {
  constexpr int n = decltype(State::P)::rows;
  Column<n> e;
  set_block(e, 0, 0, column(b.p - a.p));
  if constexpr (requires { a.psi; }) {
    e(3, 0) = wrap(b.psi - a.psi);
    set_block(e, 4, 0, column(b.velocity_bias - a.velocity_bias));
    e(7, 0) = b.rate_bias - a.rate_bias;
    e(8, 0) = b.tilt_error.x - a.tilt_error.x, e(9, 0) = b.tilt_error.y - a.tilt_error.y;
    for (std::size_t i = 0; i < a.other_error.size(); ++i)
      set_block(e, 10, 0, b.other_error[i] - a.other_error[i]);
  } else {
    const Mat<3, 3> D = transposed(a.R) * b.R;
    set_block(e, 3, 0, column(b.v - a.v));
    set_block(e, 6, 0,
              column({0.5 * (D(2, 1) - D(1, 2)), 0.5 * (D(0, 2) - D(2, 0)), 0.5 * (D(1, 0) - D(0, 1))}));
    set_block(e, 9, 0, column(b.force_bias - a.force_bias));
    set_block(e, 12, 0, column(b.gyro_bias - a.gyro_bias));
    set_block(e, 15, 0, column(b.velocity_bias - a.velocity_bias));
    set_block(e, 18, 0, column(b.camera_turn - a.camera_turn));
  }
  const int sources = static_cast<int>(a.errors.x.size());
  for (int k = 0; k < sources; ++k) {
    const auto i = static_cast<std::size_t>(k);
    set_block(e, n - 4 * (sources - k), 0, b.errors.x[i] - a.errors.x[i]);
  }
  return e;
}

inline MotionSample random_motion(Random& random) {
  return {.t = 1.0,
          .dt = 0.01,
          .v_V = random_point(random, 1),
          .yaw_rate = uniform(random, -1, 1),
          .roll = uniform(random, -0.3, 0.3),
          .pitch = uniform(random, -0.3, 0.3),
          .gyro = random_point(random, 1),
          .force = random_point(random, 2) + Vec3<double>{0, 0, gravity}};
}

inline Measurement random_sighting(Random& random) {
  Measurement z{.stamp = 1.004, .z = random_point(random, 2), .has_yaw = true, .yaw = uniform(random, -3, 3)};
  const Vec3<double> a = random_point(random, 0.1), b = random_point(random, 0.1);
  z.R = identity<3>(0.01) + outer(a, a);
  z.yaw_variance = 0.01;
  z.R_yaw = {0.001, -0.002, 0.003};
  z.p_other = random_point(random, 3), z.psi_other = uniform(random, -3, 3);
  z.P_other = identity<4>(1e-3);
  set_block(z.P_other, 0, 0, identity<3>(1e-3) + outer(b, b));
  return z;
}

/// Some state with a covariance of full rank; it has received a sighting.
template <class Filter>
typename Filter::State random_state(const Filter& filter, Random& random) {
  typename Filter::State s =
      filter.begin(random_point(random, 2), uniform(random, -3, 3), identity<4>(), random_motion(random));
  filter.receive(s, {});
  Column<Filter::n> e;
  for (int i = 0; i < Filter::n; ++i) e(i, 0) = uniform(random, -0.2, 0.2);
  filter.correct(s, e);
  Mat<Filter::n, Filter::n> B;
  for (auto& row : B.row)
    for (double& v : row) v = uniform(random, -0.1, 0.1);
  s.P = B * transposed(B) + identity<Filter::n>(1e-3);
  return s;
}

/// The state that is off by h in one component of the error state.
template <class Filter>
typename Filter::State moved(const Filter& filter, typename Filter::State s, int i, double h) {
  Column<Filter::n> e;
  e(i, 0) = h;
  filter.correct(s, e);
  return s;
}

template <int r, int c>
double greatest(const Mat<r, c>& a) {
  double most = 0.0;
  for (const auto& row : a.row)
    for (const double v : row) most = std::max(most, std::abs(v));
  return most;
}

/// The covariance after a step is F P F^T + Q, F by central differences of the state's own step.
template <class Filter>
void expect_propagation(const Filter& filter, double tolerance) {
  constexpr int n = Filter::n;
  constexpr double h = 1e-5, dt = 0.01;
  Random random(11);
  for (int k = 0; k < 30; ++k) {
    const auto s = random_state(filter, random);
    const MotionSample u = random_motion(random);
    const auto advanced = [&](typename Filter::State x) {
      filter.advance(x, u, dt);
      return x;
    };
    Mat<n, n> F;
    for (int i = 0; i < n; ++i) {
      const auto e = difference(advanced(moved(filter, s, i, -h)), advanced(moved(filter, s, i, h)));
      set_block(F, 0, i, (0.5 / h) * e);
    }
    auto certain = s;
    certain.P = {};
    const Mat<n, n> expected = F * s.P * transposed(F) + advanced(certain).P;
    EXPECT_LE(greatest(advanced(s).P - expected), tolerance);
  }
}

/// An innovation changes with the state as H says, at fixed R.
template <class Filter>
void expect_sensitivity(const Filter& filter, double tolerance) {
  constexpr int n = Filter::n;
  constexpr double h = 1e-6;
  Random random(12);
  for (int k = 0; k < 60; ++k) {
    auto s = random_state(filter, random);
    if constexpr (requires { s.camera_turn; }) s.camera_turn = {};  // derivative at a small turn
    const MotionSample u = random_motion(random);
    Measurement z = random_sighting(random);
    if (k % 3 == 1) z.of = Measures::position;
    if (k % 3 == 2) z.of = Measures::heading;
    const Innovation<4, n> of = filter.innovation(s, z, u);
    for (int i = 0; i < n; ++i) {
      const auto before = filter.innovation(moved(filter, s, i, -h), z, u);
      const auto after = filter.innovation(moved(filter, s, i, h), z, u);
      for (int a = z.measures_position() ? 0 : 3; a < (z.measures_heading() ? 4 : 3); ++a) {
        const double y = after.y(a, 0) - before.y(a, 0);
        EXPECT_NEAR(-(a == 3 ? wrap(y) : y) / (2 * h), of.H(a, i), tolerance) << a << " by " << i;
      }
    }
  }
}

}  // namespace sightline::test
