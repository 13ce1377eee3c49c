#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <tuple>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

/// A graph grown at random, and terms of it: inputs, constants and results, seen with either sign.
class GraphLaws : public testing::Test {
 protected:
  Term any() {
    const Term t = terms_[random_() % terms_.size()];
    return random_() % 2 == 0 ? t : -t;
  }
  Term input() { return graph_.input(static_cast<int>(random_() % 3)); }
  double number() { return uniform(random_, -3, 3); }

  /// Adds one more term; constants stay moderate, so that none becomes infinite on the way.
  void grow() {
    const Term t = draw();
    if (!graph_.is_constant(t) || std::fabs(graph_.constant_value(t)) < 10) terms_.push_back(t);
  }
  Term draw() {
    switch (random_() % 8) {
      case 0:
        return graph_.add(any(), any());
      case 1:
        return graph_.multiply(any(), any());
      case 2:
        return graph_.reciprocal(graph_.exponential(any()));
      case 3:
        return graph_.exponential(any());
      case 4:
        return graph_.logistic(any());
      case 5:
        return graph_.sine(any());
      case 6:
        return graph_.cosine(any());
      default:
        return random_() % 2 == 0 ? input() : graph_.constant(number());
    }
  }

  /// Whether a and b are one node with one sign; zero has none.
  bool same(Term a, Term b) const { return a == b || (graph_.is_zero(a) && graph_.is_zero(b)); }

  /// Calls law(a, b) on many pairs of terms of many graphs.
  template <class Law>
  void for_pairs(Law law) {
    for (int k = 0; k < 40; ++k) {
      graph_ = Graph();
      terms_ = {input()};
      for (int i = 0; i < 60; ++i) {
        grow();
        law(any(), any());
      }
    }
  }

  Random random_{1};
  Graph graph_;
  std::vector<Term> terms_;
};

TEST_F(GraphLaws, ADifferenceAndItsNegativeAreOneNode) {
  for_pairs([&](Term a, Term b) { EXPECT_TRUE(same(graph_.subtract(a, b), -graph_.subtract(b, a))); });
}

TEST_F(GraphLaws, TheSignOfAProductMovesFreelyBetweenItsFactors) {
  for_pairs([&](Term a, Term b) {
    const Term ab = graph_.multiply(a, b);
    EXPECT_TRUE(same(-ab, graph_.multiply(-a, b)));
    EXPECT_TRUE(same(-ab, graph_.multiply(a, -b)));
    EXPECT_TRUE(same(ab, graph_.multiply(-a, -b)));
  });
}

TEST_F(GraphLaws, SumsAndProductsCommute) {
  for_pairs([&](Term a, Term b) {
    EXPECT_TRUE(same(graph_.add(a, b), graph_.add(b, a)));
    EXPECT_TRUE(same(graph_.multiply(a, b), graph_.multiply(b, a)));
  });
}

TEST_F(GraphLaws, OddAndEvenFunctionsShareTheirNodeWithTheNegative) {
  for_pairs([&](Term a, Term) {
    if (graph_.is_constant(a)) return;
    EXPECT_EQ(graph_.sine(-a), -graph_.sine(a));
    EXPECT_EQ(graph_.cosine(-a), graph_.cosine(a));
    EXPECT_EQ(graph_.reciprocal(-a), -graph_.reciprocal(a));
    EXPECT_EQ(graph_.logistic(-a), graph_.subtract(graph_.constant(1.0), graph_.logistic(a)));
  });
}

TEST_F(GraphLaws, ZerosAndOnesFoldAway) {
  for_pairs([&](Term a, Term) {
    const Term zero = graph_.constant(0.0), one = graph_.constant(1.0);
    EXPECT_TRUE(same(graph_.add(a, zero), a));
    EXPECT_TRUE(same(graph_.multiply(a, one), a));
    EXPECT_TRUE(same(graph_.multiply(a, -one), -a));
    EXPECT_TRUE(graph_.is_zero(graph_.multiply(a, zero)));
    EXPECT_TRUE(graph_.is_zero(graph_.subtract(a, a)));
    EXPECT_TRUE(same(graph_.add(a, a), graph_.multiply(graph_.constant(2.0), a)));
  });
}

TEST_F(GraphLaws, ASumTakenBackLeavesTheTerm) {
  for_pairs([&](Term, Term) {
    const Term a = graph_.sine(input());  // no sum with a constant: gathering those rounds anew
    const Term one = graph_.constant(1.0);
    EXPECT_EQ(graph_.subtract(one, graph_.subtract(one, a)), a);
  });
}

TEST_F(GraphLaws, ConstantsGatherInFront) {
  for_pairs([&](Term, Term) {
    const Term x = input(), y = graph_.exponential(input());
    const double c = number(), d = number();
    const auto constant = [&](double v) { return graph_.constant(v); };
    EXPECT_EQ(graph_.multiply(constant(c), graph_.multiply(constant(d), x)),
              graph_.multiply(constant(c * d), x));
    EXPECT_EQ(graph_.add(constant(c), graph_.add(constant(d), x)), graph_.add(constant(c + d), x));
    EXPECT_EQ(graph_.multiply(graph_.multiply(constant(c), x), y),
              graph_.multiply(constant(c), graph_.multiply(x, y)));
    EXPECT_EQ(graph_.multiply(x, graph_.multiply(constant(c), y)),
              graph_.multiply(constant(c), graph_.multiply(x, y)));
  });
}

TEST_F(GraphLaws, ConstantsAreComputedAtOnce) {
  for_pairs([&](Term, Term) {
    const double a = number(), b = number();
    const Term ta = graph_.constant(a), tb = graph_.constant(b);
    EXPECT_EQ(graph_.constant_value(graph_.add(ta, tb)), a + b);
    EXPECT_EQ(graph_.constant_value(graph_.subtract(ta, tb)), a - b);
    EXPECT_EQ(graph_.constant_value(graph_.multiply(ta, tb)), a * b);
    EXPECT_EQ(graph_.constant_value(graph_.reciprocal(ta)), 1.0 / a);
    EXPECT_EQ(graph_.constant_value(graph_.square_root(graph_.constant(a * a))), sqrt(a * a));
    EXPECT_EQ(graph_.constant_value(graph_.exponential(ta)), exp(a));
    EXPECT_EQ(graph_.constant_value(graph_.logistic(ta)), logistic(a));
    EXPECT_EQ(graph_.constant_value(graph_.sine(ta)), sin(a));
    EXPECT_EQ(graph_.constant_value(graph_.cosine(ta)), cos(a));
    EXPECT_EQ(graph_.constant(a), -graph_.constant(-a));
  });
}

TEST_F(GraphLaws, EachNodeIsStoredOnceAfterItsOperandsWithTheSignsThatOpPromises) {
  for_pairs([&](Term, Term) {});
  std::set<std::tuple<Op, int, bool, int, bool, double>> seen;
  for (int v = 0; v < graph_.size(); ++v) {
    const Node& n = graph_.nodes()[static_cast<std::size_t>(v)];
    EXPECT_TRUE(seen.emplace(n.op, n.a.node, n.a.negative, n.b.node, n.b.negative, n.value).second);
    EXPECT_LT(n.a.node, v);
    EXPECT_LT(n.b.node, v);
    const bool may_negate =
        n.op == Op::square_root || n.op == Op::exponential || n.op == Op::logarithm || n.op == Op::softplus;
    EXPECT_TRUE(!n.a.negative || may_negate);
    EXPECT_TRUE(!n.b.negative || n.op == Op::add || n.op == Op::angle);
    EXPECT_FALSE(n.op == Op::constant && std::signbit(n.value));
  }
}

TEST(Graph, ConstantsAreDrawnToTheFrontUnlessToldOtherwise) {
  Graph graph;
  const Term c = graph.constant(3.0), a = graph.input(0), b = graph.input(1);
  EXPECT_EQ(graph.multiply(graph.multiply(c, a), b), graph.multiply(c, graph.multiply(a, b)));
  graph.draw_constants(false);
  EXPECT_NE(graph.multiply(graph.multiply(c, b), a), graph.multiply(c, graph.multiply(a, b)));
}

TEST(Graph, TheRelaxedLogOfAConstantIsAConstantAndThatOfAnInputKnowsItsSign) {
  Graph graph;
  EXPECT_EQ(graph.relaxed_log(graph.constant(1.0)), graph.constant(0.0));
  EXPECT_EQ(graph.relaxed_log(graph.constant(-1.0)), graph.constant(-4.0));
  const Term a = graph.input(0);
  EXPECT_EQ(graph.relaxed_log(a), graph.relaxed_log(a));
  EXPECT_NE(graph.relaxed_log(a), graph.relaxed_log(-a));
}

TEST(Graph, TheMaximumOfConstantsIsAConstant) {
  Graph graph;
  EXPECT_EQ(graph.maximum(graph.constant(-1.0), graph.constant(-2.0)), graph.constant(-1.0));
  const Term a = graph.input(0);
  EXPECT_EQ(graph.node(graph.maximum(-a, graph.constant(2.0))).op, Op::maximum);
}

TEST(Graph, ParametersNeitherFoldNorMeetByTheirValue) {
  Graph graph;
  const Term x = graph.input(0), y = graph.input(1);
  EXPECT_TRUE(graph.is_zero(graph.multiply(graph.number(0.0, x, true), x)))
      << "a number, until told otherwise";
  graph.keep_parameters();
  const Term zero = graph.number(0.0, x, true), one = graph.number(1.0, x, true);
  EXPECT_EQ(graph.node(graph.multiply(zero, x)).op, Op::multiply);
  EXPECT_NE(graph.multiply(one, x), x);
  EXPECT_EQ(graph.number(1.0, x, true), one) << "met twice in one way";
  EXPECT_EQ(graph.number(1.0, -x, true), one);
  EXPECT_NE(graph.number(1.0, x, false), one) << "as a summand";
  EXPECT_NE(graph.number(1.0, y, true), one);
  EXPECT_NE(graph.constant(1.0), one);
  graph.keep_parameters();
  EXPECT_NE(graph.number(1.0, x, true), one) << "in another formula";
}

TEST(Graph, ResultsOfParametersAreParametersOfTheirValue) {
  Graph graph;
  graph.keep_parameters();
  const Term x = graph.input(0), a = graph.number(-3.0, x, true), b = graph.number(2.0, x, false);
  const Term ab = graph.multiply(a, b), two = graph.constant(2.0);
  EXPECT_EQ(graph.constant_value(ab), -6.0);
  EXPECT_EQ(graph.multiply(b, a), ab);
  EXPECT_EQ(graph.multiply(graph.multiply(two, a), b), graph.multiply(a, graph.multiply(b, two)));
  EXPECT_EQ(graph.constant_value(graph.multiply(-a, graph.multiply(two, b))), 12.0);
  EXPECT_EQ(graph.multiply(a, graph.multiply(b, x)), graph.multiply(ab, x));
  EXPECT_EQ(graph.constant_value(graph.add(a, -b)), -5.0);
  EXPECT_EQ(graph.add(a, graph.add(b, x)), graph.add(graph.add(a, b), x));
  EXPECT_TRUE(graph.is_zero(graph.add(a, -a)));
  EXPECT_EQ(graph.constant_value(graph.reciprocal(b)), 0.5);
  EXPECT_EQ(graph.reciprocal(b), graph.reciprocal(b));
  EXPECT_NE(graph.add(b, a), graph.constant(-1.0));
  EXPECT_EQ(graph.constant_value(graph.maximum(a, b)), 2.0);
}

}  // namespace
}  // namespace sightline
