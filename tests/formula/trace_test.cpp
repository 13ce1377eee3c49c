#include <gtest/gtest.h>

#include <array>

#include "sightline/formula.hpp"
#include "tests/support/error.hpp"
#include "tests/support/formula.hpp"
#include "tests/support/strict.hpp"
#include "tests/support/wide.hpp"

namespace sightline {
namespace {

double evaluate_one(const Graph& graph, Term out, std::span<const double> x) {
  return evaluate(Program(graph, std::span(&out, 1), static_cast<int>(x.size())), x)[0];
}

TEST(Trace, ARecordedFormulaGivesWhatItGivesOnNumbers) {
  Random random(1);
  for (int k = 0; k < 4000; ++k) {
    const auto x = uniform_array<input_count>(random, -1.5, 1.5);
    const Formula formula(random, x, 1 + static_cast<int>(random() % 24));
    Graph graph;
    const Term out = formula(variables(graph, 0, input_count)).in(graph);
    const Wide exact = formula(std::vector<Wide>(x.begin(), x.end()));
    const double error = std::fabs(evaluate_one(graph, out, x) - static_cast<double>(exact.value()));
    EXPECT_LE(error, 2 * exact.rounding()) << k;
    EXPECT_LE(error, 1e-12) << k;
  }
}

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
