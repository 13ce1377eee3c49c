#include <gtest/gtest.h>

#include <array>

#include "sightline/formula.hpp"
#include "tests/support/formula.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

/// Each lane of a program whose inputs and outputs are cut into two blocks each, against
/// `evaluate`.
template <int W>
void expect_same_bits(const Program& program, Random& random) {
  const auto halves = [](int n) { return std::array{n / 2, n - n / 2}; };
  const auto in = halves(program.inputs()), out = halves(program.outputs());
  Threaded<W> threaded(program, in, out);
  std::array<Rows, 2> from = {Rows(1, W * in[0]), Rows(1, W * in[1])},
                      to = {Rows(1, W * out[0]), Rows(1, W * out[1])};
  for (Rows& block : from) {
    for (double& v : block.all()) v = uniform(random, -1.5, 1.5);
  }
  threaded.run({from[0][0], from[1][0]}, {to[0][0], to[1][0]});
  const auto number = [](const std::array<Rows, 2>& blocks, const std::array<int, 2>& sizes, int i,
                         int lane) {
    const std::size_t block = i < sizes[0] ? 0 : 1;
    return blocks[block][0][(i - (block == 0 ? 0 : sizes[0])) * W + lane];
  };
  for (int lane = 0; lane < W; ++lane) {
    std::vector<double> point;
    for (int i = 0; i < program.inputs(); ++i) point.push_back(number(from, in, i, lane));
    const std::vector<double> expected = evaluate(program, point);
    for (int i = 0; i < program.outputs(); ++i) {
      const double got = number(to, out, i, lane), wanted = expected[static_cast<std::size_t>(i)];
      EXPECT_TRUE(got == wanted || (std::isnan(got) && std::isnan(wanted)))
          << i << ": " << got << " " << wanted;
    }
  }
}

TEST(Threaded, GivesTheBitsOfThePlainInterpreterForDerivativesOfAnyFormula) {
  Random random(1);
  for (int trial = 0; trial < 150; ++trial) {
    const std::vector<double> point = {uniform(random, -1, 1), uniform(random, -1, 1),
                                       uniform(random, -1, 1)};
    const Formula formula(random, point, 1 + static_cast<int>(random() % 60));
    Graph graph;
    const std::vector<Symbol> z = variables(graph, 0, 3);
    const Term l = formula(z).in(graph);
    std::vector<Term> terms;
    for (const Symbol& s : z) terms.push_back(s.in(graph));
    const Derivatives d = derive(graph, l, terms);
    std::vector<Term> outputs = d.first;
    outputs.insert(outputs.end(), d.second.begin(), d.second.end());
    // What a result is copied to may be two outputs, with either sign, or an input or a constant.
    outputs.insert(outputs.end(), {l, -l, l, terms[0], -terms[1], graph.constant(2.5)});
    const Program program(graph, outputs, 3);
    expect_same_bits<1>(program, random);
    expect_same_bits<2>(program, random);
    expect_same_bits<8>(program, random);
  }
}

TEST(Threaded, LongSumsGoOnFromStepToStep) {
  Random random(2);
  for (int terms = 1; terms <= 12; ++terms) {
    Graph graph;
    const std::vector<Symbol> z = variables(graph, 0, 2 * terms);
    Symbol sum = 0.0;
    for (int i = 0; i < terms; ++i) {
      const Symbol &a = z[static_cast<std::size_t>(2 * i)], &b = z[static_cast<std::size_t>(2 * i + 1)];
      const std::array<Symbol, 4> next = {sum + a * b, sum - a * b, sum + a, sum - b};
      sum = next[random() % 4];
    }
    const Program program(graph, std::array{sum.in(graph), (sum * sum).in(graph)}, 2 * terms);
    expect_same_bits<2>(program, random);
    expect_same_bits<4>(program, random);
  }
}

}  // namespace
}  // namespace sightline
