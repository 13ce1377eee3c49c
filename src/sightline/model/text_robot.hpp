/// A user-defined robot as text: x' = f(x, u) in the formula language, with names for states and
/// inputs.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "sightline/formula/parse.hpp"
#include "sightline/model/model.hpp"

namespace sightline {

/// Maximum numbers of states and inputs of a text robot.
inline constexpr std::size_t text_states_max = 16, text_inputs_max = 8;

/// Definition of a robot by formulas. A car, as an example:
///
///   TextRobot{.states = {"p_x", "p_y", "p_z", "psi", "v"},
///             .inputs = {"a", "w"},
///             .f = {"v * cos(psi)", "v * sin(psi)", "0", "w", "a - drag * v"},
///             .position = {"p_x", "p_y", "p_z"},
///             .heading = {"psi"},
///             .parameters = {{"drag", "0.5"}}}
///
/// All numbers are in SI units; f may use the states, the inputs and the parameters. Corners (abs,
/// min, max, norm) are smoothed over 1e-6. The robot runs in the interpreter and gives the same
/// bits as a struct with the same formulas.
struct TextRobot {
  std::string name = "text";
  std::vector<std::string> states, inputs;  ///< unique names
  std::vector<std::string> f;               ///< the rate of each state
  std::array<std::string, 3> position;      ///< names of the states p_x, p_y and p_z in G [m]
  std::vector<std::string> heading{};  ///< name of the state psi [rad], or the two of d; empty: along x of G
  std::vector<Definition> parameters{};  ///< numbers, or formulas of other parameters
  std::vector<double> u_min{},
      u_max{};  ///< limits of the inputs, which the team may override; empty: -1 and 1

  /// The names that its formulas may use.
  /// @throws FormulaError for a parameter, std::invalid_argument for an invalid name of a state or
  /// an input
  Vocabulary vocabulary() const;
  /// @throws as vocabulary(); FormulaError for a rate; std::invalid_argument for inconsistent sizes
  /// or names
  Model model() const;
  /// The same from recorded rates, over states, then inputs; the rates in `f` are not used, and
  /// `parameters` are only checked.
  /// @throws as vocabulary(); std::invalid_argument for inconsistent sizes or names
  Model model(std::vector<Expression> rates) const;
};

}  // namespace sightline
