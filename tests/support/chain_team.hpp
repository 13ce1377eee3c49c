/// A chain of robots: the leader, uav0, flies the circle; every other observes the one before it.
#pragma once

#include "sightline/solvers.hpp"
#include "tests/support/paper_team.hpp"

namespace sightline {

/// @param robots  in the order in which they stand in the team; robot i observes robot i - 1
inline Team chain_of(const std::vector<int>& robots, paper::Variant variant) {
  Team team;
  for (const int i : robots) {
    paper::Options options = i == 0 ? paper::target() : paper::observer();
    options.name = "uav" + std::to_string(i);
    team.add(Multirotor{}, options);
  }
  for (const int i : robots) {
    const AgentId watcher{team.find("uav" + std::to_string(i))},
        seen{team.find("uav" + std::to_string(i - 1))};
    if (i == 0 || seen.index < 0) continue;
    const auto who = variant == paper::Variant::joint ? felt_by({watcher, seen}) : felt_by(watcher);
    team.couple(0.4 * SensorCone{}, Between{watcher, seen}, who);
    team.couple(0.4 * KeepOut{}, Between{watcher, seen}, who);
    team.couple(0.4 * Cohesion{}, Between{watcher, seen}, who);
  }
  return team;
}

inline Team chain(int n, paper::Variant variant) {
  std::vector<int> robots;
  for (int i = 0; i < n; ++i) robots.push_back(i);
  return chain_of(robots, variant);
}

/// The robot that joins behind one in that state: at its place in the chain, looking ahead.
inline std::vector<double> behind(std::span<const double> last) {
  return {last[0] - 1.5, last[1], last[2] + 0.375, 1, 0, 0, 0};
}

inline std::vector<double> chain_start(int n) {
  std::vector<double> x = {0, 0, 0.5, 1, 0, 0, 0};
  for (int i = 1; i < n; ++i) {
    const std::vector<double> next = behind(std::span<const double>(x).last(7));
    x.insert(x.end(), next.begin(), next.end());
  }
  return x;
}

/// Neighbours of the chain together, as many parts as are asked for.
inline Partition even_parts(const Team& team, int parts) {
  Partition partition(static_cast<std::size_t>(parts));
  const int robots = static_cast<int>(team.agents().size());
  for (int i = 0; i < robots; ++i)
    partition[static_cast<std::size_t>(i * parts / robots)].push_back(AgentId{{i}});
  return partition;
}

}  // namespace sightline
