/// An order of the phases of all groups in which what one phase has computed is still near in the cache for the next.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "sightline/math/crew.hpp"

namespace sightline {

/// Each phase of a group goes on from what the phase before came to in the group and in its neighbours. A thread alone takes a group's
/// next phase as soon as these have theirs behind them, several threads share phase by phase; the result is the same.
class Wave {
 public:
  /// @param neighbours  groups next to each other; a pair may be there more than once, or be a group with itself
  Wave(int groups, std::span<const std::pair<int, int>> neighbours, int phases);

  /// phase(group, thread) for each group, of as many phases as it was made for.
  template <class... Phase>
  void run(Crew& crew, Phase&&... phases) const noexcept {
    if (crew.threads() > 1) {
      (crew.share(groups_, phases), ...);
      return;
    }
    for (const Task& task : order_) {
      int phase = 0;
      ((task.phase == phase++ ? phases(task.group, 0) : void()), ...);
    }
  }

  /// One group's part of a phase.
  struct Task {
    int phase, group;
  };
  std::span<const Task> order() const { return order_; }

 private:
  int groups_;
  std::vector<Task> order_;
};

}  // namespace sightline
