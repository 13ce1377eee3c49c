#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "sightline/base/nearest.hpp"
#include "sightline/formula.hpp"

namespace sightline {
namespace {

using Kind = Expression::Kind;

struct Function {
  std::string_view name;
  std::size_t least, most;  // number of arguments
};
constexpr std::array functions = {
    Function{"sqrt", 1, 1}, Function{"abs", 1, 1}, Function{"min", 2, 16},  Function{"max", 2, 16},
    Function{"sin", 1, 1},  Function{"cos", 1, 1}, Function{"tan", 1, 1},   Function{"atan2", 2, 2},
    Function{"exp", 1, 1},  Function{"log", 1, 1}, Function{"norm", 2, 16}, Function{"hypot", 2, 16},
};

const Function* function_named(std::string_view name) {
  for (const Function& f : functions) {
    if (f.name == name) return &f;
  }
  return nullptr;
}

/// A parsed subexpression: its step, its unit if known, and its offset in the text.
struct Part {
  int step;
  std::optional<Unit> unit;
  std::size_t begin;
};

class Parser {
 public:
  Parser(std::string_view text, const Vocabulary& names) : lexer_(text), names_(names) {}

  Expression formula() {
    const Part value = sum();
    if (is_comparison(lexer_.token())) {
      throw_invalid(lexer_.token(),
                    fmt::format("{} compares, expected a formula of one value here", shown(lexer_.token())));
    }
    expect_end();
    return finish(value.step, value.unit);
  }

  std::vector<Expression> limits() {
    std::vector<Expression> list;
    Part left = sum();
    if (!is_comparison(lexer_.token())) expect_end("a comparison, one of < <= > >=");
    char direction = '\0';
    while (is_comparison(lexer_.token())) {
      const Token sign = lexer_.take();
      if (direction != '\0' && sign.text[0] != direction) {
        throw_invalid(sign,
                      fmt::format("{} turns the chain round, expected {} again", shown(sign), direction));
      }
      direction = sign.text[0];
      const Part right = sum();
      const std::optional<Unit> unit = same_unit(sign, left, right);
      const int c = direction == '<' ? builder_.binary(Kind::subtract, left.step, right.step)
                                     : builder_.binary(Kind::subtract, right.step, left.step);
      list.push_back(finish(c, unit));
      left = right;
    }
    expect_end();
    return list;
  }

 private:
  static bool is_comparison(const Token& t) {
    return t.kind == TokenKind::sign && (t.text[0] == '<' || t.text[0] == '>');
  }

  [[noreturn]] void throw_invalid(const Token& at, std::string sentence) const {
    lexer_.throw_invalid(at.begin, std::move(sentence));
  }

  void expect_end(std::string_view expected = "an operator or the end") const {
    const Token& token = lexer_.token();
    if (token.kind == TokenKind::end && expected.starts_with("an operator")) return;
    if (token.is(")")) throw_invalid(token, "\")\" closes no bracket, expected " + std::string(expected));
    throw_invalid(token, fmt::format("{} comes too early, expected {}", shown(token), expected));
  }

  Expression finish(int step, std::optional<Unit> unit) const {
    return builder_.finish(step, unit, smoothed_);
  }

  /// Checks a new step at a token: its value is finite if known, and the number of steps is within
  /// its limit.
  Part made(const Token& at, int step, std::optional<Unit> unit, std::size_t begin) {
    if (const auto value = builder_.value(step); value && !std::isfinite(*value)) {
      throw_invalid(at, fmt::format("{} gives no finite number, expected a finite constant", shown(at)));
    }
    if (builder_.size() > formula_steps_max) {
      throw_invalid(
          at, fmt::format("more than {} operations by here, expected a shorter formula", formula_steps_max));
    }
    return {step, unit, begin};
  }

  std::optional<Unit> same_unit(const Token& at, const Part& a, const Part& b) const {
    if (a.unit && b.unit && *a.unit != *b.unit) {
      throw_invalid(at, fmt::format("{} joins {} with {}, expected the same unit on both sides", shown(at),
                                    to_string(*a.unit), to_string(*b.unit)));
    }
    return a.unit ? a.unit : b.unit;
  }

  void expect_plain(const Part& part, std::string_view of) const {
    if (part.unit && *part.unit != units::none) {
      lexer_.throw_invalid(part.begin, fmt::format("{} has the unit {}, expected a plain number or an angle",
                                                   of, to_string(*part.unit)));
    }
  }

  Part sum() {
    Part left = product();
    while (lexer_.token().is("+") || lexer_.token().is("-")) {
      const Token sign = lexer_.take();
      const Part right = product();
      const std::optional<Unit> unit = same_unit(sign, left, right);
      left = made(sign, builder_.binary(sign.is("+") ? Kind::add : Kind::subtract, left.step, right.step),
                  unit, left.begin);
    }
    return left;
  }

  Part product() {
    Part left = signed_power();
    while (lexer_.token().is("*") || lexer_.token().is("/")) {
      const Token sign = lexer_.take();
      const Part right = signed_power();
      const bool times = sign.is("*");
      if (!times && builder_.value(right.step) == 0.0) {
        lexer_.throw_invalid(right.begin, "division by zero, expected a divisor that is not 0");
      }
      std::optional<Unit> unit;
      if (left.unit && right.unit) unit = times ? *left.unit * *right.unit : *left.unit / *right.unit;
      left = made(sign, builder_.binary(times ? Kind::multiply : Kind::divide, left.step, right.step), unit,
                  left.begin);
    }
    return left;
  }

  Part signed_power() {
    const std::size_t begin = lexer_.token().begin;
    bool negative = false;
    while (lexer_.token().is("-") || lexer_.token().is("+")) negative ^= lexer_.take().is("-");
    Part value = power();
    if (negative) value.step = builder_.unary(Kind::negate, value.step);
    value.begin = begin;
    return value;
  }

  Part power() {
    const Part base = atom();
    if (!lexer_.token().is("^")) return base;
    const Token sign = lexer_.take();
    const Deeper deeper(*this, sign);
    const Part exponent = signed_power();
    expect_plain(exponent, "the exponent");
    const std::optional<double> n = builder_.value(exponent.step);
    std::optional<Unit> unit = base.unit;
    if (n && unit) {
      unit = to_power(*base.unit, *n);
      if (!unit) {
        lexer_.throw_invalid(exponent.begin,
                             fmt::format("the power {} of {} has no unit, expected a whole or half "
                                         "power",
                                         *n, to_string(*base.unit)));
      }
    }
    if (n && builder_.value(base.step) == 0.0 && *n < 0) {
      lexer_.throw_invalid(base.begin, "division by zero, expected a base that is not 0");
    }
    const bool whole = n && *n == std::round(*n) && std::fabs(*n) <= 64;
    if (whole) return made(sign, builder_.power(base.step, static_cast<int>(*n)), unit, base.begin);
    if (n && 2 * *n == std::round(2 * *n) && std::fabs(*n) <= 64) {
      smoothed_.insert("sqrt");
      const int root = builder_.unary(Kind::root, base.step);
      return made(sign, builder_.power(root, static_cast<int>(2 * *n)), unit, base.begin);
    }
    expect_plain(base, "the base of this power");
    const int log = builder_.unary(Kind::logarithm, base.step);
    const int product = builder_.binary(Kind::multiply, exponent.step, log);
    return made(sign, builder_.unary(Kind::exponential, product), unit, base.begin);
  }

  Part atom() {
    const Token token = lexer_.take();
    if (token.kind == TokenKind::number) return number(token);
    if (token.is("(")) {
      const Deeper deeper(*this, token);
      const Part inner = sum();
      close(token);
      return {inner.step, inner.unit, token.begin};
    }
    if (token.kind == TokenKind::name) return lexer_.token().is("(") ? call(token) : name(token);
    throw_invalid(token, fmt::format("{} comes too early, expected a number, a name or \"(\"", shown(token)));
  }

  /// Expects the bracket that closes `open`.
  void close(const Token& open) {
    if (lexer_.token().is(")")) {
      lexer_.take();
      return;
    }
    if (lexer_.token().kind == TokenKind::end) {
      throw_invalid(open, fmt::format("{} is never closed, expected \")\"", shown(open)));
    }
    throw_invalid(lexer_.token(),
                  fmt::format("{} within brackets, expected an operator or \")\"", shown(lexer_.token())));
  }

  Part number(const Token& token) {
    double value = token.value;
    std::optional<Unit> unit;
    // A slash belongs to the unit only if a unit follows, so a copy of the lexer looks ahead.
    const auto factor = [&](bool below) {
      const auto named = unit_named(lexer_.token().text);
      if (lexer_.token().kind != TokenKind::name || !named) return false;
      lexer_.take();
      int n = 1;
      if (lexer_.token().is("^")) {
        lexer_.take();
        const Token power = lexer_.take();
        if (power.kind != TokenKind::number || power.value != std::round(power.value) || power.value > 8) {
          throw_invalid(
              power, fmt::format("{} is no power of a unit, expected a whole number up to 8", shown(power)));
        }
        n = static_cast<int>(power.value);
      }
      n = below ? -n : n;
      value *= std::pow(named->factor, n);
      unit = unit.value_or(units::none) * *to_power(named->unit, n);
      return true;
    };
    const bool has_unit = factor(false);
    if (!has_unit && lexer_.token().kind == TokenKind::name) {
      const bool known = names_.contains(lexer_.token().text) || function_named(lexer_.token().text);
      throw_invalid(lexer_.token(), fmt::format("{} after a number, expected {}", shown(lexer_.token()),
                                                known ? "an operator, as in 2 * x"
                                                      : "a unit, one of m, cm, mm, km, rad, deg, s, "
                                                        "ms, Hz"));
    }
    while (lexer_.token().is("/")) {
      const Lexer before = lexer_;
      lexer_.take();
      if (factor(true)) continue;
      lexer_ = before;
      break;
    }
    return made(token, builder_.constant(value), unit, token.begin);
  }

  Part name(const Token& token) {
    if (token.text == "pi") return {builder_.constant(std::numbers::pi), units::none, token.begin};
    if (const auto found = names_.find(token.text); found != names_.end()) {
      smoothed_.insert(found->second.smoothed().begin(), found->second.smoothed().end());
      const auto [entry, added] = copied_.try_emplace(found->first, -1);
      if (added) entry->second = builder_.copy(found->second);
      return made(token, entry->second, found->second.unit(), token.begin);
    }
    if (function_named(token.text) != nullptr) {
      throw_invalid(token, fmt::format("{} is a function, expected its arguments in brackets", shown(token)));
    }
    if (unit_named(token.text)) {
      throw_invalid(token, fmt::format("{} is a unit, expected a number before it", shown(token)));
    }
    unknown(token);
  }

  [[noreturn]] void unknown(const Token& token) const {
    std::vector<std::string_view> known = {"pi"};
    for (const auto& [word, meaning] : names_) known.push_back(word);
    for (const Function& f : functions) known.push_back(f.name);
    throw_invalid(token, fmt::format("{} is unknown, expected a known name{}", shown(token),
                                     hint(token.text.substr(0, 40), known)));
  }

  Part call(const Token& token) {
    const Function* function = function_named(token.text);
    if (function == nullptr && (names_.contains(token.text) || unit_named(token.text))) {
      throw_invalid(token, fmt::format("{} is no function, expected an operator after it", shown(token)));
    }
    if (function == nullptr) unknown(token);
    const Token open = lexer_.take();
    const Deeper deeper(*this, open);
    std::vector<Part> arguments = {sum()};
    while (lexer_.token().is(",")) {
      lexer_.take();
      arguments.push_back(sum());
    }
    close(open);
    if (arguments.size() < function->least || arguments.size() > function->most) {
      throw_invalid(token, fmt::format("{} has {} argument{}, expected {}", token.text, arguments.size(),
                                       arguments.size() == 1 ? "" : "s",
                                       function->least == function->most
                                           ? fmt::format("{}", function->least)
                                           : fmt::format("{} to {}", function->least, function->most)));
    }
    return apply(token, arguments);
  }

  Part apply(const Token& token, const std::vector<Part>& arguments) {
    const std::string_view f = token.text;
    const Part& first = arguments.front();
    if (f == "sin" || f == "cos" || f == "tan" || f == "exp" || f == "log") {
      expect_plain(first, fmt::format("the argument of {}", f));
      const auto of = [&](Kind kind) { return builder_.unary(kind, first.step); };
      const int step = f == "sin"   ? of(Kind::sine)
                       : f == "cos" ? of(Kind::cosine)
                       : f == "exp" ? of(Kind::exponential)
                       : f == "log" ? of(Kind::logarithm)
                                    : builder_.binary(Kind::divide, of(Kind::sine), of(Kind::cosine));
      return made(token, step, units::none, token.begin);
    }
    if (f == "sqrt") {
      smoothed_.insert("sqrt");
      const std::optional<Unit> unit = first.unit ? to_power(*first.unit, 0.5) : std::nullopt;
      if (first.unit && !unit) {
        lexer_.throw_invalid(first.begin, fmt::format("the root of {} has no unit", to_string(*first.unit)) +
                                              ", expected an even power");
      }
      return made(token, builder_.unary(Kind::root, first.step), unit, token.begin);
    }

    // All other functions take arguments of one unit.
    Part all = first;
    for (const Part& argument : arguments) all.unit = same_unit(token, all, argument);
    if (f == "atan2") {
      return made(token, builder_.binary(Kind::angle, first.step, arguments[1].step), units::none,
                  token.begin);
    }
    smoothed_.emplace(f);
    int step = first.step;
    if (f == "abs") {
      step = builder_.absolute(step);
    } else if (f == "norm" || f == "hypot") {
      step = builder_.power(step, 2);
      for (std::size_t i = 1; i < arguments.size(); ++i) {
        step = builder_.binary(Kind::add, step, builder_.power(arguments[i].step, 2));
      }
      step = builder_.unary(Kind::root, step);
    } else {
      for (std::size_t i = 1; i < arguments.size(); ++i) {
        step =
            f == "min" ? builder_.smaller(step, arguments[i].step) : builder_.larger(step, arguments[i].step);
      }
    }
    return made(token, step, all.unit, token.begin);
  }

  /// Increases the nesting depth by one for its lifetime.
  class Deeper {
   public:
    Deeper(Parser& parser, const Token& at) : parser_(parser) {
      if (++parser_.depth_ > formula_depth_max) {
        parser_.throw_invalid(at, fmt::format("brackets and powers are nested deeper than {}, expected fewer",
                                              formula_depth_max));
      }
    }
    ~Deeper() { --parser_.depth_; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;

   private:
    Parser& parser_;
  };

  Lexer lexer_;
  const Vocabulary& names_;
  ExpressionBuilder builder_;
  std::set<std::string> smoothed_;
  std::map<std::string_view, int> copied_;  // names that occurred, and their step
  int depth_ = 0;
};

/// The words of `names` that occur in a text, each at its first occurrence.
std::vector<Token> names_in(std::string_view text, const std::set<std::string_view>& names) {
  std::map<std::string_view, Token> found;
  for (Lexer lexer(text); lexer.token().kind != TokenKind::end;) {
    const Token token = lexer.take();
    if (token.kind == TokenKind::name && names.contains(token.text)) found.try_emplace(token.text, token);
  }
  std::vector<Token> list;
  for (const auto& [name, token] : found) list.push_back(token);
  return list;
}

}  // namespace

bool is_free_name(std::string_view name) {
  if (!is_word(name) || name == "pi") return false;
  return function_named(name) == nullptr && !unit_named(name);
}

Expression parse_formula(std::string_view text, const Vocabulary& names) {
  return Parser(text, names).formula();
}

std::vector<Expression> parse_limits(std::string_view text, const Vocabulary& names) {
  return Parser(text, names).limits();
}

void define(Vocabulary& names, std::span<const Definition> definitions) {
  const auto within = [](const Definition& d, auto&& read) {
    try {
      return read();
    } catch (const FormulaError& error) {
      throw FormulaError(d.text, error.offset(), error.sentence(), d.name);
    }
  };
  std::set<std::string_view> defined;
  for (const Definition& d : definitions) defined.insert(d.name);
  std::vector<std::vector<Token>> needs;
  std::vector<const Definition*> open;
  for (const Definition& d : definitions) {
    needs.push_back(within(d, [&] { return names_in(d.text, defined); }));
    open.push_back(&d);
  }
  // Each round reads the definitions with all names known; if there are none, the rest form a
  // cycle.
  while (!open.empty()) {
    std::map<std::string_view, const Definition*> waiting;
    for (const Definition* d : open) waiting.emplace(d->name, d);
    const auto awaited = [&](const Definition* d) -> const Token* {
      for (const Token& token : needs[static_cast<std::size_t>(d - definitions.data())]) {
        if (waiting.contains(token.text)) return &token;
      }
      return nullptr;
    };
    std::vector<const Definition*> ready, later;
    for (const Definition* d : open) (awaited(d) != nullptr ? later : ready).push_back(d);
    if (ready.empty()) {
      // From any definition, as many steps as there are open definitions end in the cycle.
      const Definition* d = open.front();
      for (std::size_t i = 0; i < open.size(); ++i) d = waiting.at(awaited(d)->text);
      throw FormulaError(
          d->text, awaited(d)->begin,
          fmt::format("\"{}\" needs itself through {}, expected parameters that end in numbers", d->name,
                      shown(*awaited(d))),
          d->name);
    }
    for (const Definition* d : ready) {
      names.insert_or_assign(d->name, within(*d, [&] { return parse_formula(d->text, names); }));
    }
    open = std::move(later);
  }
}

}  // namespace sightline
