#include <gtest/gtest.h>

#include "sightline/base.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/strict.hpp"

namespace sightline {
namespace {

TEST(Fixed, TheDotProductIsSymmetricAndLinear) {
  Random random(1);
  for (int k = 0; k < 1000; ++k) {
    const auto a = random_point(random, 5), b = random_point(random, 5), c = random_point(random, 5);
    const double s = uniform(random, -3, 3);
    EXPECT_EQ(dot(a, b), dot(b, a));
    EXPECT_LE(relative_error(dot(s * a + b, c), s * dot(a, c) + dot(b, c), 100), 1e-15);
    const Vec2<double> p{a.x, a.y}, q{b.x, b.y};
    EXPECT_EQ(dot(p, q), dot(q, p));
    EXPECT_LE(relative_error(dot(p, q), dot(a, b) - a.z * b.z, 100), 1e-15);
  }
}

TEST(Fixed, TheNormObeysTheTriangleInequalityAndScales) {
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const auto a = random_point(random, 5), b = random_point(random, 5);
    const double s = uniform(random, -3, 3);
    EXPECT_LE(norm(a + b), norm(a) + norm(b) + 1e-14);
    EXPECT_LE(relative_error(norm(s * a), std::fabs(s) * norm(a)), 1e-15);
    EXPECT_LE(relative_error(norm(a), std::hypot(a.x, a.y, a.z)), 1e-15);
    EXPECT_EQ(norm(a - a), 0.0);
  }
}

TEST(Fixed, VectorsOfAnyScalarAgree) {
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    const auto a = random_point(random, 5), b = random_point(random, 5);
    const Vec3<Strict> as{a.x, a.y, a.z}, bs{b.x, b.y, b.z};
    const Vec3<NativeLane> al{a.x, a.y, a.z}, bl{b.x, b.y, b.z};
    const double expected = norm(a - 2.0 * b);
    EXPECT_EQ(norm(as - Strict(2.0) * bs).value(), expected);
    EXPECT_EQ(norm(al - NativeLane(2.0) * bl)[0], expected);
  }
}

}  // namespace
}  // namespace sightline
