#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "sightline/formula.hpp"
#include "tests/support/difference.hpp"
#include "tests/support/error.hpp"
#include "tests/support/formula.hpp"

namespace sightline {
namespace {

constexpr int variable_count = 4;

/// A random formula, recorded over all its inputs, at a random point.
struct RecordedFormula {
  explicit RecordedFormula(Random& random, int operations)
      : x(uniform_array<variable_count>(random, -1.5, 1.5)), formula(random, x, operations) {
    for (int i = 0; i < variable_count; ++i) inputs.push_back(graph.input(i));
    out = formula(variables(graph, 0, variable_count)).in(graph);
  }

  std::vector<double> at_point(const std::vector<Term>& outputs) const {
    return evaluate({graph, outputs, variable_count}, x);
  }

  std::array<double, variable_count> x;
  Formula formula;
  Graph graph;
  std::vector<Term> inputs;
  Term out;
};

TEST(Derive, GradientAndHessianAreTheCentralDifferences) {
  Random random(1);
  for (int k = 0; k < 3000; ++k) {
    RecordedFormula f(random, 1 + static_cast<int>(random() % 24));
    const Derivatives d = derive(f.graph, f.out, f.inputs);
    const auto first = f.at_point(d.first), second = f.at_point(d.second);
    CentralDifference difference(f.formula, f.x);
    for (int i = 0; i < variable_count; ++i) {
      const auto row = static_cast<std::size_t>(i);
      ASSERT_LE(relative_error(first[row], difference.first(row)), 1e-8) << k << ' ' << i;
      for (int j = i; j < variable_count; ++j) {
        const double entry = second[static_cast<std::size_t>(upper_index(i, j, variable_count))];
        ASSERT_LE(relative_error(entry, difference.second(row, static_cast<std::size_t>(j))), 1e-6)
            << k << i << j;
      }
    }
  }
}

TEST(Derive, AThirdDerivativeOfARelaxedLogIsRefused) {
  Graph graph;
  const Term x = graph.input(0);
  const std::vector<Term> inputs = {x};
  const Derivatives d = derive(graph, graph.relaxed_log(x), inputs);
  EXPECT_THROW((void)gradient(graph, d.second[0], inputs), std::invalid_argument);
}

TEST(Derive, TheHessianIsTheGradientOfTheGradient) {
  Random random(2);
  for (int k = 0; k < 2000; ++k) {
    RecordedFormula f(random, 1 + static_cast<int>(random() % 24));
    const auto nodes = f.graph.nodes();
    const auto once = [](const Node& node) { return node.op == Op::relaxed_log; };
    if (std::any_of(nodes.begin(), nodes.end(), once)) continue;  // its slope is not derived again
    const auto second = f.at_point(derive(f.graph, f.out, f.inputs).second);
    const auto first = gradient(f.graph, f.out, f.inputs);
    for (int i = 0; i < variable_count; ++i) {
      const auto row = f.at_point(gradient(f.graph, first[static_cast<std::size_t>(i)], f.inputs));
      for (int j = 0; j < variable_count; ++j) {
        const double entry =
            second[static_cast<std::size_t>(upper_index(std::min(i, j), std::max(i, j), variable_count))];
        ASSERT_LE(relative_error(entry, row[static_cast<std::size_t>(j)]), 1e-10)
            << k << ' ' << i << ' ' << j;
      }
    }
  }
}

TEST(Derive, GradientAndDeriveNameTheSameTerms) {
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    RecordedFormula f(random, 16);
    const auto first = gradient(f.graph, f.out, f.inputs);
    EXPECT_EQ(derive(f.graph, f.out, f.inputs).first, first);
  }
}

TEST(Derive, AVariableThatDoesNotOccurHasNoDerivative) {
  Graph graph;
  const Term x = graph.input(0), never = graph.input(1), out = graph.exponential(graph.multiply(x, x));
  const Term later = graph.input(2);  // its node comes after the output
  const std::vector<Term> variables = {never, x, later};
  const Derivatives d = derive(graph, out, variables);
  EXPECT_TRUE(graph.is_zero(d.first[0]) && graph.is_zero(d.first[2]));
  EXPECT_FALSE(graph.is_zero(d.first[1]));
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      EXPECT_EQ(graph.is_zero(d.second[static_cast<std::size_t>(upper_index(i, j, 3))]), i != 1 || j != 1);
    }
  }
}

TEST(Derive, TheDerivativesOfAnAngleAreFiniteAtTheOriginAndOfEqualOperandsZero) {
  Graph graph;
  const std::vector<Term> x = {graph.input(0), graph.input(1)};
  const Derivatives d = derive(graph, graph.angle(x[0], -x[1]), x);
  for (const auto& list : {d.first, d.second}) {
    for (const double v : evaluate({graph, list, 2}, std::array{0.0, 0.0})) EXPECT_EQ(v, 0.0);
  }
  for (const Term t : derive(graph, graph.angle(-x[0], x[0]), x).first) EXPECT_TRUE(graph.is_zero(t));
}

TEST(Derive, UpperIndexCountsTheUpperTriangleRowByRow) {
  for (int size = 1; size < 20; ++size) {
    int next = 0;
    for (int i = 0; i < size; ++i) {
      for (int j = i; j < size; ++j) EXPECT_EQ(upper_index(i, j, size), next++);
    }
    EXPECT_EQ(next, size * (size + 1) / 2);
  }
}

}  // namespace
}  // namespace sightline
