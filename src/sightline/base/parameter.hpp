/// Descriptions of parameters, given once beside the struct of a robot, potential, reference or
/// limit.
///
///   struct TooFar {
///     double d_max = 2.0, kappa = 10.0;
///     static constexpr std::string_view name = "too_far";
///     static constexpr auto parameters() {
///       return std::tuple{parameter("d_max", &TooFar::d_max, "m", above_zero, "greatest distance"),
///                         parameter("kappa", &TooFar::kappa, "1/m", above_zero, "sharpness of the bend")};
///     }
///   };
///
/// Reading, checking, error messages, summaries, JSON and the tables of docs/ derive from them;
/// defaults are those of the struct.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace sightline {

/// The numbers that a parameter accepts, and their description without a unit: "> 0".
struct Bounds {
  double low, high;  ///< both are included
  std::string_view words;
  bool or_zero = false;  ///< 0 is accepted as well, below `low`

  constexpr bool hold(double v) const { return (v >= low && v <= high) || (or_zero && v == 0); }
  /// The description with its unit: "> 0 m".
  std::string expected(std::string_view unit) const;
};

inline constexpr Bounds any_finite = {-std::numeric_limits<double>::max(), std::numeric_limits<double>::max(),
                                      "finite"};
inline constexpr Bounds above_zero = {std::numeric_limits<double>::min(), std::numeric_limits<double>::max(),
                                      "> 0"};
inline constexpr Bounds from_zero = {0.0, std::numeric_limits<double>::max(), ">= 0"};

/// A number, an optional number, or a fixed number of them (std::array, Vec3).
template <class Part, class Value>
struct NumberParameter {
  std::string_view key;
  Value Part::*member;
  std::string_view unit;
  Bounds bounds;
  std::string_view meaning;
  bool must_be_given = false;
};

/// One of several words.
template <class Part, class Value, std::size_t n>
struct WordParameter {
  std::string_view key;
  Value Part::*member;
  std::array<std::string_view, n> words;  ///< in the order of the enumeration, from 0
  std::string_view meaning;
};

/// A list of numbers or positions (Vec3). All lists of a part have the length of its first: times,
/// and a value at each time.
template <class Part, class Element>
struct ListParameter {
  std::string_view key;
  std::vector<Element> Part::*member;
  std::string_view unit;
  std::string_view meaning;
  bool rises = false;  ///< each number is greater than the previous one
  bool must_be_given = true;
};

template <class Part, class Value>
constexpr NumberParameter<Part, Value> parameter(std::string_view key, Value Part::*member,
                                                 std::string_view unit, const Bounds& bounds,
                                                 std::string_view meaning) {
  return {key, member, unit, bounds, meaning};
}
template <class Part, class Value, std::size_t n>
constexpr WordParameter<Part, Value, n> parameter(std::string_view key, Value Part::*member,
                                                  const std::array<std::string_view, n>& words,
                                                  std::string_view meaning) {
  return {key, member, words, meaning};
}
/// The same parameter without a default: a scenario must give it.
template <class Part, class Value>
constexpr NumberParameter<Part, Value> needed(NumberParameter<Part, Value> p) {
  p.must_be_given = true;
  return p;
}

/// Initial parameters of a part that `preset = "NAME"` selects.
template <class Part>
struct Preset {
  std::string_view name;
  Part part;
};

/// A part that describes its parameters.
template <class P>
concept Described = requires {
  P::parameters();
};

/// Rejects a number of a part.
/// @throws std::invalid_argument "part.key = value, expected ...", always
[[noreturn]] void refuse_parameter(std::string_view part, std::string_view key, double value,
                                   std::string_view expected);

namespace detail {

/// Calls `take` for each number in a value: the value itself, the entries of an array, or x, y, z.
template <class Value, class Do>
void each_number(const Value& value, Do&& take) {
  if constexpr (requires { double(value); }) {
    take(double(value));
  } else if constexpr (requires { value.has_value(); }) {
    if (value) take(double(*value));
  } else if constexpr (requires { value.x + value.y + value.z; }) {
    take(value.x), take(value.y), take(value.z);
  } else {
    for (const double v : value) take(v);
  }
}

std::string numbers_text(std::span<const double> numbers, bool in_brackets);

template <class Value>
std::string value_text(const Value& value) {
  std::vector<double> numbers;
  each_number(value, [&](double v) { numbers.push_back(v); });
  return numbers_text(
      numbers, !requires { double(value); } && !requires { value.has_value(); });
}

}  // namespace detail

/// Checks each number against its bounds; a list's numbers are finite.
/// @throws std::invalid_argument naming the part, the parameter, its value and its range
template <Described P>
void check_parameters(const P& part, std::string_view name) {
  const auto check_all = [&](const auto& value, std::string_view key, const Bounds& bounds,
                             std::string_view unit) {
    detail::each_number(value, [&](double v) {
      if (!std::isfinite(v) || !bounds.hold(v)) refuse_parameter(name, key, v, bounds.expected(unit));
    });
  };
  const auto check = [&](const auto& p) {
    const auto& value = part.*p.member;
    if constexpr (requires { p.bounds; }) {
      check_all(value, p.key, p.bounds, p.unit);
    } else if constexpr (requires { p.rises; }) {
      for (const auto& one : value) check_all(one, p.key, any_finite, p.unit);
    }
  };
  std::apply([&](const auto&... p) { (check(p), ...); }, P::parameters());
}
template <Described P>
void check_parameters(const P& part) {
  check_parameters(part, P::name);
}

/// A parameter as text, for summaries, JSON and documents.
struct ParameterText {
  std::string_view key, unit;
  std::string range;  ///< "> 0", "one of sine, tangent"
  std::string_view meaning;
  std::string value;     ///< of the part; empty: none
  std::string fallback;  ///< its default; empty: none
  bool must_be_given = false;
};

std::string words_text(std::span<const std::string_view> words);

/// The parameters of a part; empty if the part does not describe them.
template <class P>
std::vector<ParameterText> parameter_texts([[maybe_unused]] const P& part) {
  std::vector<ParameterText> texts;
  if constexpr (Described<P>) {
    const auto value_of = [](const P& of, const auto& p) -> std::string {
      if constexpr (requires { p.words; }) {
        return std::string(p.words[static_cast<std::size_t>(of.*p.member)]);
      } else if constexpr (requires { p.rises; }) {
        return (of.*p.member).empty() ? std::string() : std::string("[...]");
      } else {
        return detail::value_text(of.*p.member);
      }
    };
    const auto add = [&](const auto& p) {
      ParameterText& text = texts.emplace_back();
      text.key = p.key;
      text.meaning = p.meaning;
      text.value = value_of(part, p);
      if constexpr (requires { p.unit; }) text.unit = p.unit;
      if constexpr (requires { p.must_be_given; }) text.must_be_given = p.must_be_given;
      if constexpr (requires { p.words; }) text.range = words_text(p.words);
      if constexpr (requires { p.bounds; }) text.range = p.bounds.words;
      if constexpr (requires { p.rises; }) text.range = p.rises ? "a list, rising" : "a list";
      if constexpr (std::is_default_constructible_v<P>) {
        if (!text.must_be_given) text.fallback = value_of(P{}, p);
      }
    };
    std::apply([&](const auto&... p) { (add(p), ...); }, P::parameters());
  }
  return texts;
}

/// The values that differ from the defaults: "d_min = 1.5 m, kappa = 5 1/m".
std::string changed(std::span<const ParameterText> parameters);

/// Source of parameters, such as a table of a scenario. Every function but `has` throws if the
/// value is not the expected one; the message names the value and the expectation.
class ParameterSource {
 public:
  static constexpr std::size_t any_length = static_cast<std::size_t>(-1);

  virtual ~ParameterSource() = default;
  virtual bool has(std::string_view key) const = 0;
  virtual void expect_only(std::span<const std::string_view> keys) const = 0;
  virtual double number(std::string_view key, const Bounds& bounds, std::string_view unit) const = 0;
  virtual int integer(std::string_view key, const Bounds& bounds) const = 0;
  virtual std::vector<double> numbers(std::string_view key, std::size_t length, const Bounds& bounds,
                                      std::string_view unit) const = 0;
  virtual std::vector<double> rising(std::string_view key) const = 0;
  virtual std::vector<std::vector<double>> rows(std::string_view key, std::size_t count,
                                                std::size_t length) const = 0;
  /// Index of the word in `known`.
  virtual std::size_t word(std::string_view key, std::span<const std::string_view> known) const = 0;
  /// Rejects the whole part with its own message, "part.key = value, expected ...".
  [[noreturn]] virtual void throw_invalid(std::string_view sentence) const = 0;
};

namespace detail {

// A part may derive from another part, whose members `p` describes.
template <class P, class Owner, class Value>
void read(const ParameterSource& from, P& part, const NumberParameter<Owner, Value>& p) {
  if (!from.has(p.key) && !p.must_be_given) return;
  Value& value = part.*p.member;
  if constexpr (std::is_same_v<Value, int>) {
    value = from.integer(p.key, p.bounds);
  } else if constexpr (requires { value = 0.0; }) {
    value = from.number(p.key, p.bounds, p.unit);
  } else {
    std::size_t n = 0, i = 0;
    each_number(value, [&](double) { ++n; });
    const std::vector<double> numbers = from.numbers(p.key, n, p.bounds, p.unit);
    if constexpr (requires { value.x + value.y + value.z; }) {
      value = {numbers[0], numbers[1], numbers[2]};
    } else {
      for (double& v : value) v = numbers[i++];
    }
  }
}

template <class P, class Owner, class Value, std::size_t n>
void read(const ParameterSource& from, P& part, const WordParameter<Owner, Value, n>& p) {
  if (from.has(p.key)) part.*p.member = static_cast<Value>(from.word(p.key, p.words));
}

/// @param length  length of the previous lists; `any_length`: this list is the first
template <class P, class Owner, class Element>
void read(const ParameterSource& from, P& part, const ListParameter<Owner, Element>& p, std::size_t length) {
  std::vector<Element>& list = part.*p.member;
  if (!from.has(p.key) && !p.must_be_given) return;
  if constexpr (requires(Element e) { e.x; }) {
    list.clear();
    for (const std::vector<double>& row : from.rows(p.key, length, 3))
      list.push_back({row[0], row[1], row[2]});
  } else {
    list = p.rises ? from.rising(p.key) : from.numbers(p.key, length, any_finite, p.unit);
  }
}

}  // namespace detail

/// The keys of a part's parameters.
template <Described P>
std::vector<std::string_view> parameter_keys() {
  std::vector<std::string_view> keys;
  std::apply([&](const auto&... p) { (keys.push_back(p.key), ...); }, P::parameters());
  return keys;
}

/// Sets the parameters that are given. Other keys are ignored.
template <Described P>
void read_parameters(const ParameterSource& from, P& part) {
  std::size_t length = ParameterSource::any_length;
  const auto one = [&](const auto& p) {
    if constexpr (requires { p.rises; }) {
      detail::read(from, part, p, length);
      if (length == ParameterSource::any_length) length = (part.*p.member).size();
    } else {
      detail::read(from, part, p);
    }
  };
  std::apply([&](const auto&... p) { (one(p), ...); }, P::parameters());
}

/// Reads a part: the given parameters, else those of a preset or the defaults. Rejects all other
/// keys except `beside`. A part without described parameters accepts none.
template <class P>
P read_part(const ParameterSource& from, std::span<const std::string_view> beside = {}) {
  P part{};
  std::vector<std::string_view> keys(beside.begin(), beside.end());
  if constexpr (Described<P>) {
    const std::vector<std::string_view> own = parameter_keys<P>();
    keys.insert(keys.begin(), own.begin(), own.end());
  }
  if constexpr (requires { P::presets(); }) {
    keys.push_back("preset");
    from.expect_only(keys);
    const auto presets = P::presets();
    std::vector<std::string_view> names;
    for (const auto& preset : presets) names.push_back(preset.name);
    if (from.has("preset")) part = presets[from.word("preset", names)].part;
  } else {
    from.expect_only(keys);
  }
  if constexpr (Described<P>) read_parameters(from, part);
  return part;
}

}  // namespace sightline
