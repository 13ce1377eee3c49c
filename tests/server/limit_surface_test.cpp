#include "sightline/server/limit_surface.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "sightline/potentials.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

Region camera() {
  return Region(all_of({"abs(azimuth) < 30 deg", "abs(z) < x * tan(22.5 deg)", "0.5 m < range < 4 m"}));
}
Region box() { return Region(any_of({"abs(r_x) > 1 m", "abs(r_y) > 0.5 m", "abs(r_z) > 0.25 m"})); }

/// The two bodies for a corner.
std::pair<Sight<double>, Sight<double>> bodies_at(const LimitSurface& surface, const Vec3<double>& corner) {
  Sight<double> a{}, b{};
  a.d = b.d = {1, 0};
  (surface.goes == LimitSurface::Goes::with_sensor ? b : a).p = corner;
  return {a, b};
}

/// How far a corner is from where the limit changes its sign: the limit is asked a little to all
/// sides.
bool lies_on_the_limit(const Potential& potential, const LimitSurface& surface, const Vec3<double>& corner) {
  const double step = 1e-4 * surface.reach;
  bool kept = false, broken = false;
  for (int i = 0; i < 27; ++i) {
    const Vec3<double> aside = {step * (i % 3 - 1), step * (i / 3 % 3 - 1), step * (i / 9 - 1)};
    const auto [a, b] = bodies_at(surface, corner + aside);
    (potential.violation(a, b, 0.0) <= 0 ? kept : broken) = true;
  }
  return kept && broken;
}

constexpr SensorMount level_mount = {.pitch = 0.0, .offset = 0.0};

TEST(LimitSurface, EveryCornerLiesOnTheLimit) {
  for (const Potential& potential :
       {Potential(SensorCone{.alpha = 0.5, .mount = level_mount}), Potential(camera().seen_from(level_mount)),
        Potential(box()),
        Potential(Region(all_of({"0.3 m < range < 6 m", "bearing < 30 deg"})).seen_from(level_mount)),
        Potential(Region(any_of({"bearing < 0.2", "bearing > 2.5"})).seen_from(level_mount)),
        Potential(KeepOut{.d_min = 1.5})}) {
    const LimitSurface surface = limit_surface(potential, level_mount);
    ASSERT_NE(surface.goes, LimitSurface::Goes::nowhere) << potential.name();
    EXPECT_EQ(surface.lacks, "");
    EXPECT_GT(surface.triangles.size(), 60U) << potential.name();
    EXPECT_TRUE(std::all_of(surface.corners.begin(), surface.corners.end(), [&](const Vec3<double>& corner) {
      return lies_on_the_limit(potential, surface, corner);
    })) << potential.name();
    std::set<int> used;
    for (const auto& triangle : surface.triangles) used.insert(triangle.begin(), triangle.end());
    EXPECT_EQ(used.size(), surface.corners.size());
    EXPECT_EQ(*used.rbegin() + 1, static_cast<int>(surface.corners.size()));
  }
}

/// Each edge of a closed surface is of two triangles.
TEST(LimitSurface, ALimitThatEndsHasASurfaceWithoutHoles) {
  const LimitSurface surface = limit_surface(Potential(KeepOut{.d_min = 1.5}), level_mount);
  std::map<std::pair<int, int>, int> edges;
  for (const auto& [a, b, c] : surface.triangles)
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
      ++edges[std::minmax(from, to)];
  EXPECT_TRUE(std::all_of(edges.begin(), edges.end(), [](const auto& edge) { return edge.second == 2; }));
  EXPECT_FALSE(surface.open || surface.scales);
  for (const Vec3<double>& corner : surface.corners) EXPECT_NEAR(norm(corner), 1.5, 1e-4);
}

TEST(LimitSurface, AConeLooksAlikeAtEveryDistanceAndASonarEnds) {
  const LimitSurface cone = limit_surface(SensorCone{.alpha = 0.4}, SensorCone{}.mount);
  EXPECT_EQ(cone.goes, LimitSurface::Goes::with_sensor);
  EXPECT_TRUE(cone.scales && !cone.open);
  for (const Vec3<double>& corner : cone.corners)
    EXPECT_TRUE(norm(corner) < 0.5 || std::fabs(off_axis(corner) - 0.4) < 1e-4);
  const LimitSurface camera_surface = limit_surface(camera(), SensorMount{});
  EXPECT_FALSE(camera_surface.scales || camera_surface.open);
  EXPECT_GT(camera_surface.reach, 4.0);
  EXPECT_LT(camera_surface.reach, 6.5);
  const LimitSurface beyond =
      limit_surface(Region("x > 2 m"), SensorMount{}, LimitSurface::Goes::with_sensor, 7.0);
  EXPECT_TRUE(beyond.open);
  EXPECT_EQ(beyond.reach, 7.0);
}

TEST(LimitSurface, ItDoesNotMatterHowTheSensorSitsOrTheRobotLeans) {
  const SensorMount tilted = {
      .pitch = 0.6, .offset = {0.2, -0.1, 0.05}, .frame = MountFrame::body, .yaw = -1.2, .roll = 0.4};
  const LimitSurface surface = limit_surface(Potential(camera()).seen_from(tilted), tilted);
  EXPECT_EQ(surface.goes, LimitSurface::Goes::with_sensor);
  EXPECT_EQ(surface.corners.size(),
            limit_surface(Potential(camera()).seen_from(level_mount), level_mount).corners.size());
  EXPECT_EQ(limit_surface(box(), SensorMount{}).goes, LimitSurface::Goes::with_target);
  for (const auto rather : {LimitSurface::Goes::with_sensor, LimitSurface::Goes::with_target}) {
    EXPECT_EQ(limit_surface(KeepOut{}, SensorMount{}, rather).goes, rather);
    EXPECT_EQ(limit_surface(camera(), SensorMount{}, rather).goes, LimitSurface::Goes::with_sensor);
  }
}

TEST(LimitSurface, WhatCannotBeDrawnIsSaid) {
  const auto lacks = [](const Limits& inside) {
    const LimitSurface surface = limit_surface(Region(inside), SensorMount{});
    EXPECT_TRUE(surface.triangles.empty());
    return surface.lacks;
  };
  EXPECT_THAT(lacks("range < 2 m + 0.1 m/s * t"), HasSubstr("depends on more than where one body is"));
  EXPECT_THAT(lacks("hypot(observer.p_x, target.p_y) > 1 m"), HasSubstr("depends on more"));
  EXPECT_THAT(lacks("range < -1 m"), HasSubstr("no place was found"));
  EXPECT_THAT(lacks("range > -1 m"), HasSubstr("holds everywhere"));
  const LimitSurface partly =
      limit_surface(Region(all_of({"bearing < 0.4", "range < 3 m", "target.p_z > 0.5 m"})), SensorMount{});
  EXPECT_THAT(partly.lacks, HasSubstr("1 of its 3 limits depends"));
  EXPECT_GT(partly.triangles.size(), 60U);
}

}  // namespace
}  // namespace sightline
