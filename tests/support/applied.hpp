/// Applies inputs of a test's own to a world, through a gate whose limits are those of numbers.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "sightline/world.hpp"

namespace sightline::test {

/// Makes commands of any finite inputs; takes no memory after its construction.
class AnyCommand {
 public:
  explicit AnyCommand(const Team& team) : gate_(team, 0.01) {
    constexpr double most = std::numeric_limits<double>::max();
    for (const Agent& agent : team.agents())
      limits_.emplace_back(std::vector<double>(agent.R.size(), -most),
                           std::vector<double>(agent.R.size(), most));
    gate_.set_limits(limits_);
    gate_.open(0.0);
  }
  Command operator()(std::span<const double> u) { return gate_.pass(u, {}); }

 private:
  CommandGate gate_;
  std::vector<InputLimits> limits_;
};

inline bool apply(World& world, double t, std::span<const double> estimate, std::span<const double> u,
                  double period, std::int64_t periods) {
  return world.apply(t, estimate, AnyCommand(world.team())(u), period, periods);
}

}  // namespace sightline::test
