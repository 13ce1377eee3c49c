#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "sightline/formula.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using Kind = Expression::Kind;

Expression power(int n) {
  ExpressionBuilder b;
  return b.finish(b.power(b.variable(0), n), {}, {});
}

double at(const Expression& e, double x, double y = 0.0, double width = 0.0) {
  const std::array<double, 2> v = {x, y};
  return e(std::span<const double>(v), width);
}

TEST(Expression, APowerIsTheProductOfItsFactors) {
  Random random(1);
  for (int n = -20; n <= 20; ++n) {
    const double x = uniform(random, 0.5, 2.0);
    EXPECT_LE(relative_error(at(power(n), x), std::pow(x, n)), 1e-14) << n;
  }
}

TEST(Expression, APowerOfTwoUndoesARoot) {
  ExpressionBuilder b;
  const int root = b.unary(Kind::root, b.variable(0));
  EXPECT_EQ(b.power(root, 2), b.variable(0));
  EXPECT_EQ(b.power(root, 6), b.power(b.variable(0), 3));
  EXPECT_EQ(b.power(root, 3), b.binary(Kind::multiply, b.variable(0), root));
}

TEST(Expression, EachStepIsThereOnceAndConstantsAreFolded) {
  ExpressionBuilder b;
  const int sum = b.binary(Kind::add, b.variable(0), b.constant(2.0));
  const std::size_t size = b.size();
  EXPECT_EQ(b.binary(Kind::add, b.variable(0), b.constant(2.0)), sum);
  EXPECT_EQ(b.size(), size);
  EXPECT_EQ(b.value(b.unary(Kind::root, b.constant(9.0))), 3.0);
  EXPECT_EQ(b.value(b.binary(Kind::divide, b.constant(1.0), b.constant(4.0))), 0.25);
  EXPECT_FALSE(b.value(sum).has_value());
}

TEST(Expression, LargerSmallerAndAbsoluteAreExactWithoutAWidth) {
  ExpressionBuilder b;
  const int x = b.variable(0), y = b.variable(1);
  const Expression larger = b.finish(b.larger(x, y), {}, {}), smaller = b.finish(b.smaller(x, y), {}, {}),
                   absolute = b.finish(b.absolute(x), {}, {});
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const double u = uniform(random, -3, 3), v = uniform(random, -3, 3);
    EXPECT_NEAR(at(larger, u, v), std::max(u, v), 1e-15);
    EXPECT_NEAR(at(smaller, u, v), std::min(u, v), 1e-15);
    EXPECT_NEAR(at(absolute, u), std::fabs(u), 1e-15);
    // With one, they are off by less than it, and by half at the corner for the larger.
    EXPECT_LE(std::fabs(at(absolute, u, 0, 1e-2) - std::fabs(u)), 1e-2);
  }
  EXPECT_EQ(at(absolute, 0, 0, 1e-2), 1e-2);
  EXPECT_EQ(at(larger, 1, 1, 1e-2), 1.005);
}

TEST(Expression, WhatIsRecordedGivesWhatIsComputed) {
  ExpressionBuilder b;
  const int x = b.variable(0), y = b.variable(1);
  int e = b.binary(Kind::angle, b.unary(Kind::sine, x), b.unary(Kind::cosine, y));
  e = b.binary(Kind::divide, e, b.unary(Kind::exponential, b.unary(Kind::negate, y)));
  e = b.binary(Kind::subtract, e, b.unary(Kind::logarithm, b.absolute(x)));
  const Expression expression = b.finish(e, {}, {});
  Graph graph;
  const std::vector<Symbol> symbols = variables(graph, 0, 2);
  const Term out = expression(std::span<const Symbol>(symbols), 1e-3).in(graph);
  const Program program(graph, std::vector{out}, 2);
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    const auto v = uniform_array<2>(random, -2, 2);
    EXPECT_LE(relative_error(evaluate(program, v)[0], expression(std::span<const double>(v), 1e-3)), 1e-13);
  }
}

TEST(Expression, LogisticAndSoftplusAreThoseOfTheRecordingScalarAndStayFinite) {
  ExpressionBuilder b;
  const Expression step = b.finish(b.unary(Kind::logistic, b.variable(0)), {}, {}),
                   ramp = b.finish(b.unary(Kind::softplus, b.variable(0)), {}, {});
  for (const double x : {-800.0, -3.0, 0.0, 0.5, 40.0, 800.0}) {
    EXPECT_EQ(at(step, x), logistic(x)) << x;
    EXPECT_EQ(at(ramp, x), softplus(x)) << x;
    EXPECT_TRUE(std::isfinite(at(step, x)) && std::isfinite(at(ramp, x))) << x;
    Graph graph;
    const std::array<Symbol, 1> z = {Symbol(graph, graph.input(0))};
    const std::array<Term, 2> out = {step(std::span<const Symbol>(z), 0.0).in(graph),
                                     ramp(std::span<const Symbol>(z), 0.0).in(graph)};
    const std::vector<double> values = evaluate(Program(graph, out, 1), std::array{x});
    EXPECT_EQ(values[0], at(step, x)) << x;
    EXPECT_EQ(values[1], at(ramp, x)) << x;
  }
  EXPECT_EQ(b.value(b.unary(Kind::logistic, b.constant(0.0))), 0.5);
}

}  // namespace
}  // namespace sightline
