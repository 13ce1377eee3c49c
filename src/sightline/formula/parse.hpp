/// The language of formulas: text becomes an `Expression`, or a refusal that points at the token.
///
///   limit     = sum  comparison sum  { comparison sum }       comparison: < <= > >=, a chain in one direction
///   sum       = product { ("+" | "-") product }
///   product   = signed { ("*" | "/") signed }
///   signed    = { "-" | "+" } power
///   power     = atom [ "^" signed ]                           from the right, before the sign: -x^2 = -(x^2)
///   atom      = number [unit] | name | function "(" sum { "," sum } ")" | "(" sum ")"
///   unit      = unit_power { "/" unit_power } | "/" unit_power { "/" unit_power }
///
/// Units are checked where they are given: a number without one fits anywhere. A power of two undoes a root:
/// norm(x, y)^2 is x^2 + y^2, and no corner is left to smooth. docs/potentials.md has the functions.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/formula/expression.hpp"
#include "sightline/formula/lexer.hpp"

namespace sightline {

/// Limits of what is read: of brackets and powers within each other, of steps.
inline constexpr int formula_depth_max = 100;
inline constexpr std::size_t formula_steps_max = 1000;

/// Names and what they stand for, a variable or an expression.
using Vocabulary = std::map<std::string, Expression, std::less<>>;

/// Whether a person may give this name to a parameter: a word that is no function, unit or constant.
bool is_free_name(std::string_view name);

/// A formula of one value.
/// @throws FormulaError
Expression parse_formula(std::string_view text, const Vocabulary& names);

/// One or more comparisons as quantities c that are <= 0 where they hold: a < b is c = a - b. A chain
/// a < b < c gives one for each sign.
/// @throws FormulaError
std::vector<Expression> parse_limits(std::string_view text, const Vocabulary& names);

struct Definition {
  std::string name, text;
};

/// Adds names that stand for formulas, which may use each other, in any order.
/// @throws FormulaError, `definition` set, for one that is no formula or that needs itself
void define(Vocabulary& names, std::span<const Definition> definitions);

}  // namespace sightline
