/// The weights in a scenario's text that act on some robots.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sightline/scenario.hpp"

namespace sightline {

/// A weight in the text, and the weights of the team that depend on it: one, or those of all robots
/// or couplings of a template or a range.
struct WeightInText {
  std::string key;  ///< as in error messages: "couple[0].weight", "agent.uav0.R[3]"
  NumberInText number;
  /// Names as of InputGradient::parameters(), and their derivatives by the number.
  std::vector<std::pair<std::string, double>> slopes;
};

/// The weights > 0 of costs, couplings and constraints that act on one of the robots.
/// @param without  keys that are left out
/// @throws ScenarioError if the text cannot be read
std::vector<WeightInText> weights_of(const Scenario& scenario, std::span<const BodyId> robots,
                                     std::span<const std::string> without);

}  // namespace sightline
