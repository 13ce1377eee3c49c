/// Order of the phases of all groups that keeps the results of one phase cached for the next.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {

/// One phase of one group.
struct PhaseTask {
  int phase, group;
};
/// Tasks per part, in order; the parts of one round are independent.
using PhaseRound = std::vector<std::vector<PhaseTask>>;
using GroupPairs = std::span<const std::pair<int, int>>;
std::vector<PhaseRound> phase_rounds(int groups, GroupPairs neighbours, int phases, int threads);

/// A phase of a group depends on the previous phase of the group and of its neighbours; it runs as
/// soon as these are done. Each thread first advances a contiguous range of groups as far as
/// dependencies allow; the next round covers the range boundaries, until all phases are done.
template <int phases>
struct PhaseSchedule {
  /// @param neighbours  pairs of adjacent groups; may repeat, and may pair a group with itself
  PhaseSchedule(int groups, GroupPairs neighbours, int threads)
      : rounds(phase_rounds(groups, neighbours, phases, threads)) {}

  /// Calls phase(group, thread) for each group and phase; the result is independent of the threads.
  template <class... Phase>
  void run(ThreadPool& pool, Phase&&... phase) const noexcept {
    static_assert(sizeof...(Phase) == phases, "expected one function per phase");
    for (const PhaseRound& round : rounds) {
      pool.share(static_cast<int>(round.size()), [&](int part, int thread) noexcept {
        for (const PhaseTask& task : round[static_cast<std::size_t>(part)]) {
          int number = 0;
          ((task.phase == number++ ? phase(task.group, thread) : void()), ...);
        }
      });
    }
  }

  std::vector<PhaseRound> rounds;
};

}  // namespace sightline
