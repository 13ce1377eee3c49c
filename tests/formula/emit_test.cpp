#include <gtest/gtest.h>

#include <array>

#include "sightline/formula.hpp"

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

}  // namespace
}  // namespace sightline
