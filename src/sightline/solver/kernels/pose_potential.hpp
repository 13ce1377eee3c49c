/// The potentials between two bodies as the solver needs them: gradient and Hessian over what is seen of the
/// two.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sightline/formula/program.hpp"
#include "sightline/ocp/ocp.hpp"
#include "sightline/solver/kernels/stage.hpp"

namespace sightline {

/// Which of the two ends is there for the optimiser, and which feels the potentials.
struct Ends {
  bool a_is_agent = true, b_is_agent = true;
  bool a_feels = true, b_feels = true;
};

/// h times a weighted sum of potentials over the Sights of a and b.
///
/// In the frequent case it depends on r = p_a - p_b and the heading of a alone: then its variables are
/// (r, d_a), 5 numbers, `derivatives` gives the gradient (5) and the upper triangle of the Hessian (15), and
/// the entries are empty. Otherwise the variables are those of (s_a, s_b, t, uncertainty of a, place of the third body) that occur.
struct PosePotential {
  static constexpr int relative_size = 5;
  /// s_a is 0 .. 9, s_b 10 .. 19; then what no input of a or b changes, the time, the uncertainty of a, and where the third body is.
  static constexpr int time_variable = 2 * sight_size, uncertainty_variable = time_variable + 1,
                       third_variable = uncertainty_variable + 1, variable_count = third_variable + 3;

  struct First {
    int variable, output;
    bool negative;
  };
  struct Second {
    int row, column, output;
    bool negative;
  };

  bool relative = false;
  std::vector<int>
      variables;        ///< of (s_a, s_b, t, uncertainty, third), inputs of both programs in this order
  Program value;        ///< one output
  Program derivatives;  ///< every entry of the lists below, once up to sign
  std::vector<Program> others;     ///< of a relative one: derivatives to be added, compiled apart
  std::vector<std::string> names;  ///< of the potentials in `derivatives`, then in each of the others
  std::vector<First> gradient;     ///< of the ends that feel it
  std::vector<Second> own;         ///< Hessian within an end that feels it, row <= column
  std::vector<Second> cross;       ///< Hessian between a (row) and b (column), where both are agents

  /// What of that end occurs, and with it what comes before.
  Seen sees(bool of_b) const;
};

/// What the numbers of a formula are while it is traced.
enum class Numbers {
  known,       ///< they fold: the shortest program, good for these numbers alone
  parameters,  ///< the program of every such formula, whatever its numbers
};

/// @param terms  potentials between the same bodies, felt by the same agents; or of one robot alone, a. Their
///               order does not matter.
PosePotential trace_potential(std::span<const Weighted* const> terms, double h, const Ends& ends,
                              Numbers numbers = Numbers::known);

/// Whether a program was printed and compiled.
using IsCompiled = std::function<bool(const Program&)>;

/// Potentials between two bodies that are alike, by index in the team.
struct BodyPotential {
  int a = -1, b = -1;  ///< agents, or -1: not controlled
  int body_a = -1, body_b = -1;
  int third = -1, third_body = -1;  ///< as a and body_a; -1: none
  Ends ends;
  PosePotential potential;
  Ramp ramp{};
};

/// The potentials of a team, pair by pair and robot by robot. The terms of a pair are one program if that was
/// compiled; else they fall into those that were, and a rest with its numbers known.
std::vector<BodyPotential> trace_potentials(const Ocp& ocp, const IsCompiled& is_compiled = {});

/// h times the weighted potential of a swarm, over the difference of two poses (p_a - p_b, d_a - d_b), 5 numbers;
/// `derivatives` gives the gradient (5) and the upper triangle of the Hessian (15) for a, and for b its mirror image:
/// the gradient negated, the same Hessian, and between the two the Hessian negated.
struct SwarmPotential {
  std::vector<int> agents;  ///< in the order of the team's agents
  double radius = 0.0;
  int capacity = 0;
  bool sees_headings = false;
  std::string name;
  Program value, derivatives;
};

SwarmPotential trace_swarm(const Weighted& term, double h, Numbers numbers);
std::vector<SwarmPotential> trace_swarms(const Ocp& ocp, const IsCompiled& is_compiled = {});

}  // namespace sightline
