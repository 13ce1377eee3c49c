#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "sightline/formula.hpp"
#include "tests/support/error.hpp"
#include "tests/support/formula.hpp"
#include "tests/support/wide.hpp"

namespace sightline {
namespace {

/// A random formula with its derivatives, as a program.
struct DerivedProgram {
  explicit DerivedProgram(Random& random, int operations)
      : formula(random, uniform_array<input_count>(random, -1.5, 1.5), operations) {
    Graph graph;
    const auto symbols = variables(graph, 0, input_count);
    std::vector<Term> inputs;
    for (const Symbol& s : symbols) inputs.push_back(s.in(graph));
    std::vector<Term> outputs = {formula(symbols).in(graph)};
    const Derivatives d = derive(graph, outputs[0], inputs);
    outputs.insert(outputs.end(), d.first.begin(), d.first.end());
    outputs.insert(outputs.end(), d.second.begin(), d.second.end());
    program = Program(graph, outputs, input_count);
  }

  Formula formula;
  Program program;
};

/// The outputs of a program over the points that stand in the rows of `in`.
Rows run(const Program& program, const Rows& in, int length) {
  Rows out(program.outputs(), length);
  Evaluation evaluation(program, length);
  for (int i = 0; i < program.inputs(); ++i) evaluation.input(i, in[i]);
  for (int i = 0; i < program.outputs(); ++i) evaluation.output(i, out[i]);
  evaluation.run();
  return out;
}

TEST(Interpret, OnLanesAFormulaIsWhatItIsOnPlainNumbers) {
  Random random(1);
  constexpr int length = 40;
  int tested = 0;
  constexpr int formulas = 2000;
  for (int k = 0; k < formulas; ++k) {
    const DerivedProgram f(random, 1 + static_cast<int>(random() % 24));
    Rows in(input_count, length);
    for (double& v : in.all()) v = uniform(random, -1.5, 1.5);
    const Rows out = run(f.program, in, length);
    for (int point = 0; point < length; ++point) {
      const Wide exact = f.formula(std::vector<Wide>{in[0][point], in[1][point], in[2][point]});
      if (!(exact.rounding() < 1e-13)) continue;  // a formula may grow away from its point
      ASSERT_LE(std::fabs(out[0][point] - static_cast<double>(exact.value())), 2 * exact.rounding()) << k;
      ++tested;
    }
  }
  EXPECT_GT(tested, formulas * length * 9 / 10);
}

TEST(Interpret, APointHasTheSameBitsInARowOfAnyLength) {
  Random random(2);
  for (int k = 0; k < 30; ++k) {
    const DerivedProgram f(random, 16);
    Rows in(input_count, 100);
    for (double& v : in.all()) v = uniform(random, -1.5, 1.5);
    const Rows whole = run(f.program, in, 100);
    for (int length = 1; length <= 100; ++length) {
      const Rows part = run(f.program, in, length);
      for (int o = 0; o < f.program.outputs(); ++o) {
        for (int point = 0; point < length; ++point) ASSERT_TRUE(same_bits(part[o][point], whole[o][point]));
      }
    }
  }
}

TEST(Interpret, APointHasTheSameBitsAtAnyPlaceOfARow) {
  Random random(3);
  for (int k = 0; k < 100; ++k) {
    const DerivedProgram f(random, 16);
    const auto x = uniform_array<input_count>(random, -1.5, 1.5);
    const auto alone = evaluate(f.program, x);
    const int length = 1 + static_cast<int>(random() % 100);
    const int at = static_cast<int>(random() % static_cast<std::uint64_t>(length));
    Rows in(input_count, length);
    for (double& v : in.all()) v = uniform(random, -1.5, 1.5);
    for (int i = 0; i < input_count; ++i) in[i][at] = x[static_cast<std::size_t>(i)];
    const Rows out = run(f.program, in, length);
    for (int o = 0; o < f.program.outputs(); ++o) {
      EXPECT_TRUE(same_bits(out[o][at], alone[static_cast<std::size_t>(o)]));
    }
  }
}

TEST(Interpret, InputsAreLeftAsTheyWereAndASecondRunGivesTheSame) {
  Random random(4);
  for (int k = 0; k < 100; ++k) {
    const DerivedProgram f(random, 20);
    Rows in(input_count, 37), out(f.program.outputs(), 37);
    for (double& v : in.all()) v = uniform(random, -1.5, 1.5);
    const std::vector<double> before(in.all().begin(), in.all().end());
    Evaluation evaluation(f.program, 37);
    for (int i = 0; i < input_count; ++i) evaluation.input(i, in[i]);
    for (int i = 0; i < f.program.outputs(); ++i) evaluation.output(i, out[i]);
    evaluation.run();
    const std::vector<double> once(out.all().begin(), out.all().end());
    evaluation.run();
    EXPECT_TRUE(std::equal(before.begin(), before.end(), in.all().begin()));
    EXPECT_TRUE(std::equal(once.begin(), once.end(), out.all().begin(), same_bits));
  }
}

TEST(Interpret, NotANumberInOnePointStaysInThatPoint) {
  Random random(5);
  Graph graph;
  const auto x = variables(graph, 0, input_count);
  const Term out = logistic(x[0] * x[1] + exp(x[2])).in(graph);
  const Program program(graph, std::span(&out, 1), input_count);
  for (int bad = 0; bad < 24; ++bad) {
    Rows in(input_count, 24);
    for (double& v : in.all()) v = uniform(random, -1, 1);
    in[1][bad] = std::numeric_limits<double>::quiet_NaN();
    const Rows result = run(program, in, 24);
    for (int point = 0; point < 24; ++point) EXPECT_EQ(std::isnan(result[0][point]), point == bad);
  }
}

void expect_rows(Rows& rows, int n, int length) {
  EXPECT_EQ(rows.count(), n);
  EXPECT_EQ(rows.stride(), padded(length));
  for (int r = 0; r < n; ++r) {
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(rows[r]) % row_alignment, 0u);
    EXPECT_EQ(rows[r], rows[0] + static_cast<std::ptrdiff_t>(r) * rows.stride());
  }
  for (const double v : rows.all()) EXPECT_EQ(v, 0.0);
  EXPECT_EQ(rows.all().size(), static_cast<std::size_t>(n) * static_cast<std::size_t>(rows.stride()));
  EXPECT_EQ(static_cast<std::ptrdiff_t>(rows.all().size()), Rows::room(n, length));
}

TEST(Rows, AreAlignedPaddedApartAndZero) {
  for (int length = 1; length < 40; ++length) {
    Rows rows(3, length);
    expect_rows(rows, 3, length);
  }
  Rows large(3, 300001);  // more than a large page
  expect_rows(large, 3, 300001);
}

TEST(Rows, InMemoryOfSomebodyElseAreTheSameAndLeaveIt) {
  for (const int length : {1, 8, 13}) {
    Rows memory(1, static_cast<int>(2 * Rows::room(3, length)));
    std::fill_n(memory[0], memory.stride(), 7.0);
    {
      Rows first(3, length, memory[0]);
      Rows rows(3, length, memory[0] + Rows::room(3, length));
      first = std::move(rows);
      expect_rows(first, 3, length);
      EXPECT_EQ(first[0], memory[0] + Rows::room(3, length));
      first[2][0] = 5.0;
    }
    EXPECT_EQ(memory[0][Rows::room(3, length) + 2 * padded(length)], 5.0);
  }
}

}  // namespace
}  // namespace sightline
