#include <gtest/gtest.h>

#include <array>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "sightline/formula.hpp"
#include "tests/support/formula.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

/// (a + c) b and c / a, of inputs (a, b) and a constant c.
Program two_outputs(double c) {
  Graph graph;
  const Symbol a(graph, graph.input(0)), b(graph, graph.input(1));
  const std::array<Term, 2> outputs = {((a + c) * b).in(graph), (-(Symbol(c) / a)).in(graph)};
  return Program(graph, outputs, 2);
}

const std::array<Block, 1> block_in = {Block{"in", 2}}, block_out = {Block{"out", 2}};

TEST(Emit, ProgramsOfOneStructureDifferInTheirConstantsAlone) {
  EXPECT_EQ(structure(two_outputs(0.3)), structure(two_outputs(0.7)));
  EXPECT_EQ(emit(two_outputs(0.3), "f", block_in, block_out),
            emit(two_outputs(0.7), "f", block_in, block_out));
  EXPECT_NE(two_outputs(0.3), two_outputs(0.7));
}

TEST(Emit, AnOperationThatFallsAwayIsAnotherStructure) {
  EXPECT_NE(structure(two_outputs(0.3)), structure(two_outputs(0.0)));
  EXPECT_NE(structure(two_outputs(0.3)), structure(two_outputs(1.0)));
}

/// A random formula and its gradient.
Program random_program(Random& random) {
  const Formula formula(random, uniform_array<input_count>(random, -1.5, 1.5), 40);
  Graph graph;
  const auto symbols = variables(graph, 0, input_count);
  std::vector<Term> inputs;
  for (const Symbol& s : symbols) inputs.push_back(s.in(graph));
  const std::vector<Term> outputs = gradient(graph, formula(symbols).in(graph), inputs);
  return Program(graph, outputs, input_count);
}

TEST(Emit, EachLineIsPrintedOnceAndAfterThoseThatItReads) {
  Random random(7);
  const std::regex line(R"(const L (t\d+) = (.*);)"), result(R"(\bt\d+\b)");
  for (int trial = 0; trial < 50; ++trial) {
    const Program program = random_program(random);
    const std::array<Block, 1> in = {Block{"in", program.inputs()}}, out = {Block{"out", program.outputs()}};
    const std::string text = emit(program, "f", in, out);
    std::set<std::string> known;
    for (std::sregex_iterator l(text.begin(), text.end(), line), end; l != end; ++l) {
      const std::string read = (*l)[2];
      for (std::sregex_iterator r(read.begin(), read.end(), result); r != end; ++r)
        EXPECT_TRUE(known.contains(r->str())) << text;
      EXPECT_TRUE(known.insert((*l)[1]).second) << text;
    }
    EXPECT_EQ(known.size(), program.instructions().size() - at(program.outputs()))
        << "the last instructions copy results to outputs";
  }
}

Symbol long_path(const Symbol& a, const Symbol& b) { return (((a + b) * b + a) * b + a) * b; }

TEST(Emit, TheLongestPathComesFirst) {
  Graph graph;
  const Symbol a(graph, graph.input(0)), b(graph, graph.input(1));
  const std::array<Term, 2> outputs = {(a * a).in(graph), long_path(a, b).in(graph)};
  const std::string text = emit(Program(graph, outputs, 2), "f", block_in, block_out);
  EXPECT_LT(text.find("out + 1 * L::width"), text.find("out + 0 * L::width")) << text;
}

TEST(Emit, APathGoesOnInTheNextCall) {
  Graph graph;
  const Symbol a(graph, graph.input(0)), b(graph, graph.input(1));
  const std::array<Term, 2> outputs = {long_path(a, b).in(graph), (b * b).in(graph)};
  const Program program(graph, outputs, 2);
  const std::array<Block, 2> in = {Block{"p", 1}, Block{"q", 1}}, once = {Block{"u", 1}, Block{"v", 1}},
                             again = {Block{"u", 1}, Block{"q_out", 1}};
  const std::string ends = emit(program, "f", in, once), goes_on = emit(program, "f", in, again);
  EXPECT_LT(ends.find("store(u"), ends.find("store(v")) << ends;
  EXPECT_LT(goes_on.find("store(q_out"), goes_on.find("store(u")) << goes_on;
}

}  // namespace
}  // namespace sightline
