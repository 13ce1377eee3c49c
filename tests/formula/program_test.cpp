#include <gtest/gtest.h>

#include <array>
#include <set>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "tests/support/formula.hpp"

namespace sightline {
namespace {

/// Several random formulas of the same inputs in one graph, with all their derivatives.
struct RecordedFormulas {
  explicit RecordedFormulas(Random& random) : x(uniform_array<input_count>(random, -1.5, 1.5)) {
    const auto symbols = variables(graph, 0, input_count);
    std::vector<Term> inputs;
    for (const Symbol& s : symbols) inputs.push_back(s.in(graph));
    for (std::uint64_t k = 1 + random() % 3; k > 0; --k) {
      formulas.emplace_back(random, x, 1 + static_cast<int>(random() % 16));
      outputs.push_back(formulas.back()(symbols).in(graph));
    }
    if (random() % 2 == 0) {
      const Derivatives d = derive(graph, outputs[0], inputs);
      outputs.insert(outputs.end(), d.first.begin(), d.first.end());
      outputs.insert(outputs.end(), d.second.begin(), d.second.end());
    }
  }

  std::array<double, input_count> x;
  Graph graph;
  std::vector<Formula> formulas;
  std::vector<Term> outputs;
};

TEST(Program, ScratchIsNoMoreThanTheInstructionsAskFor) {
  Random random(2);
  std::size_t instructions = 0, scratch = 0;
  for (int k = 0; k < 1000; ++k) {
    const RecordedFormulas f(random);
    const Program program(f.graph, f.outputs, input_count);
    std::set<int> written;
    for (const Instruction& q : program.instructions()) {
      ASSERT_GE(q.d, program.first_scratch());
      ASSERT_LT(q.d, program.rows());
      if (q.d < program.first_output()) written.insert(q.d);
    }
    EXPECT_EQ(written.size(), static_cast<std::size_t>(program.scratch()));
    instructions += program.instructions().size();
    scratch += written.size();
  }
  EXPECT_LT(2 * scratch, instructions);
}

TEST(Program, EveryOutputIsWrittenOnceAndLast) {
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    const RecordedFormulas f(random);
    const Program program(f.graph, f.outputs, input_count);
    ASSERT_EQ(program.outputs(), static_cast<int>(f.outputs.size()));
    const auto tail = program.instructions().last(f.outputs.size());
    for (std::size_t i = 0; i < tail.size(); ++i)
      EXPECT_EQ(tail[i].d, program.first_output() + static_cast<int>(i));
  }
}

/// A formula whose operands are computed in an order that C++ leaves to the compiler: left first,
/// right first, or either, operation by operation. Of few numbers and few functions, so that equal
/// parts and equal shapes meet.
class Tree {
 public:
  enum class Order { left_first, right_first, mixed };

  Tree(Random& random, int depth) : kind_(static_cast<int>(random() % 9)) {
    constexpr std::array numbers = {0.0, 1.0, 0.5, 2.0, 3.0};
    number_ = numbers[random() % numbers.size()];
    input_ = random() % input_count;
    if (depth == 0) kind_ = random() % 3 == 0 ? 1 : 0;
    for (std::size_t i = 0; kind_ > 1 && i < 2; ++i) parts_.emplace_back(random, depth - 1);
  }

  Symbol record(std::span<const Symbol> x, Order order, Random& random) const {
    if (kind_ == 0) return x[input_];
    if (kind_ == 1) return number_;
    const bool left = order == Order::left_first || (order == Order::mixed && random() % 2 == 0);
    std::array<Symbol, 2> s;
    for (const std::size_t i : {left ? 0u : 1u, left ? 1u : 0u}) s[i] = parts_[i].record(x, order, random);
    switch (kind_) {
      case 2:
      case 3:
        return s[0] * s[1];
      case 4:
        return s[0] - s[1];
      case 5:
        return s[0] + s[1];
      case 6:
        return logistic(s[0] - s[1]);
      case 7:
        return number_ * s[0] + s[1] / (1.0 + s[0] * s[0]);
      default:
        return atan2(s[0], s[1] * number_ + 2.0);
    }
  }

 private:
  int kind_;
  double number_ = 0.0;
  std::size_t input_ = 0;
  std::vector<Tree> parts_;
};

/// Value, gradient and Hessian of trees, the second tree with parameters of its own.
Program recorded(std::span<const Tree> trees, Tree::Order order, std::uint64_t seed, bool parameters) {
  Random random(seed);
  Graph graph;
  const auto x = variables(graph, 0, input_count);
  std::vector<Term> inputs, outputs;
  for (const Symbol& s : x) inputs.push_back(s.in(graph));
  Term sum = graph.constant(0.0);
  for (const Tree& tree : trees) {
    if (parameters) graph.keep_parameters();
    sum = graph.add(sum, tree.record(x, order, random).in(graph));
  }
  graph.keep_values();
  outputs.push_back(sum);
  const Derivatives d = derive(graph, sum, inputs);
  outputs.insert(outputs.end(), d.first.begin(), d.first.end());
  outputs.insert(outputs.end(), d.second.begin(), d.second.end());
  return Program(graph, outputs, input_count);
}

TEST(Program, TheOrderInWhichOperandsAreComputedDoesNotMatter) {
  Random random(6);
  std::size_t instructions = 0;
  for (int k = 0; k < 4000; ++k) {
    const std::vector<Tree> trees = {Tree(random, 1 + k % 4), Tree(random, 2)};
    for (const bool parameters : {false, true}) {
      const Program left = recorded(trees, Tree::Order::left_first, 0, parameters);
      ASSERT_EQ(left, recorded(trees, Tree::Order::right_first, 0, parameters)) << k;
      ASSERT_EQ(left, recorded(trees, Tree::Order::mixed, random(), parameters)) << k;
      instructions += left.instructions().size();
    }
  }
  EXPECT_GT(instructions, 200'000u) << "formulas that are worth it";
}

TEST(Program, ConstantsAreDistinctAndUsed) {
  Random random(5);
  for (int k = 0; k < 1000; ++k) {
    const RecordedFormulas f(random);
    const Program program(f.graph, f.outputs, input_count);
    const std::set<double> distinct(program.constants().begin(), program.constants().end());
    EXPECT_EQ(distinct.size(), program.constants().size());
    std::set<int> read;
    for (const Instruction& q : program.instructions()) read.insert({q.a, q.b, q.c});
    for (int r = program.first_constant(); r < program.first_scratch(); ++r) EXPECT_TRUE(read.contains(r));
  }
}

/// The codes of one output's program, but for the copy at the end.
std::vector<Code> codes(const Graph& graph, Term out) {
  const Program program(graph, std::span(&out, 1), input_count);
  std::vector<Code> list;
  for (const Instruction& q : program.instructions()) list.push_back(q.code);
  list.pop_back();
  return list;
}

TEST(Program, AProductUsedByOneSumAloneBecomesPartOfIt) {
  Graph g;
  const Term x = g.input(0), y = g.input(1), z = g.input(2), xy = g.multiply(x, y);
  EXPECT_EQ(codes(g, g.add(xy, z)), std::vector{Code::multiply_add});
  EXPECT_EQ(codes(g, g.subtract(z, xy)), std::vector{Code::subtract_product});
  EXPECT_EQ(codes(g, g.multiply(xy, g.add(xy, z))), (std::vector{Code::multiply, Code::add, Code::multiply}));
  const Term late = g.exponential(z);  // so that the product stands first in the sum
  EXPECT_EQ(codes(g, g.subtract(xy, late)), (std::vector{Code::exponential, Code::multiply_subtract}));
}

TEST(Program, WhatNoOutputNeedsIsLeftOut) {
  Graph g;
  const Term x = g.input(0), sum = g.add(x, g.input(1));
  g.exponential(g.multiply(sum, g.constant(7.0)));
  EXPECT_EQ(codes(g, sum), std::vector{Code::add});
  EXPECT_TRUE(Program(g, std::span(&sum, 1), input_count).constants().empty());
}

TEST(Program, AnInputOrAConstantMayItselfBeAnOutput) {
  Graph g;
  const std::vector<Term> outputs = {g.input(2), -g.input(0), g.constant(-2.5), g.input(2)};
  EXPECT_EQ(evaluate(Program(g, outputs, input_count), std::array{1.0, 2.0, 3.0}),
            (std::vector{3.0, -1.0, -2.5, 3.0}));
}

}  // namespace
}  // namespace sightline
