/// An order of the phases of all groups in which what one phase has computed is still near in the cache for the next.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "sightline/base/thread_pool.hpp"

namespace sightline {

/// Each phase of a group goes on from what the phase before came to in the group and in its neighbours. So a group's next phase is taken as
/// soon as these have theirs behind them. Several threads take stretches of groups as far as each goes by itself; then, in the next
/// round, stretches across the ends of those, until all is done.
class PhaseSchedule {
 public:
  /// @param neighbours  groups next to each other; a pair may be there more than once, or be a group with itself
  PhaseSchedule(int groups, std::span<const std::pair<int, int>> neighbours, int phases, int threads);

  /// phase(group, thread) for each group, of as many phases as it was made for; the result does not depend on the threads.
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

  /// One group's part of a phase.
  struct Task {
    int phase, group;
  };
  /// Of each part the tasks, one after the other; a part needs nothing of the others of its round.
  using Round = std::vector<std::vector<Task>>;
  std::span<const Round> rounds() const { return rounds_; }

 private:
  std::vector<Round> rounds_;
};

}  // namespace sightline
