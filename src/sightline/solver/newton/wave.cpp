#include "sightline/solver/newton/wave.hpp"

#include <set>

#include "sightline/base/index.hpp"

namespace sightline {

Wave::Wave(int groups, std::span<const std::pair<int, int>> neighbours, int phases) : groups_(groups) {
  constexpr int few = 8;  // groups that stay in the cache from phase to phase
  if (groups <= few) {
    for (int phase = 0; phase < phases; ++phase) {
      for (int g = 0; g < groups; ++g) order_.push_back({phase, g});
    }
    return;
  }
  std::vector<std::set<int>> near(at(groups));  // each group and its neighbours
  for (int g = 0; g < groups; ++g) near[at(g)].insert(g);
  for (const auto& [a, b] : neighbours) near[at(a)].insert(b), near[at(b)].insert(a);
  std::vector<std::vector<int>> waits(at(phases));  // [phase][group]: for how many, in the phase before
  for (std::vector<int>& of_groups : waits) {
    for (const std::set<int>& its : near) of_groups.push_back(static_cast<int>(its.size()));
  }
  std::vector<Task> due;
  for (int g = 0; g < groups; ++g) {
    due.push_back({0, g});
    while (!due.empty()) {
      const Task task = due.back();
      due.pop_back();
      order_.push_back(task);
      const int next = task.phase + 1;
      if (next == phases) continue;
      for (const int group : near[at(task.group)]) {
        if (--waits[at(next)][at(group)] == 0) due.push_back({next, group});
      }
    }
  }
}

}  // namespace sightline
