/// A robot of one's own as text: x' = f(x, u) in the formula language, with names for states and inputs.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "sightline/formula/parse.hpp"
#include "sightline/model/model.hpp"

namespace sightline {

/// Most states and inputs of a robot that is text.
inline constexpr std::size_t text_states_max = 16, text_inputs_max = 8;

/// A car, as an example:
///
///   TextRobot{.states = {"p_x", "p_y", "p_z", "psi", "v"},
///             .inputs = {"a", "w"},
///             .f = {"v * cos(psi)", "v * sin(psi)", "0", "w", "a - drag * v"},
///             .position = {"p_x", "p_y", "p_z"},
///             .heading = {"psi"},
///             .parameters = {{"drag", "0.5"}}}
///
/// All is in SI units; f may use the states, the inputs and the parameters. Its corners (abs, min, max, norm) are
/// rounded off over 1e-6. The robot runs interpreted, to the same bits as a struct of its formulas would.
struct TextRobot {
  std::string name = "text";
  std::vector<std::string> states, inputs;  ///< each a name of its own
  std::vector<std::string> f;               ///< the rate of each state
  std::array<std::string, 3> position;      ///< the states that are p_x, p_y and p_z in G [m]
  std::vector<std::string>
      heading{};  ///< the state psi [rad], or the two of the direction; none: along x of G
  std::vector<Definition> parameters{};  ///< numbers or formulas of others
  std::vector<double> u_min{},
      u_max{};  ///< limits of the inputs unless the team says otherwise; empty: -1 and 1

  /// The names that its formulas may use.
  /// @throws FormulaError for a parameter, std::invalid_argument for a name of a state or an input
  Vocabulary vocabulary() const;
  /// @throws as vocabulary(), FormulaError for a rate, std::invalid_argument for what does not fit together
  Model model() const;
  /// The same of rates that were recorded elsewhere than from text, over states, then inputs; `f` and `parameters` are not read.
  /// @throws std::invalid_argument for a name of a state or an input, and for what does not fit together
  Model model(std::vector<Expression> rates) const;
};

}  // namespace sightline
