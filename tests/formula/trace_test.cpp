#include <gtest/gtest.h>

#include <array>

#include "sightline/formula.hpp"
#include "tests/support/error.hpp"
#include "tests/support/formula.hpp"
#include "tests/support/strict.hpp"

namespace sightline {
namespace {

TEST(Trace, AFormulaOnLanesAndOnStrictHasTheBitsOfDouble) {
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const auto x = uniform_array<input_count>(random, -1.5, 1.5);
    const Formula formula(random, x, 16);
    const double expected = formula(std::vector<double>(x.begin(), x.end()));
    EXPECT_TRUE(same_bits(formula(std::vector<Strict>(x.begin(), x.end())).value(), expected));
    EXPECT_TRUE(same_bits(formula(std::vector<NativeLane>(x.begin(), x.end()))[native_width - 1], expected));
  }
}

TEST(Trace, ConstantsAreComputedWithoutAGraph) {
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    const auto x = uniform_array<input_count>(random, -1.5, 1.5);
    const Formula formula(random, x, 16);
    Graph graph;
    const Term out = formula(std::vector<Symbol>(x.begin(), x.end())).in(graph);
    EXPECT_EQ(graph.size(), 1);
    EXPECT_EQ(graph.constant_value(out), formula(std::vector<double>(x.begin(), x.end())));
  }
}

TEST(Trace, AssignmentsRecordAsTheirOperationsDo) {
  Graph graph;
  const auto x = variables(graph, 0, 2);
  Symbol a = x[0];
  a += x[1];
  EXPECT_EQ(a.in(graph), (x[0] + x[1]).in(graph));
  a -= 3.0;
  EXPECT_EQ(a.in(graph), (x[0] + x[1] - 3.0).in(graph));
  a *= x[0];
  EXPECT_EQ(a.in(graph), ((x[0] + x[1] - 3.0) * x[0]).in(graph));
}

}  // namespace
}  // namespace sightline
