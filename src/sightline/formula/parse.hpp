/// The formula language: parses text into an `Expression`, or throws an error that points at the
/// token.
///
///   limit     = sum  comparison sum  { comparison sum }       comparison: < <= > >=, a chain in one direction
///   sum       = product { ("+" | "-") product }
///   product   = signed { ("*" | "/") signed }
///   signed    = { "-" | "+" } power
///   power     = atom [ "^" signed ]                           from the right, before the sign: -x^2 = -(x^2)
///   atom      = number [unit] | name | function "(" sum { "," sum } ")" | "(" sum ")"
///   unit      = unit_power { "/" unit_power } | "/" unit_power { "/" unit_power }
///
/// Units are checked where they are given: a number without one fits anywhere. An even power undoes
/// a root: norm(x, y)^2 is x^2 + y^2, and no corner remains to smooth. docs/potentials.md lists the
/// functions.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/formula/expression.hpp"
#include "sightline/formula/lexer.hpp"

namespace sightline {

/// Limits of the input: nesting depth of brackets and powers, and number of steps.
inline constexpr int formula_depth_max = 100;
inline constexpr std::size_t formula_steps_max = 1000;

/// Names and their meaning: a variable or an expression.
using Vocabulary = std::map<std::string, Expression, std::less<>>;

/// Whether a user may give this name to a parameter: a word that is no function, unit or constant.
bool is_free_name(std::string_view name);

/// Parses a formula with one value.
/// @throws FormulaError
Expression parse_formula(std::string_view text, const Vocabulary& names);

/// Parses one or more comparisons into quantities c, with c <= 0 where the comparison holds: a < b
/// gives c = a - b. A chain a < b < c gives one quantity per sign.
/// @throws FormulaError
std::vector<Expression> parse_limits(std::string_view text, const Vocabulary& names);

struct Definition {
  std::string name, text;
};

/// Adds names defined by formulas, which may use each other in any order.
/// @throws FormulaError with `definition` set, for a definition that is no formula or depends on
///   itself
void define(Vocabulary& names, std::span<const Definition> definitions);

}  // namespace sightline
