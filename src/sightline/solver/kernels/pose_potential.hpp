/// Potentials between two bodies in the solver's form: gradient and Hessian over the Sights of both
/// bodies.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sightline/formula/program.hpp"
#include "sightline/ocp/ocp.hpp"
#include "sightline/solver/kernels/stage.hpp"

namespace sightline {

/// Which of the two bodies are controlled, and on which the potentials act.
struct Ends {
  bool a_is_agent = true, b_is_agent = true;
  bool a_feels = true, b_feels = true;
};

/// h times a weighted sum of potentials over the Sights of a and b.
///
/// Relative form (frequent): the potential depends on r = p_a - p_b and the heading of a alone.
/// Then the variables are (r, d_a), 5 numbers; `derivatives` gives the gradient (5) and the upper
/// triangle of the Hessian (15); the entry lists are empty. Otherwise the variables are those of
/// (s_a, s_b, t, uncertainty of a, position of the third body) that occur.
struct PosePotential {
  static constexpr int relative_size = 5;
  /// s_a is 0 .. 9, s_b 10 .. 19; then variables independent of the inputs of a and b: the time,
  /// the uncertainty of a, the position of the third body.
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
  std::vector<Program> others;     ///< relative form: derivatives to be added, compiled separately
  std::vector<std::string> names;  ///< of the potentials in `derivatives`, then of each of `others`
  std::vector<First> gradient;     ///< for the bodies it acts on
  std::vector<Second> own;         ///< Hessian within a body it acts on, row <= column
  std::vector<Second> cross;       ///< Hessian between a (row) and b (column), if both are agents

  /// Components of the Sight of a or b that the potential depends on, including all preceding ones.
  Seen sees(bool of_b) const;
};

/// Treatment of a formula's numbers while it is traced.
enum class Numbers {
  known,       ///< folded as constants: shortest program, valid for these numbers only
  parameters,  ///< kept as parameters: one program for all numbers
};

/// @param terms  potentials between the same bodies, acting on the same agents; or of one robot
///   alone, a. Their order does not matter.
PosePotential trace_potential(std::span<const Weighted* const> terms, double h, const Ends& ends,
                              Numbers numbers = Numbers::known);

/// Whether a program was printed and compiled.
using IsCompiled = std::function<bool(const Program&)>;

/// Potential between two bodies, given by index in the team.
struct BodyPotential {
  int a = -1, b = -1;  ///< agents; -1: not controlled
  int body_a = -1, body_b = -1;
  int third = -1, third_body = -1;  ///< as a and body_a; -1: none
  Ends ends;
  PosePotential potential;
  Ramp ramp{};
};

/// The potentials of a team, pair by pair and robot by robot. The terms of a pair form one program
/// if it was compiled; else they split into compiled programs and a remainder with folded numbers.
std::vector<BodyPotential> trace_potentials(const Ocp& ocp, const IsCompiled& is_compiled = {});

/// h times the weighted potential of a swarm, over the difference of two poses (p_a - p_b, d_a -
/// d_b), 5 numbers. `derivatives` gives the gradient (5) and the upper triangle of the Hessian (15)
/// for a. For b the gradient is negated and the Hessian equal; the block between a and b is the
/// negated Hessian.
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
