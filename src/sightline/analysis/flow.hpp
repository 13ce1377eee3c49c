/// Gradient flow of robots, each by its own cost: it ends in an equilibrium or drifts without
/// bound.
///
/// Each robot follows its own negative gradient, p_i' = -d F_i / d p_i, psi_i' = -d F_i / d psi_i.
/// F_i is the sum of the potentials that act on robot i and of its tracking cost. An equilibrium in
/// flight is an equilibrium of the flow. Different costs need have no common equilibrium: two
/// robots that observe each other with cameras pitched down both reduce their cost by being the
/// higher one.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sightline/formula.hpp"
#include "sightline/team.hpp"

namespace sightline {

/// A body of a flow.
struct Drifting {
  Vec3<double> p{};            ///< [m]
  double psi = 0.0;            ///< [rad]
  std::array<bool, 4> free{};  ///< x, y, z, psi: what the body can change
};

/// Keeps a body near a place by the cost
/// sum of q_i (p_i - place_i)^2 + q_psi (1 - cos(psi - heading)).
struct Hold {
  std::size_t body;
  Vec3<double> place, q;
  double heading = 0.0, q_psi = 0.0;
};

/// Result of a flow.
struct FlowEnd {
  std::vector<Drifting> bodies;
  std::optional<Vec3<double>> drift{};  ///< motion of the movable bodies' centre over the last
                                        ///< sixth [m]; none: they rest
};

class Flow {
 public:
  explicit Flow(std::vector<Drifting> bodies) : bodies_(std::move(bodies)) {}

  /// Adds a potential between two bodies, or of one body with itself. Its gradient moves body a if
  /// felt_by_a, and body b if felt_by_b.
  void add(const Weighted& term, std::size_t a, std::size_t b, bool felt_by_a, bool felt_by_b);
  void add(const Hold& hold) { holds_.push_back(hold); }

  /// Follows the flow for about `steps` steps of at most 0.1 m each. Set-up: allocates.
  FlowEnd settle(int steps = 1500) const;

 private:
  struct Term {
    std::size_t formula, a, b;
    double weight;
    bool felt_by_a, felt_by_b;
  };
  /// Equal potentials share their derivatives.
  struct Known {
    Program value, derivatives;
  };

  std::vector<Drifting> bodies_;
  std::vector<Term> terms_;
  std::vector<Known> formulas_;
  std::vector<Hold> holds_;
};

/// Flow of the robots `moving` of a team; all other bodies stay at the states x0 (team.nx()).
/// References are those of t = 0; an axis with a position weight starts at its reference.
Flow flow_of(const Team& team, std::span<const double> x0, std::span<const AgentId> moving);

}  // namespace sightline
