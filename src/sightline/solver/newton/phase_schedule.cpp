#include "sightline/solver/newton/phase_schedule.hpp"

#include <algorithm>
#include <set>

#include "sightline/base.hpp"

namespace sightline {
namespace {

using Near = std::vector<std::set<int>>;  // each group and its neighbours

constexpr int few = 8;  // groups whose data stay in the cache between phases

Near near_of(int groups, GroupPairs neighbours) {
  Near near(at(groups));
  for (int g = 0; g < groups; ++g) near[at(g)].insert(g);
  for (const auto& [a, b] : neighbours) near[at(a)].insert(b), near[at(b)].insert(a);
  return near;
}

/// Order of the tasks on one thread.
std::vector<PhaseTask> order_of(const Near& near, int phases) {
  const int groups = static_cast<int>(near.size());
  std::vector<PhaseTask> order;
  if (groups <= few) {
    for (int phase = 0; phase < phases; ++phase) {
      for (int g = 0; g < groups; ++g) order.push_back({phase, g});
    }
    return order;
  }
  // [phase][group]: unfinished dependencies in the previous phase
  std::vector<std::vector<int>> waits(at(phases));
  for (std::vector<int>& of_groups : waits) {
    for (const std::set<int>& its : near) of_groups.push_back(static_cast<int>(its.size()));
  }
  std::vector<PhaseTask> due;
  for (int g = 0; g < groups; ++g) {
    due.push_back({0, g});
    while (!due.empty()) {
      const PhaseTask task = due.back();
      due.pop_back();
      order.push_back(task);
      const int next = task.phase + 1;
      if (next == phases) continue;
      for (const int group : near[at(task.group)]) {
        if (--waits[at(next)][at(group)] == 0) due.push_back({next, group});
      }
    }
  }
  return order;
}

}  // namespace

std::vector<PhaseRound> phase_rounds(int groups, GroupPairs neighbours, int phases, int threads) {
  constexpr int for_each = 4;  // parts per thread: other threads take over parts of a delayed one
  const Near near = near_of(groups, neighbours);
  std::vector<PhaseTask> left = order_of(near, phases);
  const int parts = threads == 1 ? 1 : std::clamp(groups / few, 1, for_each * threads);
  // Round and part in which each phase of each group is done.
  struct Place {
    int round = -1, part = -1;
  };
  std::vector<std::vector<Place>> done(at(phases), std::vector<Place>(at(groups)));
  std::vector<PhaseRound> rounds;
  for (int round = 0; !left.empty(); ++round) {
    const int shift = round % 2 == 0 ? 0 : groups / (2 * parts);
    PhaseRound& tasks = rounds.emplace_back(at(parts));
    std::vector<PhaseTask> later;
    for (const PhaseTask& task : left) {
      const int part = (task.group + shift) % groups * parts / groups;
      const auto is_ready = [&](int group) {
        const Place& before = done[at(task.phase - 1)][at(group)];
        return before.round >= 0 && (before.round < round || before.part == part);
      };
      if (task.phase > 0 &&
          !std::all_of(near[at(task.group)].begin(), near[at(task.group)].end(), is_ready)) {
        later.push_back(task);
        continue;
      }
      tasks[at(part)].push_back(task);
      done[at(task.phase)][at(task.group)] = {round, part};
    }
    left = std::move(later);
  }
  return rounds;
}

}  // namespace sightline
