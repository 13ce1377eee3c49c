#include "sightline/estimate/planar_sighting.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

using In = RangeBearing::Input;

std::array<double, RangeBearing::inputs> draw(Random& random) {
  std::array<double, RangeBearing::inputs> z = uniform_array<RangeBearing::inputs>(random, -0.3, 0.3);
  for (const int i : {In::x_i, In::y_i, In::psi_i, In::x_j, In::y_j, In::psi_j})
    z[static_cast<std::size_t>(i)] = uniform(random, -3, 3);
  return z;
}

double difference(int row, double a, double b) { return row == 0 ? a - b : wrap(a - b); }

TEST(PlanarSighting, RangeAndBearingAreThoseOfThePointInTheFrameOfTheSensor) {
  Random random(1);
  SightingModel model;
  for (int k = 0; k < 500; ++k) {
    const auto z = draw(random);
    const Mat<3, 3> R_i = turn_z(z[In::psi_i]), R_j = turn_z(z[In::psi_j]);
    const Vec3<double> sensor =
        Vec3<double>{z[In::x_i], z[In::y_i], 0} + R_i * Vec3<double>{z[In::a_i_x], z[In::a_i_y], 0};
    const Vec3<double> point =
        Vec3<double>{z[In::x_j], z[In::y_j], z[In::h]} + R_j * Vec3<double>{z[In::a_j_x], z[In::a_j_y], 0};
    const Vec3<double> d = transposed(R_i) * (point - sensor);
    const auto expected = model(z).value;
    const double turn = std::atan2(d.y, d.x) - z[In::mu],
                 depth = norm(d.x, d.y) * std::cos(turn - z[In::eps]);
    const double seen = (1 - z[In::gamma]) * norm(d) + z[In::gamma] * depth;
    EXPECT_NEAR(expected[0], seen * (1 + z[In::s_d]) * (1 + z[In::rho]) + z[In::o], 1e-12);
    EXPECT_NEAR(expected[1], turn * (1 + z[In::s_b]) + z[In::eta], 1e-12);
  }
}

TEST(PlanarSighting, TracedDerivativesAreCentralDifferences) {
  Random random(2);
  SightingModel model;
  constexpr double step = 1e-6;
  for (int k = 0; k < 500; ++k) {
    const auto z = draw(random);
    const auto at = model(z);
    if (at.value[0] < 0.3) continue;
    for (int i = 0; i < RangeBearing::estimated; ++i) {
      auto above = z, below = z;
      above[static_cast<std::size_t>(i)] += step;
      below[static_cast<std::size_t>(i)] -= step;
      const auto up = model(above).value, down = model(below).value;
      for (int a = 0; a < 2; ++a)
        EXPECT_NEAR(
            at.H(a, i),
            difference(a, up[static_cast<std::size_t>(a)], down[static_cast<std::size_t>(a)]) / (2 * step),
            2e-7 * (1 + std::abs(at.H(a, i))));
    }
  }
}

}  // namespace
}  // namespace sightline
