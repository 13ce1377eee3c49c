#include "sightline/solver/newton/cross_blocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "sightline/potentials.hpp"
#include "sightline/solver/newton/groups.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

/// Robots that move as the one before them does, some felt by both: every product is the sum of its entries, pair by pair.
template <int W>
void expect_sums(Random& random) {
  constexpr int n = W == native_width ? 11 : W;
  Team team;
  std::vector<AgentId> ids;
  for (int i = 0; i < n; ++i) ids.push_back(team.add(Multirotor{}));
  for (std::size_t i = 1; i < ids.size(); ++i)
    team.couple(0.1 * RelativeVelocity{}, {ids[i], ids[i - 1]},
                i % 3 == 0 ? felt_by({ids[i], ids[i - 1]}) : felt_by(ids[i]));
  const Ocp ocp(team, {.T = 0.5, .N = 5, .dt = 0.01});
  const std::vector<BodyPotential> potentials = trace_potentials(ocp);
  const Groups dealt(ocp, potentials, KernelChoice::interpreted);
  const Layout& layout = dealt.layout();
  ASSERT_EQ(layout.width, W);
  std::vector<PairBatch> batches;
  for (const BodyPotential& pair : potentials) {
    auto batch =
        std::find_if(batches.begin(), batches.end(), [&](const PairBatch& b) { return b.suits(pair); });
    if (batch == batches.end()) {
      batches.push_back({{}, Points(pair.potential, KernelChoice::interpreted)});
      batch = batches.end() - 1;
    }
    batch->pairs.push_back(&pair);
  }
  CrossBlocks<W> blocks(batches, layout, KernelChoice::interpreted);
  const StageParameters parameters{Rows(sight_size * n, layout.stages), Rows(1, layout.stages),
                                   Rows(n, layout.stages)};
  Rows s(3, layout.s_length);
  for (int i = 0; i < layout.s_length; ++i)
    s[0][i] = uniform(random, -1.0, 1.0), s[1][i] = uniform(random, -1.0, 1.0);
  std::vector<double> expected(static_cast<std::size_t>(layout.s_length), 0.0);
  int entries = 0;
  for (std::size_t b = 0; b < batches.size(); ++b) {
    PairBatch& batch = batches[b];
    batch.points.resize(static_cast<int>(batch.pairs.size()) * layout.stages);
    batch.gather(layout, parameters, s[0]);
    batch.points.derive();
    blocks.take(b);
    for (std::size_t p = 0; p < batch.pairs.size(); ++p) {
      const BodyPotential& pair = *batch.pairs[p];
      const Layout::View a = layout.s(pair.a), of_b = layout.s(pair.b);
      for (const PosePotential::Second& h : batch.pairs[0]->potential.cross) {
        for (int k = 0; k < layout.stages; ++k) {
          const double value =
              *batch.points.out(static_cast<int>(p) * layout.stages + k, h.output) * (h.negative ? -1 : 1);
          const std::ptrdiff_t i = a(k, h.row), j = of_b(k, h.column - sight_size);
          if (pair.ends.a_feels) expected[static_cast<std::size_t>(i)] += value * s[1][j];
          if (pair.ends.b_feels) expected[static_cast<std::size_t>(j)] += value * s[1][i];
          ++entries;
        }
      }
    }
  }
  EXPECT_GT(entries, 0);
  blocks.product(s[1], s[2]);
  for (int i = 0; i < layout.s_length; ++i)
    EXPECT_NEAR(s[2][i], expected[static_cast<std::size_t>(i)], 1e-14) << i;
  std::fill_n(s[2], layout.s_length, 0.0);
  for (int g = 0; g < static_cast<int>(layout.groups.size()); ++g) blocks.product(g, s[1], s[2]);
  for (int i = 0; i < layout.s_length; ++i)
    EXPECT_NEAR(s[2][i], expected[static_cast<std::size_t>(i)], 1e-14) << i;
}

TEST(CrossBlocks, AProductIsTheSumOfItsEntriesPairByPair) {
  Random random(1);
  for (int trial = 0; trial < 5; ++trial)
    expect_sums<narrow_width>(random), expect_sums<native_width>(random);
}

}  // namespace
}  // namespace sightline
