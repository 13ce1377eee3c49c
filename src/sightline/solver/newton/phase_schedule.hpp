/// Order of the phases of all groups that keeps the results of one phase cached for the next.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {

/// A phase of a group depends on the previous phase of the group and of its neighbours; it runs as
/// soon as these are done. Each thread first advances a contiguous range of groups as far as
/// dependencies allow; the next round covers the range boundaries, until all phases are done.
class PhaseSchedule {
 public:
  /// @param neighbours  pairs of adjacent groups; may repeat, and may pair a group with itself
  PhaseSchedule(int groups, std::span<const std::pair<int, int>> neighbours, int phases, int threads);

  /// Calls phase(group, thread) for each group, once per phase of the constructor; the result is
  /// independent of the threads.
  template <class... Phase>
  void run(ThreadPool& pool, Phase&&... phases) const noexcept {
    for (const Round& round : rounds_) {
      pool.share(static_cast<int>(round.size()), [&](int part, int thread) noexcept {
        for (const Task& task : round[static_cast<std::size_t>(part)]) {
          int phase = 0;
          ((task.phase == phase++ ? phases(task.group, thread) : void()), ...);
        }
      });
    }
  }

  /// One phase of one group.
  struct Task {
    int phase, group;
  };
  /// Tasks per part, in order; the parts of one round are independent.
  using Round = std::vector<std::vector<Task>>;
  std::span<const Round> rounds() const { return rounds_; }

 private:
  std::vector<Round> rounds_;
};

}  // namespace sightline
