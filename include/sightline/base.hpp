/// Numbers and helpers below everything else: lane packs, elementary functions with the same bits on every machine, small
/// vectors and matrices, described parameters, threads.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <future>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "sightline/config.hpp"

namespace sightline {

// Conversions of indices: item numbers are int; container indices and sizes are std::size_t.

/// The container index of item i, i >= 0.
constexpr std::size_t at(int i) {
  assert(i >= 0 && "a place is not negative");
  return static_cast<std::size_t>(i);
}

/// The container size for n items, n >= 0.
constexpr std::size_t size(int n) {
  assert(n >= 0 && "a size is not negative");
  return static_cast<std::size_t>(n);
}

// Runge-Kutta steps of x' = f(x).

/// Scratch of one Runge-Kutta step of a state of n numbers.
struct RungeKuttaScratch {
  static constexpr std::size_t rows_needed = 5;
  std::span<double> rows;  ///< 5 n numbers: k1..k4 and the trial state
};

/// x <- x + s/6 (k1 + 2 k2 + 2 k3 + k4), the classical Runge-Kutta step of length s.
/// @param f  called as f(x, rate); writes x' of the state x into rate; both have the length of x
template <class F>
void rk4_step(F&& f, std::span<double> x, double s, RungeKuttaScratch scratch) {
  const std::size_t n = x.size();
  const auto row = [&](std::size_t i) { return scratch.rows.subspan(i * n, n); };
  const std::span<double> trial = row(4);
  f(std::span<const double>(x), row(0));
  constexpr std::array<double, 3> fraction = {0.5, 0.5, 1.0};
  for (std::size_t stage = 0; stage < 3; ++stage) {
    for (std::size_t i = 0; i < n; ++i) trial[i] = x[i] + fraction[stage] * s * row(stage)[i];
    f(std::span<const double>(trial), row(stage + 1));
  }
  for (std::size_t i = 0; i < n; ++i) {
    x[i] += s / 6 * (row(0)[i] + 2 * row(1)[i] + 2 * row(2)[i] + row(3)[i]);
  }
}

/// The same step for a state of n numbers, equal to the bit. It is written without loops: compilers
/// vectorise such a loop in one place and unroll it in the next.
/// @param f  called as f(x), returns x'
template <std::size_t n, class F>
std::array<double, n> rk4_step(F&& f, const std::array<double, n>& x, double s) {
  const auto each = [](auto entry) {
    return [&]<std::size_t... i>(std::index_sequence<i...>) { return std::array<double, n>{entry(i)...}; }
    (std::make_index_sequence<n>());
  };
  const auto trial = [&](double fraction, const std::array<double, n>& k) {
    return f(each([&](std::size_t i) { return x[i] + fraction * s * k[i]; }));
  };
  const std::array<double, n> k1 = f(x), k2 = trial(0.5, k1), k3 = trial(0.5, k2), k4 = trial(1.0, k3);
  return each([&](std::size_t i) { return x[i] + s / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]); });
}

// Calls of user functions in the control path: an exception becomes results that are NaN. A call
// that does not throw costs nothing extra.

/// f(), or NaN if f throws.
template <class F>
double or_nan(F&& f) noexcept {
  try {
    return f();
  } catch (...) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

/// Calls `write`, which writes n numbers to `to`; all are NaN if it throws.
template <class Write>
void write_or_nan(double* to, std::size_t n, Write&& write) noexcept {
  try {
    write();
  } catch (...) {
    std::fill_n(to, n, std::numeric_limits<double>::quiet_NaN());
  }
}

// Texts from outside in messages.

/// The text with control characters, line separators and bytes that are not UTF-8 as \n, \u0007 or
/// \xff.
std::string one_line(std::string_view text);

/// At most `size` bytes of the text, cut between two characters and marked with "...".
std::string shortened(std::string_view text, std::size_t size);

// Descriptions of parameters, given once beside the struct of a robot, potential, reference or
// limit.
//
//   struct TooFar {
//     double d_max = 2.0, kappa = 10.0;
//     static constexpr std::string_view name = "too_far";
//     static constexpr auto parameters() {
//       return Parameters{parameter("d_max", &TooFar::d_max, "m", above_zero, "greatest distance"),
//                         parameter("kappa", &TooFar::kappa, "1/m", above_zero, "sharpness of the bend")};
//     }
//   };
//
// Reading, checking, error messages, summaries, JSON and the tables of docs/ derive from them;
// defaults are those of the struct.

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

/// Description of a key that the reader of the part reads by itself.
struct KeyText {
  std::string_view key, range, meaning;
  std::string_view fallback{};  ///< its default; empty: none
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

namespace detail {
template <std::size_t, class Description>
struct DescriptionAt {
  constexpr explicit DescriptionAt(const Description& of) : description(of) {}
  Description description;
};
template <class Indices, class... Description>
struct DescriptionsAt;
template <std::size_t... i, class... Description>
struct DescriptionsAt<std::index_sequence<i...>, Description...> : DescriptionAt<i, Description>... {
  constexpr explicit DescriptionsAt(const Description&... of) : DescriptionAt<i, Description>(of)... {}
  template <class Take>
  constexpr auto pass_to(Take&& take) const {
    return take(static_cast<const DescriptionAt<i, Description>&>(*this).description...);
  }
};
}  // namespace detail

/// Descriptions in their order. std::tuple, which `parameters()` may return too, takes a compiler several
/// times as long.
template <class... Description>
struct Parameters : detail::DescriptionsAt<std::index_sequence_for<Description...>, Description...> {
  constexpr explicit Parameters(const Description&... of)
      : detail::DescriptionsAt<std::index_sequence_for<Description...>, Description...>(of...) {}
};

template <class... A, class... B>
constexpr Parameters<A..., B...> operator+(const Parameters<A...>& first, const Parameters<B...>& then) {
  return first.pass_to([&](const A&... a) {
    return then.pass_to([&](const B&... b) { return Parameters<A..., B...>(a..., b...); });
  });
}

/// A part that describes its parameters.
template <class P>
concept Described = requires {
  P::parameters();
};

/// Calls `take` with the description of each parameter of P, in their order.
template <Described P, class Take>
constexpr void each_parameter(Take&& take) {
  const auto parameters = P::parameters();
  const auto take_all = [&](const auto&... p) { (take(p), ...); };
  if constexpr (requires { std::tuple_size<decltype(parameters)>::value; }) {
    std::apply(take_all, parameters);
  } else {
    parameters.pass_to(take_all);
  }
}

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

/// A number of a part that its parameters describe: "d_min", "p[2]".
struct NamedNumber {
  std::string key;
  double* value;
};

/// The real numbers among the parameters of a part, in the order of their description.
template <class P>
std::vector<NamedNumber> numbers_of([[maybe_unused]] P& part) {
  std::vector<NamedNumber> numbers;
  if constexpr (Described<P>) {
    const auto add_all = [&](std::string_view key, auto&&... values) {
      int i = 0;
      (numbers.push_back({std::string(key) + "[" + std::to_string(i++) + "]", &values}), ...);
    };
    const auto add = [&](const auto& p) {
      if constexpr (requires { p.bounds; }) {
        auto& value = part.*p.member;
        using Value = std::remove_cvref_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, double>) {
          numbers.push_back({std::string(p.key), &value});
        } else if constexpr (requires { value.has_value(); }) {
          if (value) numbers.push_back({std::string(p.key), &*value});
        } else if constexpr (requires { value.x + value.y + value.z; }) {
          add_all(p.key, value.x, value.y, value.z);
        } else if constexpr (requires { std::tuple_size<Value>::value; }) {
          std::apply([&](auto&... each) { add_all(p.key, each...); }, value);
        }
      }
    };
    each_parameter<P>(add);
  }
  return numbers;
}

/// Checks each number against its bounds; a list's numbers are finite. Returns the part.
/// @throws std::invalid_argument naming the part, the parameter, its value and its range
template <Described P>
const P& check_parameters(const P& part, std::string_view name) {
  const auto check_all = [&](const auto& value, std::string_view key, const Bounds& bounds,
                             std::string_view unit) {
    detail::each_number(value, [&](double v) {
      if (!std::isfinite(v) || !bounds.hold(v)) refuse_parameter(name, key, v, bounds.expected(unit));
    });
  };
  const auto check = [&](const auto& p) {
    if constexpr (requires { p.bounds; }) {
      check_all(part.*p.member, p.key, p.bounds, p.unit);
    } else if constexpr (requires { p.rises; }) {
      for (const auto& one : part.*p.member) check_all(one, p.key, any_finite, p.unit);
    }
  };
  each_parameter<P>(check);
  return part;
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
      if constexpr (requires { p.range; }) {
        return std::string(p.fallback);
      } else if constexpr (requires { p.words; }) {
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
      if constexpr (requires { p.range; }) text.range = p.range;
      if constexpr (requires { p.words; }) text.range = words_text(p.words);
      if constexpr (requires { p.bounds; }) text.range = p.bounds.words;
      if constexpr (requires { p.rises; }) text.range = p.rises ? "a list, rising" : "a list";
      if constexpr (std::is_default_constructible_v<P>) {
        if (!text.must_be_given) text.fallback = value_of(P{}, p);
      }
    };
    each_parameter<P>(add);
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
  each_parameter<P>([&](const auto& p) { keys.push_back(p.key); });
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
    } else if constexpr (!requires { p.range; }) {
      detail::read(from, part, p);
    }
  };
  each_parameter<P>(one);
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

// A pack of doubles that one instruction processes: stages, pairs or agents side by side.
//
// The same operations exist for plain `double`, so a formula or a kernel is written once over
// `Real`. It then gives the same bits on one lane as on eight: nothing here sums across lanes, and
// a fused product is fused everywhere.
//
// The library build fixes the width of a pack (config.hpp). A program may be built for a
// lesser machine; each pack then takes several of its registers. The calling convention of a pack
// depends on that machine, so the name of Lane contains both. The linker therefore never replaces
// a function over lanes of one file by that of another.

#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace sightline {

/// The library alone defines it, and every file that computes on lanes references it. A file of
/// another width does not link.
extern const int SIGHTLINE_LANES_AGREE;

inline namespace SIGHTLINE_LANES {
[[gnu::used]] inline const int* const lanes_agree = &SIGHTLINE_LANES_AGREE;

/// Doubles in one register of the machine for which the library is built.
inline constexpr int native_width = SIGHTLINE_LANE_WIDTH;
/// Width of packs for three or four robots: where a register holds eight, half of it takes less
/// time.
inline constexpr int narrow_width = native_width < 4 ? native_width : 4;
}  // namespace SIGHTLINE_LANES

/// Rows of lanes begin on a multiple of this many bytes and hold a multiple of `row_quantum`
/// doubles.
inline constexpr int row_alignment = 64;
inline constexpr int row_quantum = row_alignment / static_cast<int>(sizeof(double));

/// Length of a row that holds n doubles, padded to whole packs of any width.
constexpr int padded(int n) { return (n + row_quantum - 1) / row_quantum * row_quantum; }

namespace detail {
/// The compiler's vector types; GCC accepts their size only as a literal.
template <int W>
struct Storage;
template <>
struct Storage<1> {
  typedef double Vector __attribute__((vector_size(8)));
  typedef std::int64_t Bits __attribute__((vector_size(8)));
};
template <>
struct Storage<2> {
  typedef double Vector __attribute__((vector_size(16)));
  typedef std::int64_t Bits __attribute__((vector_size(16)));
};
template <>
struct Storage<4> {
  typedef double Vector __attribute__((vector_size(32)));
  typedef std::int64_t Bits __attribute__((vector_size(32)));
};
template <>
struct Storage<8> {
  typedef double Vector __attribute__((vector_size(64)));
  typedef std::int64_t Bits __attribute__((vector_size(64)));
};
}  // namespace detail

inline namespace SIGHTLINE_LANES {

/// W doubles, W = 1, 2, 4 or 8; arithmetic is elementwise.
template <int W>
struct Lane {
  using Vector = typename detail::Storage<W>::Vector;
  using Bits = typename detail::Storage<W>::Bits;
  static constexpr int width = W;

  Vector v;

  Lane() = default;
  Lane(double s) : v(s - Vector{}) {}  // a constant of a formula is equal in all lanes
  explicit Lane(Vector vector) : v(vector) {}

  static Lane load(const double* row) {
    Lane lane;
    __builtin_memcpy(&lane.v, row, sizeof(Vector));
    return lane;
  }
  /// Loads from[offsets[i]] into lane i.
  template <class Offsets>
  static Lane gather(const double* from, const Offsets& offsets) {
    return [&]<std::size_t... i>(std::index_sequence<i...>) { return Lane(Vector{from[offsets[i]]...}); }
    (std::make_index_sequence<W>());
  }
  void store(double* row) const { __builtin_memcpy(row, &v, sizeof(Vector)); }
  double operator[](int i) const { return v[i]; }

  friend Lane operator+(Lane a, Lane b) { return Lane(a.v + b.v); }
  friend Lane operator-(Lane a, Lane b) { return Lane(a.v - b.v); }
  friend Lane operator*(Lane a, Lane b) { return Lane(a.v * b.v); }
  friend Lane operator/(Lane a, Lane b) { return Lane(a.v / b.v); }
  friend Lane operator-(Lane a) { return Lane(-a.v); }
  Lane& operator+=(Lane b) { return *this = *this + b; }
  Lane& operator-=(Lane b) { return *this = *this - b; }
  Lane& operator*=(Lane b) { return *this = *this * b; }
};

using NativeLane = Lane<native_width>;

}  // namespace SIGHTLINE_LANES

namespace detail {
template <class T>
inline constexpr bool is_lane = false;
template <int W>
inline constexpr bool is_lane<Lane<W>> = true;
}  // namespace detail

/// A number for computation, not recording: double, or a pack of doubles.
template <class T>
concept Real = std::same_as<T, double> || detail::is_lane<T>;

/// a b + c, rounded once. The overload for double is a template too, so that the C library's fma is
/// no ambiguous overload.
template <std::same_as<double> D>
D fma(D a, D b, D c) {
  return __builtin_fma(a, b, c);
}

template <int W>
Lane<W> fma(Lane<W> a, Lane<W> b, Lane<W> c) {
  using L [[maybe_unused]] = Lane<W>;
#if defined(__AVX512F__)
  if constexpr (W == 8)
    return L((typename L::Vector)_mm512_fmadd_pd((__m512d)a.v, (__m512d)b.v, (__m512d)c.v));
#endif
#if defined(__FMA__)
  if constexpr (W == 4)
    return L((typename L::Vector)_mm256_fmadd_pd((__m256d)a.v, (__m256d)b.v, (__m256d)c.v));
  if constexpr (W == 2) return L((typename L::Vector)_mm_fmadd_pd((__m128d)a.v, (__m128d)b.v, (__m128d)c.v));
#elif defined(__aarch64__)
  if constexpr (W == 2)
    return L((typename L::Vector)vfmaq_f64((float64x2_t)c.v, (float64x2_t)a.v, (float64x2_t)b.v));
#endif
  L r;
  for (int i = 0; i < W; ++i) r.v[i] = __builtin_fma(a.v[i], b.v[i], c.v[i]);
  return r;
}

/// a b - c, rounded once.
template <std::same_as<double> D>
D multiply_subtract(D a, D b, D c) {
  return __builtin_fma(a, b, -c);
}

/// c - a b, rounded once.
template <std::same_as<double> D>
D subtract_product(D a, D b, D c) {
  return __builtin_fma(-a, b, c);
}

// These use their own instructions: the compiler does not fold the sign of a vector into a fused
// product.
template <int W>
Lane<W> multiply_subtract(Lane<W> a, Lane<W> b, Lane<W> c) {
  using L [[maybe_unused]] = Lane<W>;
#if defined(__AVX512F__)
  if constexpr (W == 8)
    return L((typename L::Vector)_mm512_fmsub_pd((__m512d)a.v, (__m512d)b.v, (__m512d)c.v));
#endif
#if defined(__FMA__)
  if constexpr (W == 4)
    return L((typename L::Vector)_mm256_fmsub_pd((__m256d)a.v, (__m256d)b.v, (__m256d)c.v));
  if constexpr (W == 2) return L((typename L::Vector)_mm_fmsub_pd((__m128d)a.v, (__m128d)b.v, (__m128d)c.v));
#endif
  return fma(a, b, -c);
}

template <int W>
Lane<W> subtract_product(Lane<W> a, Lane<W> b, Lane<W> c) {
  using L [[maybe_unused]] = Lane<W>;
#if defined(__AVX512F__)
  if constexpr (W == 8)
    return L((typename L::Vector)_mm512_fnmadd_pd((__m512d)a.v, (__m512d)b.v, (__m512d)c.v));
#endif
#if defined(__FMA__)
  if constexpr (W == 4)
    return L((typename L::Vector)_mm256_fnmadd_pd((__m256d)a.v, (__m256d)b.v, (__m256d)c.v));
  if constexpr (W == 2) return L((typename L::Vector)_mm_fnmadd_pd((__m128d)a.v, (__m128d)b.v, (__m128d)c.v));
#endif
  return fma(-a, b, c);
}

template <std::same_as<double> D>
D sqrt(D a) {
  return __builtin_sqrt(a);
}

template <int W>
Lane<W> sqrt(Lane<W> a) {
  Lane<W> r;
  for (int i = 0; i < W; ++i) r.v[i] = __builtin_sqrt(a.v[i]);
  return r;
}

/// a where c < 0, else b.
inline double where_negative(double c, double a, double b) { return c < 0 ? a : b; }

template <int W>
Lane<W> where_negative(Lane<W> c, Lane<W> a, Lane<W> b) {
  return Lane<W>(c.v < 0.0 ? a.v : b.v);
}

/// The larger of a and b; b where one of them is not a number.
template <std::same_as<double> D>
D maximum(D a, D b) {
  return a > b ? a : b;
}

template <int W>
Lane<W> maximum(Lane<W> a, Lane<W> b) {
  return Lane<W>(a.v > b.v ? a.v : b.v);
}

/// The smaller of a and b; b where one of them is not a number.
template <std::same_as<double> D>
D minimum(D a, D b) {
  return a < b ? a : b;
}

template <int W>
Lane<W> minimum(Lane<W> a, Lane<W> b) {
  return Lane<W>(a.v < b.v ? a.v : b.v);
}

/// |a|.
template <Real L>
L absolute(L a) {
  return maximum(a, -a);
}

/// The largest lane above zero, else 0.
template <int W>
double largest(Lane<W> a) {
  double most = 0.0;
  for (int i = 0; i < W; ++i) most = a[i] > most ? a[i] : most;
  return most;
}

/// Whether a lane is below zero.
inline bool any_negative(double a) { return a < 0; }

template <int W>
bool any_negative(Lane<W> a) {
#if defined(__AVX512F__)
  if constexpr (W == 8) return _mm512_cmp_pd_mask((__m512d)a.v, _mm512_setzero_pd(), _CMP_LT_OQ) != 0;
#endif
  const auto below = a.v < 0.0;
  std::int64_t any = 0;
  for (int i = 0; i < W; ++i) any |= below[i];
  return any != 0;
}

/// x limited to [low, high]; NaN stays NaN.
inline double clamp(double x, double low, double high) {
  x = x < low ? low : x;
  return x > high ? high : x;
}

template <int W>
Lane<W> clamp(Lane<W> x, Lane<W> low, Lane<W> high) {
  const Lane<W> y(x.v < low.v ? low.v : x.v);
  return Lane<W>(y.v > high.v ? high.v : y.v);
}

template <int W>
Lane<W> clamp(Lane<W> x, double low, double high) {
  return clamp(x, Lane<W>(low), Lane<W>(high));
}

/// Lane i of the result is lane from[i] of a, 0 <= from[i] < W.
template <int W>
Lane<W> permuted(Lane<W> a, typename Lane<W>::Bits from) {
#if defined(__clang__)
  Lane<W> r;
  for (int i = 0; i < W; ++i) r.v[i] = a.v[from[i]];
  return r;
#else
  return Lane<W>(__builtin_shuffle(a.v, from));
#endif
}

namespace detail {

/// Adding this constant rounds a double to the nearest integer and leaves that integer in its low
/// bits.
inline constexpr double round_magic = 6755399441055744.0;  // 1.5 * 2^52

/// p * 2^n, n the integer in the low bits of `rounded`; p and the result are normal.
inline double scale_by_bits(double p, double rounded) {
  return std::bit_cast<double>(std::bit_cast<std::int64_t>(p) +
                               static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(rounded) << 52));
}

template <int W>
Lane<W> scale_by_bits(Lane<W> p, Lane<W> rounded) {
  using L = Lane<W>;
  const auto bits = (typename L::Bits)p.v + ((typename L::Bits)rounded.v << 52);
  return L((typename L::Vector)bits);
}

/// a where the given bit of the integer in `rounded` is set, else b.
inline double where_bit(double rounded, std::int64_t bit, double a, double b) {
  return (std::bit_cast<std::int64_t>(rounded) & bit) != 0 ? a : b;
}

template <int W>
Lane<W> where_bit(Lane<W> rounded, std::int64_t bit, Lane<W> a, Lane<W> b) {
  using L = Lane<W>;
  const auto set = ((typename L::Bits)rounded.v & bit) != 0;
  return L(set ? a.v : b.v);
}

/// Splits x = 2^n p, x > 0 and normal: returns p in [sqrt(1/2), sqrt 2). The low bits of `exponent`
/// receive n, as with round_magic.
inline double mantissa(double x, double& exponent) {
  constexpr std::int64_t root_half = 0x3fe6a09e667f3bcd;
  const std::int64_t n = (std::bit_cast<std::int64_t>(x) - root_half) >> 52;
  exponent = std::bit_cast<double>(std::bit_cast<std::int64_t>(round_magic) + n);
  return std::bit_cast<double>(std::bit_cast<std::int64_t>(x) - (n << 52));
}

template <int W>
Lane<W> mantissa(Lane<W> x, Lane<W>& exponent) {
  Lane<W> p;
  for (int i = 0; i < W; ++i) {
    double e = 0.0;
    p.v[i] = mantissa(x.v[i], e);
    exponent.v[i] = e;
  }
  return p;
}

/// y, or x where x is not a number.
inline double keep_nan(double x, double y) { return x != x ? x : y; }

template <int W>
Lane<W> keep_nan(Lane<W> x, Lane<W> y) {
  return Lane<W>(x.v != x.v ? x.v : y.v);
}

}  // namespace detail
// Elementary functions with the same bits on every machine, at every optimisation level, on one
// lane as on eight. Finite arguments give finite results, except where noted; NaN stays NaN.

template <class S>
S square(const S& x) {
  return x * x;
}

/// e^x, within 1.5 ulp; constant at e^-708 and e^709 outside [-708, 709].
template <Real L>
L exp(L x) {
  const L y = clamp(x, -708.0, 709.0);
  // x = n ln 2 + r, |r| <= ln 2 / 2, ln 2 in two parts.
  const L rounded = fma(y, L(1.4426950408889634074), L(detail::round_magic));
  const L n = rounded - L(detail::round_magic);
  const L r = fma(n, L(-1.90821492927058770002e-10), fma(n, L(-6.93147180369123816490e-01), y));
  // Taylor to r^13 / 13!, even and odd powers side by side.
  const L r2 = r * r;
  L even = L(1.0 / 479001600.0), odd = L(1.0 / 6227020800.0);
  even = fma(even, r2, L(1.0 / 3628800.0));
  odd = fma(odd, r2, L(1.0 / 39916800.0));
  even = fma(even, r2, L(1.0 / 40320.0));
  odd = fma(odd, r2, L(1.0 / 362880.0));
  even = fma(even, r2, L(1.0 / 720.0));
  odd = fma(odd, r2, L(1.0 / 5040.0));
  even = fma(even, r2, L(1.0 / 24.0));
  odd = fma(odd, r2, L(1.0 / 120.0));
  even = fma(even, r2, L(0.5));
  odd = fma(odd, r2, L(1.0 / 6.0));
  odd = fma(odd, r2, L(1.0));
  const L p = L(1.0) + fma(odd, r, even * r2);
  return detail::keep_nan(x, detail::scale_by_bits(p, rounded));
}

/// 1 / (1 + e^-x), within 3 ulp; (35) at kappa_A = 1, in two branches so that neither overflows.
template <Real L>
L logistic(L x) {
  const L e = exp(where_negative(x, x, -x));
  const L s = L(1.0) / (L(1.0) + e);
  return where_negative(x, e * s, s);
}

namespace detail {

/// ln x for a normal x > 0.
template <Real L>
L log_of_normal(L x) {
  // x = 2^n p, ln p = 2 artanh(f / (2 + f)), f = p - 1; ln 2 in two parts.
  L rounded;
  const L f = mantissa(x, rounded) - L(1.0);
  const L n = rounded - L(round_magic);
  const L s = f / (L(2.0) + f);
  const L z = s * s;
  L r = L(1.479819860511658591e-01);
  r = fma(r, z, L(1.531383769920937332e-01));
  r = fma(r, z, L(1.818357216161805012e-01));
  r = fma(r, z, L(2.222219843214978396e-01));
  r = fma(r, z, L(2.857142874366239149e-01));
  r = fma(r, z, L(3.999999999940941908e-01));
  r = fma(r, z, L(6.666666666666735130e-01));
  const L half = L(0.5) * f * f;
  const L tail = fma(n, L(1.90821492927058770002e-10), s * fma(r, z, half));
  return n * L(6.93147180369123816490e-01) - ((half - tail) - f);
}

}  // namespace detail

/// ln x for x >= 1; below 1, the parabola -(1 - x) - (1 - x)^2 / 2, which continues its value,
/// slope and curvature. Within 2 ulp for x >= 1. If the square overflows, so does the result.
template <Real L>
L relaxed_log(L x) {
  const L above = maximum(x, L(1.0)), below = above - x;
  return detail::log_of_normal(above) - fma(L(0.5) * below, below, below);
}

/// ln x, within 2 ulp. Zero and subnormals give the log of the smallest normal number, -708.4; x <
/// 0 gives NaN.
template <Real L>
L log(L x) {
  const L y = detail::log_of_normal(clamp(x, 2.2250738585072014e-308, 1.7976931348623157e308));
  return detail::keep_nan(x, where_negative(x, L(std::numeric_limits<double>::quiet_NaN()), y));
}

/// ln(1 + e^x), the integral of `logistic`, within 4 ulp; neither branch overflows.
template <Real L>
L softplus(L x) {
  const L e = exp(where_negative(x, x, -x));
  const L u = L(1.0) + e;
  const L tail = log(u) + (e - (u - L(1.0))) / u;  // adds the rounding error of u
  return where_negative(x, tail, x + tail);
}

/// The angle of (x, y) from the x axis, in [-pi, pi], within 3 ulp; 0 at the origin.
template <Real L>
L atan2(L y, L x) {
  const L ax = where_negative(x, -x, x), ay = where_negative(y, -y, y);
  const L steep = ax - ay;  // < 0: nearer to the y axis
  const L large = clamp(where_negative(steep, ay, ax), 2.2250738585072014e-308, 1.7976931348623157e308);
  const L small = where_negative(steep, ax, ay);
  // atan t, t = small / large in [0, 1]; above 0.66 as pi/4 + atan((t - 1) / (t + 1)).
  const L t = small / large;
  const L beyond = L(0.66) - t;
  const L r = where_negative(beyond, (small - large) / (small + large), t);
  const L z = r * r;
  L p = fma(z, L(-8.750608600031904122785e-01), L(-1.615753718733365076637e+01));
  p = fma(z, p, L(-7.500855792314704667340e+01));
  p = fma(z, p, L(-1.228866684490136173410e+02));
  p = fma(z, p, L(-6.485021904942025371773e+01));
  L q = z + L(2.485846490142306297962e+01);
  q = fma(z, q, L(1.650270098316988542046e+02));
  q = fma(z, q, L(4.328810604912902668951e+02));
  q = fma(z, q, L(4.853903996359136964868e+02));
  q = fma(z, q, L(1.945506571482613964425e+02));
  const L atan = fma(r, z * p / q, r);
  L a = where_negative(beyond, (atan + L(3.061616997868383e-17)) + L(7.85398163397448309616e-01), atan);
  a = where_negative(steep, (L(6.123233995736766e-17) - a) + L(1.57079632679489661923), a);
  a = where_negative(x, (L(1.2246467991473532e-16) - a) + L(3.14159265358979323846), a);
  a = where_negative(y, -a, a);
  return detail::keep_nan(x, detail::keep_nan(y, a));
}

template <Real L>
struct SinCos {
  L sin, cos;
};

/// sin x and cos x, within 1.6 ulp for |x| <= 1e6. Beyond 2^51 a double does not resolve the angle;
/// the results are only within [-1, 1].
template <Real L>
SinCos<L> sincos(L x) {
  // x = n pi/2 + r, |r| <= pi/4, pi/2 in three parts.
  const L rounded = fma(x, L(6.36619772367581382433e-01), L(detail::round_magic));
  const L n = rounded - L(detail::round_magic);
  L r = fma(n, L(-1.57079632679489655800e+00), x);
  r = fma(n, L(-6.12323399573676603587e-17), r);
  r = fma(n, L(1.49738490485916983e-33), r);
  r = clamp(r, -0.78539816339744839, 0.78539816339744839);
  // Minimax polynomials on [-pi/4, pi/4].
  const L z = r * r;
  L s = L(1.58969099521155010221e-10);
  s = fma(s, z, L(-2.50507602534068634195e-08));
  s = fma(s, z, L(2.75573137070700676789e-06));
  s = fma(s, z, L(-1.98412698298579493134e-04));
  s = fma(s, z, L(8.33333333332248946124e-03));
  s = fma(s, z, L(-1.66666666666666324348e-01));
  const L sine = fma(s * z, r, r);
  L c = L(-1.13596475577881948265e-11);
  c = fma(c, z, L(2.08757232129817482790e-09));
  c = fma(c, z, L(-2.75573143513906633035e-07));
  c = fma(c, z, L(2.48015872894767294178e-05));
  c = fma(c, z, L(-1.38888888888741095749e-03));
  c = fma(c, z, L(4.16666666666666019037e-02));
  const L half = L(0.5) * z;
  const L w = L(1.0) - half;
  const L cosine = w + fma(z * z, c, (L(1.0) - w) - half);
  // Rotate by n quarter turns.
  const L sin_x = detail::where_bit(rounded, 1, cosine, sine);
  const L cos_x = detail::where_bit(rounded, 1, sine, cosine);
  const L turned = rounded + L(1.0);  // cos is negative in quarters 1 and 2
  return {detail::where_bit(rounded, 2, -sin_x, sin_x), detail::where_bit(turned, 2, -cos_x, cos_x)};
}

template <Real L>
L sin(L x) {
  return sincos(x).sin;
}

template <Real L>
L cos(L x) {
  return sincos(x).cos;
}

// A value and its rate: the time derivative of a formula along a motion, in one pass.
//
// It serves where one directional derivative suffices: a robot's velocity is the rate of its
// pose(x) with x' = f(x, u). It works over double and over the recording scalar.

template <class S>
struct Tangent {
  S value{}, rate{};

  Tangent() = default;
  Tangent(double constant) : value(constant), rate(0.0) {}
  Tangent(const S& v, const S& r) : value(v), rate(r) {}

  friend Tangent operator+(const Tangent& a, const Tangent& b) {
    return {a.value + b.value, a.rate + b.rate};
  }
  friend Tangent operator-(const Tangent& a, const Tangent& b) {
    return {a.value - b.value, a.rate - b.rate};
  }
  friend Tangent operator-(const Tangent& a) { return {-a.value, -a.rate}; }
  friend Tangent operator*(const Tangent& a, const Tangent& b) {
    return {a.value * b.value, a.rate * b.value + a.value * b.rate};
  }
  friend Tangent operator/(const Tangent& a, const Tangent& b) {
    const S q = a.value / b.value;
    return {q, (a.rate - q * b.rate) / b.value};
  }
  Tangent& operator+=(const Tangent& b) { return *this = *this + b; }
  Tangent& operator-=(const Tangent& b) { return *this = *this - b; }
  Tangent& operator*=(const Tangent& b) { return *this = *this * b; }

  friend Tangent sqrt(const Tangent& a) {
    const S r = sqrt(a.value);
    return {r, a.rate / (2.0 * r)};
  }
  friend Tangent exp(const Tangent& a) {
    const S e = exp(a.value);
    return {e, a.rate * e};
  }
  friend Tangent logistic(const Tangent& a) {
    const S s = logistic(a.value);
    return {s, a.rate * (s * (1.0 - s))};
  }
  friend Tangent relaxed_log(const Tangent& a) {
    const S above = maximum(a.value, S(1.0));
    return {relaxed_log(a.value), a.rate * (1.0 / above + (above - a.value))};
  }
  friend Tangent log(const Tangent& a) { return {log(a.value), a.rate / a.value}; }
  friend Tangent softplus(const Tangent& a) { return {softplus(a.value), a.rate * logistic(a.value)}; }
  friend Tangent atan2(const Tangent& a, const Tangent& b) {
    const S squares = a.value * a.value + b.value * b.value;
    return {atan2(a.value, b.value), (a.rate * b.value - a.value * b.rate) / squares};
  }
  friend Tangent sin(const Tangent& a) { return {sin(a.value), a.rate * cos(a.value)}; }
  friend Tangent cos(const Tangent& a) { return {cos(a.value), -(a.rate * sin(a.value))}; }
};

// Small vectors over any scalar: double, a lane pack, or the recording scalar.

/// A heading d = (d_x, d_y) = (cos psi, sin psi), (18), (19); or any vector in the plane.
template <class S>
struct Vec2 {
  S x{}, y{};
};

/// A vector with three components: a position [m] or a velocity [m/s].
template <class S>
struct Vec3 {
  S x{}, y{}, z{};

  friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator*(const S& s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
};

template <class S>
S dot(const Vec2<S>& a, const Vec2<S>& b) {
  return a.x * b.x + a.y * b.y;
}

template <class S>
S dot(const Vec3<S>& a, const Vec3<S>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class S>
S norm(const Vec3<S>& a) {
  return sqrt(dot(a, a));
}

/// sqrt(x^2 + y^2), within 1 ulp if the squares are normal: for lengths from 1e-150 to 1e150.
/// Beyond, it is 0 or infinite, because it does not scale. std::hypot scales, but its bits differ
/// between machines.
template <Real L>
L norm(L x, L y) {
  return sqrt(fma(x, x, y * y));
}

}  // namespace sightline

// Subnormal numbers as zero within a scope: each costs a hundred cycles and has no meaning here.

namespace sightline {

/// Sets flush-to-zero and denormals-are-zero on the calling thread; the destructor restores the
/// mode.
class FlushSubnormals {
 public:
#if defined(__SSE2__)
  FlushSubnormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | 0x8040u); }
  ~FlushSubnormals() { _mm_setcsr(saved_); }
#elif defined(__aarch64__)
  FlushSubnormals() {
    asm volatile("mrs %0, fpcr" : "=r"(saved_));
    asm volatile("msr fpcr, %0" ::"r"(saved_ | (std::uint64_t{1} << 24)));
  }
  ~FlushSubnormals() { asm volatile("msr fpcr, %0" ::"r"(saved_)); }
#else
  FlushSubnormals() {}
#endif
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

#if defined(__SSE2__)
 private:
  unsigned saved_;
#elif defined(__aarch64__)
 private:
  std::uint64_t saved_;
#endif
};

/// Rounding mode and handling of subnormal numbers of the calling thread.
#if defined(__SSE2__)
using FloatMode = unsigned;
inline FloatMode float_mode() { return _mm_getcsr(); }
inline void set_float_mode(FloatMode mode) { _mm_setcsr(mode); }
#elif defined(__aarch64__)
using FloatMode = std::uint64_t;
inline FloatMode float_mode() {
  FloatMode mode;
  asm volatile("mrs %0, fpcr" : "=r"(mode));
  return mode;
}
inline void set_float_mode(FloatMode mode) { asm volatile("msr fpcr, %0" ::"r"(mode)); }
#else
using FloatMode = int;
inline FloatMode float_mode() { return 0; }
inline void set_float_mode(FloatMode) {}
#endif

// A fork-join thread pool for tasks of microseconds: the phases of a control update.
//
//   pool.share(groups, [&](int group, int thread) noexcept { ... });
//
// Any thread runs each part once, and all parts are done when share() returns. The result of a
// part must not depend on other parts or on the thread. Then the results do not depend on the
// number of threads. Sums over parts are computed afterwards, in order.

class ServiceThread;

/// The constructor allocates memory and starts threads; share() neither allocates nor locks.
/// Workers spin for some microseconds for work, then sleep. The caller of share() works too. Each
/// thread takes over parts that another thread has not begun, so a preempted thread delays only the
/// part it runs. Workers compute in the floating point mode of the caller.
class ThreadPool {
 public:
  static constexpr int most = 64;  ///< maximum number of threads

  /// @param threads  including the calling thread, 1 to `most`; 1: no thread is started
  /// @throws std::invalid_argument for another number of threads, std::system_error if the machine
  ///   has no thread
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return threads_; }

  /// Calls work(part, thread) for each part of 0 .. parts - 1. `thread` is below threads() and
  /// differs between parts that run at the same time. If another thread is in share(), or the call
  /// is nested in a part, the caller runs all parts.
  template <class Work>
  void share(int parts, Work&& work) noexcept {
    const Call call = [](void* at, int part, int thread) {
      (*static_cast<std::remove_reference_t<Work>*>(at))(part, thread);
    };
    if (threads_ > 1 && parts > 1 &&
        share_out(parts, call, const_cast<void*>(static_cast<const void*>(&work))))
      return;
    for (int part = 0; part < parts; ++part) work(part, 0);
  }

 private:
  using Call = void (*)(void* work, int part, int thread);

  /// The parts of one thread that have not begun, and their job. They are packed in one word, so
  /// that one atomic step takes a part of the current job or none.
  struct alignas(64) Range {
    std::atomic<std::uint64_t> word{0};
  };

  bool share_out(int parts, Call call, void* work) noexcept;
  void work_on(int thread) noexcept;
  bool take(Range& range, int& part) noexcept;
  void wait_for_work(int thread) noexcept;
  void end() noexcept;

  int threads_;
  // State of the current job: written before its ranges, read after one of its parts was taken.
  Call call_ = nullptr;
  void* work_ = nullptr;
  int parts_ = 0;
  FloatMode mode_{};
  std::unique_ptr<Range[]> ranges_;  // of each thread
  alignas(64) std::atomic<std::uint32_t> job_{0};
  alignas(64) std::atomic<int> done_{0};
  std::atomic<bool> busy_{false}, stop_{false};
  std::unique_ptr<std::unique_ptr<ServiceThread>[]> others_;
};

/// The given pool if it exists and pays, else a pool of one thread.
std::shared_ptr<ThreadPool> thread_pool_if(bool pays, std::shared_ptr<ThreadPool> pool);

// Small matrices of a fixed size: covariances, gains and rotations of filters. Nothing allocates.

/// r x c numbers, row by row; initially 0.
template <int r, int c>
struct Mat {
  static_assert(r > 0 && c > 0);
  static constexpr int rows = r, columns = c;

  std::array<std::array<double, static_cast<std::size_t>(c)>, static_cast<std::size_t>(r)> row{};

  double& operator()(int i, int j) noexcept {
    return row[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }
  double operator()(int i, int j) const noexcept {
    return row[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }

  friend Mat operator+(Mat a, const Mat& b) noexcept { return a += b; }
  friend Mat operator-(Mat a, const Mat& b) noexcept {
    for (int i = 0; i < r; ++i)
      for (int j = 0; j < c; ++j) a(i, j) -= b(i, j);
    return a;
  }
  friend Mat operator*(double s, Mat a) noexcept {
    for (int i = 0; i < r; ++i)
      for (int j = 0; j < c; ++j) a(i, j) *= s;
    return a;
  }
  Mat& operator+=(const Mat& b) noexcept {
    for (int i = 0; i < r; ++i)
      for (int j = 0; j < c; ++j) (*this)(i, j) += b(i, j);
    return *this;
  }
  bool operator==(const Mat&) const = default;
};

/// Each sum runs over the rows of b in their order, for any size.
template <int r, int k, int c>
Mat<r, c> operator*(const Mat<r, k>& a, const Mat<k, c>& b) noexcept {
  Mat<r, c> y;
  for (int i = 0; i < r; ++i) {
    std::array<double, static_cast<std::size_t>(c)> sum{};  // a row that fits in registers
    for (int l = 0; l < k; ++l)
      for (int j = 0; j < c; ++j) sum[static_cast<std::size_t>(j)] += a(i, l) * b(l, j);
    y.row[static_cast<std::size_t>(i)] = sum;
  }
  return y;
}

template <int r, int c>
Mat<c, r> transposed(const Mat<r, c>& a) noexcept {
  Mat<c, r> y;
  for (int i = 0; i < r; ++i)
    for (int j = 0; j < c; ++j) y(j, i) = a(i, j);
  return y;
}

template <int n>
Mat<n, n> identity(double scale = 1.0) noexcept {
  Mat<n, n> y;
  for (int i = 0; i < n; ++i) y(i, i) = scale;
  return y;
}

template <int n>
double trace(const Mat<n, n>& a) noexcept {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a(i, i);
  return sum;
}

/// The h x w block whose first entry is (i, j).
template <int h, int w, int r, int c>
Mat<h, w> block(const Mat<r, c>& a, int i, int j) noexcept {
  Mat<h, w> y;
  for (int k = 0; k < h; ++k)
    for (int l = 0; l < w; ++l) y(k, l) = a(i + k, j + l);
  return y;
}
template <int h, int w, int r, int c>
void set_block(Mat<r, c>& a, int i, int j, const Mat<h, w>& b) noexcept {
  for (int k = 0; k < h; ++k)
    for (int l = 0; l < w; ++l) a(i + k, j + l) = b(k, l);
}
/// Sets the same block, and its transpose at (j, i), of a symmetric matrix.
template <int h, int w, int n>
void set_both(Mat<n, n>& a, int i, int j, const Mat<h, w>& b) noexcept {
  set_block(a, i, j, b);
  set_block(a, j, i, transposed(b));
}

/// a <- (a + a^T) / 2.
template <int n>
void make_symmetric(Mat<n, n>& a) noexcept {
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) a(i, j) = a(j, i) = 0.5 * (a(i, j) + a(j, i));
}

template <int n>
using Column = Mat<n, 1>;

inline Column<3> column(const Vec3<double>& v) noexcept { return {{{{v.x}, {v.y}, {v.z}}}}; }
template <int n>
Vec3<double> vec3(const Column<n>& a, int from = 0) noexcept {
  return {a(from, 0), a(from + 1, 0), a(from + 2, 0)};
}
inline Vec3<double> operator*(const Mat<3, 3>& a, const Vec3<double>& v) noexcept {
  return {a(0, 0) * v.x + a(0, 1) * v.y + a(0, 2) * v.z, a(1, 0) * v.x + a(1, 1) * v.y + a(1, 2) * v.z,
          a(2, 0) * v.x + a(2, 1) * v.y + a(2, 2) * v.z};
}
/// a b^T.
inline Mat<3, 3> outer(const Vec3<double>& a, const Vec3<double>& b) noexcept {
  return {{{{a.x * b.x, a.x * b.y, a.x * b.z},
            {a.y * b.x, a.y * b.y, a.y * b.z},
            {a.z * b.x, a.z * b.y, a.z * b.z}}}};
}

/// Factor A = L L^T of a symmetric positive definite matrix. For any other matrix, or one that is
/// not finite, `positive` is false and solve() must not be called.
template <int n>
class Cholesky {
 public:
  explicit Cholesky(const Mat<n, n>& A) noexcept {
    for (int i = 0; i < n && positive; ++i) {
      for (int j = 0; j <= i; ++j) {
        double sum = A(i, j);
        for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
        if (j < i) {
          L(i, j) = sum / L(j, j);
        } else {
          positive = sum > 0 && sum < 1e300;
          L(i, i) = positive ? sqrt(sum) : 1.0;
        }
      }
    }
  }

  /// L^-1 B.
  template <int c>
  Mat<n, c> forward(Mat<n, c> B) const noexcept {
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < i; ++k)
        for (int j = 0; j < c; ++j) B(i, j) -= L(i, k) * B(k, j);
      for (int j = 0; j < c; ++j) B(i, j) /= L(i, i);
    }
    return B;
  }
  /// A^-1 B.
  template <int c>
  Mat<n, c> solve(const Mat<n, c>& B) const noexcept {
    Mat<n, c> y = forward(B);
    for (int i = n - 1; i >= 0; --i) {
      for (int k = i + 1; k < n; ++k)
        for (int j = 0; j < c; ++j) y(i, j) -= L(k, i) * y(k, j);
      for (int j = 0; j < c; ++j) y(i, j) /= L(i, i);
    }
    return y;
  }

  Mat<n, n> L;
  bool positive = true;
};

/// The upper triangle of a symmetric matrix, row by row from the diagonal on.
template <int n>
std::array<double, static_cast<std::size_t>(n*(n + 1) / 2)> upper_triangle(const Mat<n, n>& A) noexcept {
  std::array<double, static_cast<std::size_t>(n * (n + 1) / 2)> all{};
  std::size_t place = 0;
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j) all[place++] = A(i, j);
  return all;
}

/// e^T A^-1 e, the squared Mahalanobis distance of e under the covariance A; infinite where A is
/// not positive definite.
template <int n>
double mahalanobis(const Column<n>& e, const Mat<n, n>& A) noexcept {
  const Cholesky<n> factor(A);
  if (!factor.positive) return std::numeric_limits<double>::infinity();
  const Column<n> y = factor.forward(e);
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += y(i, 0) * y(i, 0);
  return sum;
}

/// Marks a value that does not exist.
inline constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

inline constexpr double infinity = std::numeric_limits<double>::infinity();

// Rotations as 3 x 3 matrices, and angles on the circle.

/// The equivalent angle in [-pi, pi].
inline double wrap(double angle) noexcept { return std::remainder(angle, 2 * std::numbers::pi); }

/// [v]: [v] a = v x a.
inline Mat<3, 3> cross_matrix(const Vec3<double>& v) noexcept {
  return {{{{0, -v.z, v.y}, {v.z, 0, -v.x}, {-v.y, v.x, 0}}}};
}

/// Rotation by an angle [rad] about one axis.
inline Mat<3, 3> turn_x(double angle) noexcept {
  const SinCos<double> a = sincos(angle);
  return {{{{1, 0, 0}, {0, a.cos, -a.sin}, {0, a.sin, a.cos}}}};
}
inline Mat<3, 3> turn_y(double angle) noexcept {
  const SinCos<double> a = sincos(angle);
  return {{{{a.cos, 0, a.sin}, {0, 1, 0}, {-a.sin, 0, a.cos}}}};
}
inline Mat<3, 3> turn_z(double angle) noexcept {
  const SinCos<double> a = sincos(angle);
  return {{{{a.cos, -a.sin, 0}, {a.sin, a.cos, 0}, {0, 0, 1}}}};
}

/// exp([w]), the rotation by |w| [rad] about w (Rodrigues).
inline Mat<3, 3> turn(const Vec3<double>& w) noexcept {
  const double angle = norm(w);
  const SinCos<double> half = sincos(0.5 * angle);
  // sin(a) / a and (1 - cos a) / a^2 = 2 (sin(a/2) / a)^2, without a difference of nearly equal
  // numbers.
  const double s = angle > 1e-8 ? half.sin / angle : 0.5;
  const Mat<3, 3> W = cross_matrix(w);
  return identity<3>() + (2 * s * half.cos) * W + (2 * s * s) * (W * W);
}

/// First-order projection of R onto the rotations: R (3 - R^T R) / 2.
inline Mat<3, 3> orthonormal(const Mat<3, 3>& R) noexcept {
  return R * (identity<3>(1.5) - 0.5 * (transposed(R) * R));
}

/// Yaw of an attitude R_GB = turn_z(yaw) turn_y(pitch) turn_x(roll).
inline double yaw_of(const Mat<3, 3>& R) noexcept { return atan2(R(1, 0), R(0, 0)); }

/// d yaw / d theta of R exp([theta]) at theta = 0; [-] per axis of B. Not finite where the x axis is
/// vertical.
inline Vec3<double> yaw_gradient(const Mat<3, 3>& R) noexcept {
  const double x = R(0, 0), y = R(1, 0), level = x * x + y * y;
  return {0.0, (y * R(0, 2) - x * R(1, 2)) / level, (x * R(1, 1) - y * R(0, 1)) / level};
}

// Comparison of times: they are sums or multiples of periods, so equal times differ by rounding.

/// Times that differ by less are equal [s].
inline constexpr double same_time = 1e-9;

// The exception that ended a service beside the control thread: kept as a sentence and reported
// once. Nothing here allocates or throws.

/// Receives a line, "sightline: the page has ended: ...\n", from any thread.
using FailureReport = void (*)(std::string_view line) noexcept;

/// Sets the destination of the lines for the whole process. Before the first call they go to stderr
/// by write(2).
/// @param report  null: stderr
void report_failures_to(FailureReport report) noexcept;

/// The first failure of one service. Any thread may record and read it.
class Failure {
 public:
  /// Records and reports the exception in flight. Only the first call has an effect.
  /// @param service  the failed service, "the page"; the text must outlive this object
  void record(const char* service) noexcept;

  bool occurred() const noexcept { return state_.load(std::memory_order_acquire) == State::kept; }
  /// "the page has ended: there is not enough memory"; empty if nothing failed. At most
  /// `length_max` bytes.
  std::string_view sentence() const noexcept;

  static constexpr std::size_t length_max = 400;

 private:
  enum class State { none, taken, kept };

  std::atomic<State> state_{State::none};
  std::array<char, length_max + 16> line_{};  // the reported line
  std::size_t length_ = 0;                    // bytes used of line_
};

// The threads of the process. No other file creates one; scripts/lint.py checks this.

/// Thread of a service beside the control thread: a page, a publisher, a log. An exception of its
/// function ends that service alone: it is caught and reported once (Failure), and the process
/// continues. The same holds if the machine has no thread for it.
class ServiceThread {
 public:
  /// @param service  name for reports, "the page"; the text must outlive this object
  explicit ServiceThread(const char* service) noexcept : service_(service) {}
  /// As start().
  template <class Run>
  ServiceThread(const char* service, Run run) noexcept : ServiceThread(service) {
    start(std::move(run));
  }
  ~ServiceThread() { join(); }
  ServiceThread(const ServiceThread&) = delete;
  ServiceThread& operator=(const ServiceThread&) = delete;

  /// Runs a function on the thread; may be called once.
  /// @param on_failure  stops the service; called by that thread after run() threw, by the caller
  ///   if the machine had no thread. Its exceptions are dropped
  template <class Run, class OnFailure>
  void start(Run run, OnFailure on_failure) noexcept {
    try {
      thread_ = std::thread([this, run = std::move(run), on_failure]() mutable noexcept {
        try {
          run();
        } catch (...) {
          fail(on_failure);
        }
      });
    } catch (...) {
      fail(on_failure);
    }
  }
  template <class Run>
  void start(Run run) noexcept {
    start(std::move(run), [] {});
  }
  /// As start(), for a function that does not throw and without which a flight cannot begin.
  /// @throws std::system_error if the machine has no thread
  template <class Run>
  void start_or_throw(Run run) {
    static_assert(std::is_nothrow_invocable_v<Run&>, "what a flight waits for must not throw");
    thread_ = std::thread(std::move(run));
  }

  /// Waits until the function ends; the destructor calls it too.
  void join() noexcept {
    if (thread_.joinable()) thread_.join();
  }

  bool failed() const noexcept { return failure_.occurred(); }
  /// Why the service has ended; empty if nothing failed.
  std::string_view failure() const noexcept { return failure_.sentence(); }

 private:
  template <class OnFailure>
  void fail(OnFailure& on_failure) noexcept {
    failure_.record(service_);
    try {
      on_failure();
    } catch (...) {
      static_cast<void>(0);  // the service is over in any case
    }
  }

  const char* service_;
  Failure failure_;
  std::thread thread_;
};

/// Runs a function on a separate thread and waits for its end. Changes to the thread, such as its
/// priority or floating point mode, end with it.
/// @throws the exceptions of the function; std::system_error if the machine has no thread
template <class Run>
void run_apart(Run&& run) {
  std::exception_ptr thrown;
  std::thread([&]() noexcept {
    try {
      run();
    } catch (...) {
      thrown = std::current_exception();
    }
  }).join();
  if (thrown) std::rethrow_exception(thrown);
}

/// Result of a function that runs on a separate thread. The future rethrows its exception; the
/// future's destructor waits for the thread.
/// @throws std::system_error if the machine has no thread
template <class Run>
auto run_for_value(Run run) {
  return std::async(std::launch::async, std::move(run));
}

/// Runs a function on a detached thread; the function owns the data it uses. Its exceptions are
/// dropped.
/// @return whether the machine has a thread
template <class Run>
bool run_unattended(Run run) noexcept {
  try {
    std::thread([run = std::move(run)]() mutable noexcept {
      try {
        run();
      } catch (...) {
        static_cast<void>(0);  // the thread is detached
      }
    }).detach();
    return true;
  } catch (...) {
    return false;
  }
}

// Rejects an argument: the message states the fault, the value and the expectation.

/// @throws std::invalid_argument with the formatted sentence, always
template <class... Args>
[[noreturn]] void throw_invalid(fmt::format_string<Args...> sentence, Args&&... args) {
  throw std::invalid_argument(fmt::format(sentence, std::forward<Args>(args)...));
}

// Transposition of W packs of W lanes: from one entry of all robots per pack to one robot per
// pack.

namespace detail {

/// Exchanges the lanes of b whose index lacks bit S with the lanes of a whose index has it.
template <int S, int W>
void exchange(Lane<W>& a, Lane<W>& b) {
  using L = Lane<W>;
  const auto exchanged = [&]<int... i>(std::integer_sequence<int, i...>) {
#if defined(__clang__)
    return std::pair{L(typename L::Vector{((i & S) == 0 ? a.v[i] : b.v[i - S])...}),
                     L(typename L::Vector{((i & S) == 0 ? a.v[i + S] : b.v[i])...})};
#else
    return std::pair{L(__builtin_shuffle(a.v, b.v, typename L::Bits{((i & S) == 0 ? i : W + i - S)...})),
                     L(__builtin_shuffle(a.v, b.v, typename L::Bits{((i & S) == 0 ? i + S : W + i)...}))};
#endif
  }
  (std::make_integer_sequence<int, W>());
  a = exchanged.first;
  b = exchanged.second;
}

template <int S, int W>
void transpose_by(std::array<Lane<W>, static_cast<std::size_t>(W)>& rows) {
  constexpr auto apart = static_cast<std::size_t>(S);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if ((i & apart) == 0) exchange<S>(rows[i], rows[i + apart]);
  }
  if constexpr (2 * S < W) transpose_by<2 * S>(rows);
}

}  // namespace detail

/// Exchanges lane j of rows[i] with lane i of rows[j].
template <int W>
void transpose(std::array<Lane<W>, static_cast<std::size_t>(W)>& rows) {
  if constexpr (W > 1) detail::transpose_by<1>(rows);
}

/// Stores the first `count` numbers of a pack, 0 <= count <= W.
template <int W>
void store_first(Lane<W> pack, int count, double* to) {
#if defined(__AVX512F__)
  if constexpr (W == 8) {
    _mm512_mask_storeu_pd(to, static_cast<__mmask8>((1U << count) - 1), (__m512d)pack.v);
    return;
  }
#endif
  for (int i = 0; i < count; ++i) to[i] = pack[i];
}

}  // namespace sightline
