#include "sightline/solver/newton/points.hpp"

#include <gtest/gtest.h>

#include "sightline/potentials.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

TEST(Points, EachIsThePotentialThere) {
  Random random(1);
  const Weighted cone = 0.4 * SensorCone{};
  const std::array<const Weighted*, 1> terms = {&cone};
  const PosePotential potential = trace_potential(terms, 0.05, {});
  for (const KernelChoice choice : {KernelChoice::compiled_if_there, KernelChoice::interpreted}) {
    constexpr int count = 21;
    Points points(potential, choice);
    points.resize(count);
    std::vector<std::vector<double>> in;
    for (int p = 0; p < count; ++p) {
      const auto z = uniform_array<5>(random, -1, 1);
      in.emplace_back(z.begin(), z.end());
      for (int i = 0; i < 5; ++i) points.in(p, i) = z[static_cast<std::size_t>(i)];
    }
    points.derive();
    points.evaluate(count);
    for (int p = 0; p < count; ++p) {
      const auto& z = in[static_cast<std::size_t>(p)];
      EXPECT_EQ(points.value(p), evaluate(potential.value, z)[0]);
      const std::vector<double> derivatives = evaluate(potential.derivatives, z);
      for (int i = 0; i < 20; ++i) EXPECT_EQ(*points.out(p, i), derivatives[static_cast<std::size_t>(i)]);
    }
  }
}

}  // namespace
}  // namespace sightline
