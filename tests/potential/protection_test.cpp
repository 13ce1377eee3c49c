#include "sightline/potential/protection.hpp"

#include <gtest/gtest.h>

#include "sightline/potentials.hpp"

namespace sightline {
namespace {

// A keep-out that somebody else wrote.
struct Ellipsoid {
  static constexpr std::string_view name = "ellipsoid";
  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    const Vec3<S> r = a.p - b.p;
    return 1.0 / (1.0 + dot(r, r));
  }
  double violation(const Sight<double>& a, const Sight<double>& b) const {
    const Vec3<double> r = a.p - b.p;
    return 1.0 - (r.x * r.x + r.y * r.y + 0.25 * r.z * r.z);
  }
};

struct ProtectionCase {
  Potential potential;
  bool keeps_apart, observes;
  std::size_t keep_outs;
};

std::vector<ProtectionCase> cases() {
  const SensorMount level{.pitch = 0.0, .offset = 0.0};
  return {
      {KeepOut{}, true, false, 1},
      {TooNear{.d_min = 0.2}, true, false, 1},
      {PassRight{.d_min = 1.0, .delta = 0.9}, true, false, 1},
      {Ellipsoid{}, true, false, 1},
      {Region("range > 1 m"), true, false, 1},
      {Region("range > 0.1 m"), true, false, 1},  // from the sensor, 0.17 m before the middle
      {Region("range > 0.1 m").seen_from(level), true, false, 1},
      {Region("distance > 1.2 m").slope(Softplus{}), true, false, 1},
      {Region("hypot(r_x, r_y) > 0.8 m"), true, false, 1},
      {Region(any_of({"distance > 1 m", "abs(r_z) > 0.5 m"})), true, false, 1},
      {Region(!Limits("distance < 1 m")), true, false, 1},
      {Region("distance > 0.5 m + 0.5 s * norm(target.v_x, target.v_y)"), true, false, 1},
      {Region("0.5 m < range < 4 m"), false, true, 1},
      {Region(all_of({"bearing < 0.4", "0.3 m < range < 6 m"})), false, true, 1},
      {Region(all_of({"range < 6 m", all_of({"distance > 1 m", "hypot(r_x, r_y) > 0.5 m"})})), false, true,
       2},
      {Region(any_of({"bearing < 0.4", "range < 1 m"})), false, true, 0},
      {Region("range < 4 m"), false, true, 0},
      {Region("distance < 4 m"), false, false, 0},
      {Region("r_z > 1 m"), false, false, 0},
      {Region("target.p_z > 0.5 m"), false, false, 0},
      {SensorCone{}, false, true, 0},
      {Bearing{}, false, true, 0},
      {Cohesion{}, false, false, 0},
      {TooFar{}, false, false, 0},
      {RelativeVelocity{}, false, false, 0},
  };
}

TEST(Protection, IsAskedOfTheLimitWhateverTheKind) {
  int i = 0;
  for (const ProtectionCase& each : cases()) {
    SCOPED_TRACE(i++);
    EXPECT_EQ(keeps_apart(each.potential), each.keeps_apart) << each.potential.name();
    EXPECT_EQ(observes(each.potential), each.observes) << each.potential.name();
    EXPECT_EQ(keep_outs(each.potential).size(), each.keep_outs) << each.potential.name();
  }
}

TEST(Protection, WhatIsTakenOutOfARegionIsItsLimitAlone) {
  const Potential camera = Region(all_of({"bearing < 0.4", "0.3 m < range < 6 m"}));
  const std::vector<Potential> parts = keep_outs(camera);
  ASSERT_EQ(parts.size(), 1U);
  const auto at = [](double D) {
    Sight<double> target;
    target.p = {0.17 + D, 0.0, 0.0};
    return target;
  };
  Sight<double> observer;
  observer.d = {1.0, 0.0};
  EXPECT_NEAR(parts[0].violation(observer, at(0.1)), 0.2, 1e-9);
  EXPECT_NEAR(parts[0].violation(observer, at(9.0)), -8.7, 1e-9);
}

}  // namespace
}  // namespace sightline
