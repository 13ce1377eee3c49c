/// Offsets of each agent's numbers in the arrays of a team: groups in sequence, each
/// [stage][entry][lane].
#pragma once

#include <cstddef>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {

struct Layout {
  struct Part {
    int nu = 0, ns = 0;                  ///< entries per stage of u and of s
    std::ptrdiff_t u = 0, s = 0, c = 0;  ///< first number in the arrays of u, of s and of the couplings' c
    int turn = 0;                        ///< groups of one turn are visited together
    int nc() const { return ns + ns * (ns + 1) / 2; }
  };
  struct Place {
    int group = 0, lane = 0;
  };
  /// A group's numbers in an array, whole packs.
  struct Span {
    std::ptrdiff_t first;
    int length;
    std::ptrdiff_t end() const { return first + length; }
  };
  /// Strided view of one agent: entry i of stage k is at first + k stage + i width.
  struct View {
    std::ptrdiff_t first = 0, stage = 0;
    int width = 0;
    std::ptrdiff_t operator()(int k, int i) const { return first + k * stage + i * width; }
  };

  int stages = 0, width = 0;
  std::vector<Part> groups{};
  std::vector<Place> agents{};                   ///< in the order of the team's agents
  int u_length = 0, s_length = 0, c_length = 0;  ///< whole packs

  void add(int nu, int ns) {
    groups.push_back({nu, ns, u_length, s_length, c_length});
    const int group = static_cast<int>(groups.size()) - 1;
    u_length += u_of(group).length;
    s_length += s_of(group).length;
    c_length += padded(stages * groups.back().nc() * width);
  }

  Span u_of(int group) const {
    const Part& g = groups[static_cast<std::size_t>(group)];
    return {g.u, padded(stages * g.nu * width)};
  }
  Span s_of(int group) const {
    const Part& g = groups[static_cast<std::size_t>(group)];
    return {g.s, padded(stages * g.ns * width)};
  }
  View u(int agent) const {
    const Part& g = part(agent);
    return {g.u + place(agent).lane, g.nu * width, width};
  }
  View s(int agent) const {
    const Part& g = part(agent);
    return {g.s + place(agent).lane, g.ns * width, width};
  }
  View c(int agent) const {
    const Part& g = part(agent);
    return {g.c + place(agent).lane, g.nc() * width, width};
  }
  const Place& place(int agent) const { return agents[static_cast<std::size_t>(agent)]; }
  const Part& part(int agent) const { return groups[static_cast<std::size_t>(place(agent).group)]; }
};

}  // namespace sightline
