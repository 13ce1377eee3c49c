#include "sightline/solver/newton/phase_schedule.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <mutex>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

TEST(PhaseSchedule, APhaseFollowsThatBeforeOfTheGroupAndItsNeighboursAndEachIsDoneOnce) {
  Random random(1);
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    for (int trial = 0; trial < 30; ++trial) {
      const int groups = 1 + static_cast<int>(random() % 60);
      Pairs neighbours;
      for (int a = 0; a < groups; ++a) {
        for (int b = 0; b <= a; ++b)
          if (random() % (trial % 2 == 0 ? 4 : 40) == 0) neighbours.emplace_back(a, b);
      }
      const PhaseSchedule<3> schedule(groups, neighbours, threads);
      std::mutex mutex;
      std::vector<int> done(static_cast<std::size_t>(groups), 0);  // phases of each group
      const auto of = [&](int g) -> int& { return done[static_cast<std::size_t>(g)]; };
      const auto phase = [&](int number) {
        return [&, number](int g, int) noexcept {
          const std::lock_guard lock(mutex);
          EXPECT_EQ(of(g), number);
          for (const auto& [a, b] : neighbours) {
            if (a != g && b != g) continue;
            EXPECT_GE(of(a == g ? b : a), number) << "group " << g << " of " << groups;
          }
          ++of(g);
        };
      };
      schedule.run(pool, phase(0), phase(1), phase(2));
      EXPECT_EQ(done, std::vector<int>(static_cast<std::size_t>(groups), 3));
    }
  }
}

TEST(PhaseSchedule, AlongAChainNoGroupWaitsLongForItsNextPhase) {
  constexpr int groups = 128, phases = 5;
  Pairs chain;
  for (int g = 0; g + 1 < groups; ++g) chain.emplace_back(g, g + 1);
  for (const int threads : {1, 2}) {
    const PhaseSchedule<phases> schedule(groups, chain, threads);
    EXPECT_LE(schedule.rounds.size(), 2u);
    int waited = 0;                     // for another round
    std::vector<int> last(groups, -1);  // place among the tasks of its part
    for (const PhaseRound& round : schedule.rounds) {
      std::fill(last.begin(), last.end(), -1);
      for (const std::vector<PhaseTask>& part : round) {
        for (std::size_t i = 0; i < part.size(); ++i) {
          int& before = last[static_cast<std::size_t>(part[i].group)];
          waited += part[i].phase > 0 && before < 0;
          if (before >= 0) {
            EXPECT_LE(static_cast<int>(i) - before, 4 * phases);
          }
          before = static_cast<int>(i);
        }
      }
    }
    EXPECT_LE(waited, threads == 1 ? 0 : groups / 2);
  }
}

}  // namespace
}  // namespace sightline
