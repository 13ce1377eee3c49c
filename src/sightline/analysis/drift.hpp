/// Gradient flow of robots, each by its own cost alone: it ends in an equilibrium, or drifts for ever.
///
/// Each robot follows its own negative gradient, p_i' = -d F_i / d p_i, psi_i' = -d F_i / d psi_i, with F_i the sum of
/// the potentials that i feels and of its own tracking. A rest in flight is one of the flow. Different costs need have
/// no common equilibrium: two robots that look down at each other both minimise their cost by being the higher one.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sightline/formula/interpret.hpp"
#include "sightline/ocp/team.hpp"

namespace sightline {

/// A body of a flow.
struct Drifting {
  Vec3<double> p{};            ///< [m]
  double psi = 0.0;            ///< [rad]
  std::array<bool, 4> free{};  ///< x, y, z, psi: what the body can change
};

/// Keeps a body near a place: sum of q_i (p_i - place_i)^2, and q_psi (1 - cos(psi - heading)).
struct Hold {
  std::size_t body;
  Vec3<double> place, q;
  double heading = 0.0, q_psi = 0.0;
};

/// Where a flow ended.
struct FlowEnd {
  std::vector<Drifting> bodies;
  std::optional<Vec3<double>> drift{};  ///< of those that can move, over the last sixth [m]; none: they rest
};

class Flow {
 public:
  explicit Flow(std::vector<Drifting> bodies) : bodies_(std::move(bodies)) {}

  /// A potential between two bodies, or of one with itself, felt by those.
  void add(const Weighted& term, std::size_t a, std::size_t b, bool felt_by_a, bool felt_by_b);
  void add(const Hold& hold) { holds_.push_back(hold); }

  /// Follows it until it rests, or for `steps` steps of 0.1 m at most. Set-up: allocates.
  FlowEnd settle(int steps = 1500) const;

 private:
  struct Term {
    std::size_t formula, a, b;
    double weight;
    bool felt_by_a, felt_by_b;
  };
  /// Potentials that are equal share their derivatives.
  struct Known {
    Program value, derivatives;
  };

  std::vector<Drifting> bodies_;
  std::vector<Term> terms_;
  std::vector<Known> formulas_;
  std::vector<Hold> holds_;
};

/// The flow of some robots of a team, all others staying where the states x0 (team.nx()) have them. References are
/// those of t = 0; who has one begins there.
Flow flow_of(const Team& team, std::span<const double> x0, std::span<const AgentId> moving);

}  // namespace sightline
