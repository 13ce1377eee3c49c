/// Texts that are formulas, nearly are, or are not at all.
#pragma once

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>

#include "sightline/formula.hpp"
#include "tests/support/random.hpp"

namespace sightline {

/// x, y, z [m], t [s], k without a unit.
inline Vocabulary small_vocabulary() {
  Vocabulary names;
  int index = 0;
  for (const char* name : {"x", "y", "z"}) names.emplace(name, Expression::variable(index++, units::length));
  names.emplace("t", Expression::variable(index++, units::time));
  names.emplace("k", Expression::constant(0.5, {}));
  define(names, std::vector<Definition>{{"range", "norm(x, y, z)"}});
  return names;
}
inline constexpr int small_vocabulary_size = 4;

/// A formula by the grammar, its units aside, at most `depth` deep.
inline std::string formula_text(Random& random, int depth) {
  const auto inner = [&] { return formula_text(random, depth - 1); };
  const auto any = [&](auto&... words) {
    const std::array<std::string_view, sizeof...(words)> list = {words...};
    return std::string(list[random() % list.size()]);
  };
  if (depth <= 0) return any("x", "y", "z", "k", "range", "2", "0.5 m", "1e-3", "30 deg", "pi", "2/s", "-7");
  switch (random() % 6) {
    case 0:
      return fmt::format("{}{}{}", inner(), any(" + ", " - ", "*", " / "), inner());
    case 1:
      return fmt::format("({}){}", inner(), any("^2", "^-1", "^0.5", "^ 3", "^k"));
    case 2:
      return fmt::format("{}({})", any("sqrt", "abs", "sin", "cos", "tan", "exp", "log"), inner());
    case 3:
      return fmt::format("{}({}, {})", any("min", "max", "atan2", "norm", "hypot"), inner(), inner());
    case 4:
      return fmt::format("{}{}", any("-", "--", "+"), inner());
    default:
      return inner();
  }
}

/// A text for a reader that must stand anything: a formula with a few bytes spoilt, tokens in a
/// heap, or bytes.
inline std::string hostile_text(Random& random) {
  constexpr std::string_view tokens[] = {
      "x",      "range", "(",    ")",   "+",    "-",  "*", "/",     "^",   "<",     "<=", ">",
      ">=",     ",",     "norm", "min", "sqrt", "1",  "0", "1e308", "m",   "deg",   "s",  "1e999",
      "nobody", ".",     "..5",  "=",   "\"",   "\n", "é", "log",   "exp", "atan2", "pi", "0x1p3"};
  std::string text;
  switch (random() % 4) {
    case 0:
      for (std::uint64_t n = random() % 40; n > 0; --n) {
        text += tokens[random() % std::size(tokens)];
        if (random() % 2 == 0) text += ' ';
      }
      return text;
    case 1:
      for (std::uint64_t n = random() % 60; n > 0; --n) text += static_cast<char>(random());
      return text;
    case 2: {
      // The same few tokens over and over.
      const std::string_view a = tokens[random() % std::size(tokens)],
                             b = tokens[random() % std::size(tokens)];
      for (std::uint64_t n = random() % 400; n > 0; --n) (text += a) += b;
      return text;
    }
    default:
      text = formula_text(random, static_cast<int>(random() % 7)) + " < " + formula_text(random, 2);
      for (std::uint64_t n = random() % 4; n > 0 && !text.empty(); --n) {
        const std::size_t at = random() % text.size();
        if (random() % 2 == 0)
          text.erase(at, 1 + random() % 3);
        else
          text.insert(at, tokens[random() % std::size(tokens)]);
      }
      return text;
  }
}

}  // namespace sightline
