/// Potentials, references and constraints of robots, type-erased, so that teams can be composed at run time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/model.hpp"

namespace sightline {

// Step functions of an inequality: epsilon(c) is 1 where c <= 0 is violated and 0 where it holds,
// (29).
//
// A potential is written once over its step. UnitStep gives the exact region, for plots and tests;
// SigmoidStep the smooth form, (35), which the solver uses.

/// epsilon(c), (29).
struct UnitStep {
  template <class S>
  S operator()(const S& c) const {
    return c > 0.0 ? S(1.0) : S(0.0);
  }
};

/// sig(c, kappa_A) = 1 / (1 + e^(-kappa_A c)), (35); tends to (29) as kappa_A grows, (37).
struct SigmoidStep {
  double kappa_A;

  template <class S>
  S operator()(const S& c) const {
    return logistic(kappa_A * c);
  }
};

// Type-erased potential of any kind, with its weight.
//
// A potential is a struct with `template <class S> S operator()(...) const` over the Sights of two
// robots (a coupling) or of one (a constraint of that robot). It may have the time [s] as a last
// argument:
//
//   S operator()(const Sight<S>& observer, const Sight<S>& target) const;
//   S operator()(const Sight<S>& robot, const S& time) const;
//
// If it states a limit, it has `double violation(same Sights) const`, with the time as above. The
// result is > 0 where the limit is violated, in the limit's unit. Its name is `name`, a constant
// of the type or a function. Its parameters are described by `parameters()` (base.hpp).
// Further optional properties are constants or functions:
//
//   limit_unit    unit of the violation, "m"; default: "in its own unit"
//   keeps_apart   whether the limit is a least distance; default: sampled
//   observes      whether the first body observes the second; default: it has a sensor and
//                 does not keep the bodies apart
//   mount         the sensor's mount on the observer; a scenario sets it from [agent.NAME.sensor]
//   alpha         with a sensor: the angle of view [rad]
//   d_min, d_max  the limits of the distance [m]
//   sees_third    whether it depends on Sight::third of the first body; default: no

inline constexpr double half_pi = std::numbers::pi / 2;

/// @throws std::invalid_argument "potential.field = value, expected ..." unless the condition holds
/// and the value is finite
void require(bool holds, std::string_view potential, std::string_view field, double value,
             std::string_view expected);

/// Range of the angles of a field of view.
inline constexpr Bounds acute_angle = {std::numeric_limits<double>::min(), half_pi*(1 - 1e-16),
                                       "in (0, pi/2)"};

/// @throws std::invalid_argument unless the pitch is in mount_pitches, the offset is finite and
/// `sigmas` >= 0
void check_mount(std::string_view potential, const SensorMount& mount);

/// Corners of a potential that are smoothed, over a width in the unit of the function with the
/// corner.
struct Rounding {
  double width;
  std::set<std::string> corners;  ///< "abs", "min"
};

template <class P, class S>
concept PairPotentialOver = requires(const P& p, const Sight<S>& a, const S& t) {
  { p(a, a) } -> std::same_as<S>;
}
|| requires(const P& p, const Sight<S>& a, const S& t) {
  { p(a, a, t) } -> std::same_as<S>;
};
template <class P, class S>
concept SinglePotentialOver = requires(const P& p, const Sight<S>& a, const S& t) {
  { p(a) } -> std::same_as<S>;
}
|| requires(const P& p, const Sight<S>& a, const S& t) {
  { p(a, t) } -> std::same_as<S>;
};

/// Potential of two robots.
template <class P>
concept PairPotential = PairPotentialOver<P, double> && PairPotentialOver<P, Symbol>;
/// Potential of one robot.
template <class P>
concept SinglePotential =
    !PairPotential<P> && SinglePotentialOver<P, double> && SinglePotentialOver<P, Symbol>;

/// A potential of any type; immutable and shared. A potential of a single robot ignores the second
/// Sight. If its function throws for numbers, the value is NaN.
class Potential {
 public:
  /// @throws std::invalid_argument for a parameter out of its range, and from the potential's own
  /// check()
  template <class P>
  requires PairPotential<P> || SinglePotential<P> Potential(const P& potential)
      : block_(std::make_shared<const Block<P>>(potential)) {
    if constexpr (Described<P>) check_parameters(potential);
    if constexpr (requires { potential.check(); }) potential.check();
  }

  std::string_view name() const { return block_->name; }
  bool is_pair() const { return block_->is_pair; }
  /// Descriptions of its parameters; empty if the potential does not describe them.
  std::vector<ParameterText> parameters() const { return block_->parameters(); }
  /// Keys and values of the real numbers among them.
  std::vector<std::pair<std::string, double>> numbers() const { return block_->numbers(); }
  /// A copy with another value of number i; it may be out of its range.
  Potential with_number(std::size_t i, double value) const { return block_->with_number(i, value); }

  /// l [-] of the observer a and the target b at time t [s].
  double operator()(const Sight<double>& a, const Sight<double>& b, double t) const noexcept {
    return block_->value(a, b, t);
  }
  Symbol operator()(const Sight<Symbol>& a, const Sight<Symbol>& b, const Symbol& t) const {
    return block_->trace(a, b, t);
  }
  /// > 0 where the limit is violated, in the limit's unit; -infinity for a potential without a
  /// limit.
  double violation(const Sight<double>& a, const Sight<double>& b, double t = 0.0) const noexcept {
    return block_->violation(a, b, t);
  }

  /// Least and greatest distance of two bodies [m], if the potential has a field of this name.
  std::optional<double> d_min() const { return block_->d_min(); }
  std::optional<double> d_max() const { return block_->d_max(); }
  /// Angle of view within which the target counts as in view [rad], if the potential has a sensor
  /// and a field of this name.
  std::optional<double> alpha() const { return block_->alpha(); }
  /// Whether it depends on the position of a third body, Sight::third of its first body.
  bool sees_third() const { return block_->sees_third(); }
  /// Unit of its violation: "m", "rad"; default "in its own unit".
  std::string_view limit_unit() const { return block_->limit_unit; }
  /// Declared properties; none if not declared. keeps_apart() and observes() of protection.hpp then
  /// determine them.
  std::optional<bool> says_keeps_apart() const { return block_->keeps_apart; }
  std::optional<bool> says_observes() const { return block_->observes; }
  /// Its limits that all have to hold, each as a potential; empty if it states a single limit.
  std::vector<Potential> conjuncts() const { return block_->conjuncts(); }
  /// Its smoothed corners, if it is a formula that can have some; and a copy with another width.
  std::optional<Rounding> rounding() const { return block_->rounding(); }
  Potential smoothed_over(double width) const { return block_->smoothed_over(width).value_or(*this); }

  /// l over the unit step, with its slope, (34): 0 where the limit holds. NaN if the potential is
  /// not written over a step.
  double sloped(const Sight<double>& a, const Sight<double>& b, double t = 0.0) const {
    return block_->sloped(a, b, t);
  }
  /// Sharpness of its sigmoid, or none.
  std::optional<double> kappa_A() const { return block_->kappa_A(); }
  /// A copy with another sharpness; itself if it has none.
  Potential sharpened(double kappa_A) const { return block_->sharpened(kappa_A).value_or(*this); }
  /// Mount of its sensor on the observer, nullptr without a sensor; and a copy with another mount.
  const SensorMount* mount() const { return block_->mount(); }
  Potential seen_from(const SensorMount& mount) const { return block_->seen_from(mount).value_or(*this); }

  /// The potential as the type that it was constructed from, or nullptr.
  template <class P>
  const P* as() const {
    const auto* block = dynamic_cast<const Block<P>*>(block_.get());
    return block != nullptr ? &block->potential : nullptr;
  }

 private:
  struct Interface {
    std::string_view name = "potential", limit_unit = "in its own unit";
    bool is_pair = true;
    std::optional<bool> keeps_apart{}, observes{};

    virtual ~Interface() = default;
    virtual std::vector<ParameterText> parameters() const = 0;
    virtual double value(const Sight<double>& a, const Sight<double>& b, double t) const noexcept = 0;
    virtual Symbol trace(const Sight<Symbol>& a, const Sight<Symbol>& b, const Symbol& t) const = 0;
    virtual double violation(const Sight<double>& a, const Sight<double>& b, double t) const noexcept = 0;
    virtual std::optional<double> d_min() const = 0;
    virtual std::optional<double> d_max() const = 0;
    virtual std::optional<double> alpha() const = 0;
    virtual bool sees_third() const = 0;
    virtual std::vector<Potential> conjuncts() const = 0;
    virtual std::optional<Rounding> rounding() const = 0;
    virtual std::optional<Potential> smoothed_over(double width) const = 0;
    virtual double sloped(const Sight<double>& a, const Sight<double>& b, double t) const = 0;
    virtual std::optional<double> kappa_A() const = 0;
    virtual std::optional<Potential> sharpened(double kappa_A) const = 0;
    virtual const SensorMount* mount() const = 0;
    virtual std::optional<Potential> seen_from(const SensorMount& mount) const = 0;
    virtual std::vector<std::pair<std::string, double>> numbers() const = 0;
    virtual Potential with_number(std::size_t i, double value) const = 0;
  };

  template <class P>
  struct Block final : Interface {
    P potential;

    explicit Block(const P& p) : potential(p) {
      if constexpr (requires { potential.name(); }) {
        this->name = potential.name();
      } else if constexpr (requires { P::name; }) {
        this->name = P::name;
      }
      if constexpr (requires { std::string_view(P::limit_unit); }) this->limit_unit = P::limit_unit;
      if constexpr (requires { bool{P::keeps_apart}; }) this->keeps_apart = P::keeps_apart;
      if constexpr (requires { bool{P::observes}; }) this->observes = P::observes;
      this->is_pair = PairPotential<P>;
    }
    std::vector<ParameterText> parameters() const override { return parameter_texts(potential); }
    template <class S>
    S at(const Sight<S>& a, [[maybe_unused]] const Sight<S>& b, [[maybe_unused]] const S& t) const {
      if constexpr (PairPotential<P>) {
        if constexpr (requires { potential(a, b, t); }) {
          return potential(a, b, t);
        } else {
          return potential(a, b);
        }
      } else {
        if constexpr (requires { potential(a, t); }) {
          return potential(a, t);
        } else {
          return potential(a);
        }
      }
    }
    double value(const Sight<double>& a, const Sight<double>& b, double t) const noexcept override {
      return or_nan([&] { return at<double>(a, b, t); });
    }
    Symbol trace(const Sight<Symbol>& a, const Sight<Symbol>& b, const Symbol& t) const override {
      return at<Symbol>(a, b, t);
    }
    double violation([[maybe_unused]] const Sight<double>& a, [[maybe_unused]] const Sight<double>& b,
                     [[maybe_unused]] double t) const noexcept override {
      if constexpr (requires { potential.violation(a, b, t); }) {
        return or_nan([&] { return potential.violation(a, b, t); });
      } else if constexpr (requires { potential.violation(a, b); }) {
        return or_nan([&] { return potential.violation(a, b); });
      } else if constexpr (requires { potential.violation(a, t); }) {
        return or_nan([&] { return potential.violation(a, t); });
      } else if constexpr (requires { potential.violation(a); }) {
        return or_nan([&] { return potential.violation(a); });
      } else {
        return -std::numeric_limits<double>::infinity();
      }
    }
    std::optional<double> d_min() const override {
      if constexpr (requires { double(potential.d_min); }) return potential.d_min;
      return {};
    }
    std::optional<double> d_max() const override {
      if constexpr (requires { double(potential.d_max); }) return potential.d_max;
      return {};
    }
    std::optional<double> alpha() const override {
      if constexpr (requires { double(potential.alpha); }) {
        if (mount() != nullptr) return potential.alpha;
      }
      return {};
    }
    bool sees_third() const override {
      if constexpr (requires { bool{potential.sees_third()}; }) return potential.sees_third();
      return false;
    }
    std::vector<Potential> conjuncts() const override {
      std::vector<Potential> all;
      if constexpr (requires { potential.conjuncts(); }) {
        for (const auto& one : potential.conjuncts()) all.push_back(Potential(one));
      }
      return all;
    }
    std::optional<Rounding> rounding() const override {
      if constexpr (requires { Rounding{potential.width(), potential.smoothed()}; })
        return Rounding{potential.width(), potential.smoothed()};
      return {};
    }
    std::optional<Potential> smoothed_over([[maybe_unused]] double width) const override {
      if constexpr (requires { Potential(potential.smoothed_over(width)); })
        return Potential(potential.smoothed_over(width));
      return {};
    }
    double sloped([[maybe_unused]] const Sight<double>& a, [[maybe_unused]] const Sight<double>& b,
                  [[maybe_unused]] double t) const override {
      if constexpr (requires { potential.sloped(a, b, t); }) {
        return potential.sloped(a, b, t);
      } else if constexpr (requires { potential.over(UnitStep{}, a, b); }) {
        return potential.over(UnitStep{}, a, b);
      } else if constexpr (requires { potential.over(UnitStep{}, a); }) {
        return potential.over(UnitStep{}, a);
      } else {
        return std::numeric_limits<double>::quiet_NaN();
      }
    }
    std::optional<double> kappa_A() const override {
      if constexpr (requires { potential.kappa_A(); }) {
        return potential.kappa_A();
      } else if constexpr (requires { std::optional<double>(potential.kappa_A); }) {
        return potential.kappa_A;
      } else {
        return {};
      }
    }
    std::optional<Potential> sharpened([[maybe_unused]] double kappa_A) const override {
      if constexpr (requires { Potential(potential.sigmoid(kappa_A)); }) {
        return Potential(potential.sigmoid(kappa_A));
      } else if constexpr (requires(P p) { p.kappa_A = kappa_A; }) {
        P other = potential;
        other.kappa_A = kappa_A;
        return Potential(other);
      } else {
        return {};
      }
    }
    const SensorMount* mount() const override {
      if constexpr (requires { potential.is_view(); }) {
        return potential.is_view() ? &potential.mount() : nullptr;
      } else if constexpr (requires(const SensorMount* m) { m = &potential.mount; }) {
        return &potential.mount;
      } else {
        return nullptr;
      }
    }
    std::optional<Potential> seen_from([[maybe_unused]] const SensorMount& mount) const override {
      if constexpr (requires { Potential(potential.seen_from(mount)); }) {
        return Potential(potential.seen_from(mount));
      } else if constexpr (requires(P p) { p.mount = mount; }) {
        P other = potential;
        other.mount = mount;
        return Potential(other);
      } else {
        return {};
      }
    }
    std::vector<std::pair<std::string, double>> numbers() const override {
      std::vector<std::pair<std::string, double>> list;
      P copy = potential;
      for (const NamedNumber& n : numbers_of(copy)) list.emplace_back(n.key, *n.value);
      return list;
    }
    Potential with_number(std::size_t i, double value) const override {
      const auto other = std::make_shared<Block>(potential);
      *numbers_of(other->potential)[i].value = value;
      return Potential(std::shared_ptr<const Interface>(other));
    }
  };

  explicit Potential(std::shared_ptr<const Interface> block) : block_(std::move(block)) {}

  std::shared_ptr<const Interface> block_;
};

/// A potential multiplied by its weight k: `0.4 * SensorCone{}`.
struct Weighted {
  double weight = 1.0;
  Potential potential;
};

template <class P>
requires PairPotential<P> || SinglePotential<P> Weighted operator*(double weight, const P& potential) {
  return {weight, potential};
}

// Weights that change smoothly over time.

/// Factor of a weight: from one value to another with a continuous slope, constant before and
/// after,
///
///   from + (to - from) s^2 (3 - 2 s),   s = (t - begin) / duration in [0, 1].
///
/// A solver uses the factor at the update's time for the whole horizon. Therefore a weight that
/// starts at 0 changes nothing at first, and one that has reached 0 can be removed.
struct Ramp {
  double begin = 0.0, duration = 0.0;  ///< [s], duration >= 0
  double from = 1.0, to = 1.0;         ///< >= 0

  bool operator==(const Ramp&) const = default;
  /// Factor at time t [s].
  double at(double t) const noexcept {
    if (t >= begin + duration) return to;
    if (t <= begin) return from;
    const double s = (t - begin) / duration;
    return from + (to - from) * (s * s * (3.0 - 2.0 * s));
  }

  /// Whether the final weight is > 0.
  bool lasts() const noexcept { return to > 0; }
  /// Whether the weight is constant from t on.
  bool has_settled(double t) const noexcept { return from == to || t >= begin + duration; }
  /// Whether the weight has reached 0 for good.
  bool is_over(double t) const noexcept { return !lasts() && t >= begin + duration; }
};

// Reference of a robot over time: a state, or a pose at rest.

/// A constant pose.
struct Constant {
  static constexpr std::string_view name = "constant";
  Vec3<double> p{};
  std::optional<double> heading{};

  static constexpr auto parameters() {
    return Parameters{needed(parameter("p", &Constant::p, "m", any_finite, "position")),
                      parameter("heading", &Constant::heading, "rad", any_finite, "left out: free")};
  }
  Pose<double> operator()(double) const;
};

/// A circle at constant height: p = centre + radius (cos(rate t), sin(rate t), 0), (70). The
/// heading is free.
struct Circle {
  static constexpr std::string_view name = "circle";
  Vec3<double> centre{};
  double radius = 0.5;
  double rate = 0.3;

  static constexpr auto parameters() {
    return Parameters{
        needed(parameter("centre", &Circle::centre, "m", any_finite, "middle of the circle")),
        parameter("radius", &Circle::radius, "m", from_zero, "radius"),
        parameter("rate", &Circle::rate, "rad/s", any_finite, "how fast it goes round, anticlockwise")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const { check_parameters(*this); }

  template <Real S>
  Pose<S> operator()(S t) const {
    const auto [s, c] = sincos(S(rate) * t);
    return {{fma(S(radius), c, S(centre.x)), fma(S(radius), s, S(centre.y)), S(centre.z)}, {S(0.0), S(0.0)}};
  }
};

namespace detail {

template <class R>
constexpr auto timed_positions() {
  return Parameters{
      ListParameter<R, double>{"times", &R::times, "s", "when; the first pose also holds before", true},
      ListParameter<R, Vec3<double>>{"p", &R::p, "m", "where, for each time"}};
}

template <class R>
constexpr auto timed_headings() {
  return Parameters{
      ListParameter<R, double>{"heading", &R::heading, "rad", "for each time; left out: free", false, false}};
}

template <class R>
constexpr auto timed_velocities() {
  return Parameters{ListParameter<R, Vec3<double>>{"v", &R::v, "m/s",
                                                   "for each time; left out: straight lines", false, false}};
}

}  // namespace detail

/// Straight lines between poses at given times, or with velocities `v` there [m/s] the cubic
/// polynomials that have them; the heading takes the shorter direction. Held before the first and
/// after the last time.
struct Waypoints {
  static constexpr std::string_view name = "waypoints";
  std::vector<double> times;
  std::vector<Vec3<double>> p;
  std::vector<double> heading = {};
  std::vector<Vec3<double>> v = {};

  static constexpr auto parameters() {
    return detail::timed_positions<Waypoints>() + detail::timed_headings<Waypoints>() +
           detail::timed_velocities<Waypoints>();
  }
  /// @throws std::invalid_argument unless the times increase, all lists have equal length and all
  /// numbers are finite
  void check() const;
  Pose<double> operator()(double t) const;
  /// Upper bound of the speed [m/s].
  double top_speed() const;
};

/// Poses that change at given times and hold until the next.
struct Steps {
  static constexpr std::string_view name = "steps";
  std::vector<double> times;
  std::vector<Vec3<double>> p;
  std::vector<double> heading = {};

  static constexpr auto parameters() {
    return detail::timed_positions<Steps>() + detail::timed_headings<Steps>();
  }
  /// @throws std::invalid_argument unless the times increase, all lists have equal length and all
  /// numbers are finite
  void check() const;
  Pose<double> operator()(double t) const;
};

/// A reference x*(t) of any form. A pose represents the robot at rest there; a heading of (0, 0)
/// means no heading. If a function throws, or returns a state of another length, x* is NaN and the
/// solver reports not_finite.
class Reference {
 public:
  /// The origin at rest, without a heading.
  Reference() : Reference([](double) { return Pose<double>{}; }) { constant_ = true; }

  /// t -> Pose<double>.
  /// @throws std::invalid_argument for a parameter out of its range, and from the trajectory's own
  /// check()
  template <std::invocable<double> F>
  requires std::same_as<std::invoke_result_t<F, double>, Pose<double>> Reference(F pose)
      : write_([pose](const Times& times, const Model& model, const Target& x) {
          std::array<Pose<double>, native_width> poses;
          for (int k = 0; k < times.n; k += native_width) {
            const int count = std::min(native_width, times.n - k);
            if constexpr (std::invocable<F, NativeLane>) {
              NativeLane t = times.t;
              for (int l = 0; l < native_width; ++l) t.v[l] = times.at(k + l);
              const Pose<NativeLane> p = pose(t);
              for (int l = 0; l < native_width; ++l)
                poses[static_cast<std::size_t>(l)] = {{p.p.x[l], p.p.y[l], p.p.z[l]}, {p.d.x[l], p.d.y[l]}};
            } else {
              for (int l = 0; l < count; ++l) poses[static_cast<std::size_t>(l)] = pose(times.at(k + l));
            }
            model.at_rest(std::span(poses).first(static_cast<std::size_t>(count)), x.x + k * x.stage, x.stage,
                          x.entry);
          }
        }) {
    if constexpr (requires { pose.check(); }) pose.check();
    if constexpr (Described<F>) check_parameters(pose);
  }

  /// t -> std::array<double, nx>, or another range of constant length: the whole state.
  /// @throws std::invalid_argument if it is empty at t = 0
  template <std::invocable<double> F>
  requires std::convertible_to<std::invoke_result_t<F, double>, std::span<const double>> Reference(F state)
      : write_([state](const Times& times, const Model& model, const Target& x) {
          for (int k = 0; k < times.n; ++k) {
            const auto& value = state(times.at(k));
            x.put(k, value, model.nx());
          }
        }),
        length_(checked_length(std::span<const double>(state(0.0)).size())) {}

  /// A constant state of length nx.
  /// @throws std::invalid_argument if it is empty
  template <std::size_t n>
  Reference(const std::array<double, n>& state)
      : Reference(std::vector<double>(state.begin(), state.end())) {}
  Reference(const std::vector<double>& state)
      : write_([state](const Times& times, const Model& model, const Target& x) {
          for (int k = 0; k < times.n; ++k) x.put(k, state, model.nx());
        }),
        length_(checked_length(state.size())),
        constant_(true) {}

  /// Transition from one reference to another: (1 - ramp) x*_from + ramp x*_to.
  /// @throws std::invalid_argument if both are whole states of different lengths, or one has more
  /// than `max_states`
  static Reference between(const Reference& from, const Reference& to, const Ramp& ramp);

  /// Whether x* is constant in time.
  bool is_constant() const { return constant_; }

  /// Writes x*(t) into x, of length nx; NaN if the reference has another length. Allocates nothing
  /// if the wrapped function does not.
  void operator()(double t, const Model& model, std::span<double> x) const noexcept {
    write_or_nan(x.data(), x.size(), [&] {
      expect(x.size() == static_cast<std::size_t>(model.nx()));
      write_({t, 0.0, 1}, model, {x.data(), 0, 1});
    });
  }
  /// Writes x*(t + k h), k = 0 .. n - 1; entry i of the k-th at x[k stage + i entry].
  void along(double t, double h, int n, const Model& model, double* x, std::ptrdiff_t stage,
             std::ptrdiff_t entry) const noexcept;

  /// Length of its state; 0 for a pose, which suits any robot.
  std::size_t length() const { return length_; }

  /// Largest state in a transition between two references.
  static constexpr int max_states = 64;

 private:
  struct Times {
    double t, h;
    int n;
    double at(int k) const { return t + k * h; }
  };
  struct Target {
    double* x;
    std::ptrdiff_t stage, entry;
    void put(int k, std::span<const double> state, int nx) const {
      expect(state.size() == static_cast<std::size_t>(nx));
      for (std::size_t i = 0; i < state.size(); ++i)
        x[k * stage + static_cast<std::ptrdiff_t>(i) * entry] = state[i];
    }
  };
  /// @throws std::length_error, which the callers convert to NaN
  static void expect(bool fits) {
    if (!fits) throw std::length_error("a state of the reference is of another length");
  }
  /// @throws std::invalid_argument if length is 0
  static std::size_t checked_length(std::size_t length);

  std::function<void(const Times&, const Model&, const Target&)> write_;
  std::size_t length_ = 0;
  bool constant_ = false;
};

// Inequalities of one robot in addition to its input limits: c(x, u) <= 0, enforced by a relaxed
// logarithmic barrier (Feller and Ebenbauer 2017) in its stage cost. docs/equations.md, 12.
//
// A limit is a struct with `template <class S> S operator()(...) const` that returns c, <= 0 where
// the limit holds. Its arguments are the robot's Sight, or its state and input:
//
//   S operator()(const Sight<S>& robot) const;
//   S operator()(std::span<const S> x, std::span<const S> u) const;
//
// The second form may define `int states() const` and `int inputs() const`, the numbers of entries
// that it reads.

template <class C, class S>
concept LimitOver = requires(const C& c, const Sight<S>& robot) {
  { c(robot) } -> std::same_as<S>;
}
|| requires(const C& c, const std::span<const S>& z) {
  { c(z, z) } -> std::same_as<S>;
};

/// A limit c(x, u) <= 0 of any type; immutable and shared.
class Limit {
 public:
  /// @throws std::invalid_argument from the limit's own check()
  template <class C>
  requires LimitOver<C, double> && LimitOver<C, Symbol> Limit(const C& limit)
      : block_(std::make_shared<const Block<C>>(limit)) {
    if constexpr (Described<C>) check_parameters(limit);
    if constexpr (requires { limit.check(); }) limit.check();
  }

  std::string_view name() const { return block_->name; }
  /// Descriptions of its parameters; empty if the limit does not describe them.
  std::vector<ParameterText> parameters() const { return block_->parameters(); }
  /// Minimum numbers of states and inputs of the robot.
  int states() const { return block_->states; }
  int inputs() const { return block_->inputs; }

  /// c of a robot with this Sight, state x (nx) and input u (nu).
  double operator()(const Sight<double>& robot, std::span<const double> x,
                    std::span<const double> u) const noexcept {
    return block_->value(robot, x, u);
  }
  Symbol operator()(const Sight<Symbol>& robot, std::span<const Symbol> x, std::span<const Symbol> u) const {
    return block_->trace(robot, x, u);
  }

 private:
  struct Interface {
    std::string_view name = "limit";
    int states = 0, inputs = 0;

    virtual ~Interface() = default;
    virtual std::vector<ParameterText> parameters() const = 0;
    virtual double value(const Sight<double>& robot, std::span<const double> x,
                         std::span<const double> u) const noexcept = 0;
    virtual Symbol trace(const Sight<Symbol>& robot, std::span<const Symbol> x,
                         std::span<const Symbol> u) const = 0;
  };

  template <class C>
  struct Block final : Interface {
    C limit;

    explicit Block(const C& c) : limit(c) {
      if constexpr (requires { C::name; }) this->name = C::name;
      if constexpr (requires { limit.states(); }) this->states = limit.states();
      if constexpr (requires { limit.inputs(); }) this->inputs = limit.inputs();
    }
    std::vector<ParameterText> parameters() const override { return parameter_texts(limit); }
    template <class S>
    S at([[maybe_unused]] const Sight<S>& robot, [[maybe_unused]] std::span<const S> x,
         [[maybe_unused]] std::span<const S> u) const {
      if constexpr (requires { limit(robot); }) {
        return limit(robot);
      } else {
        return limit(x, u);
      }
    }
    double value(const Sight<double>& robot, std::span<const double> x,
                 std::span<const double> u) const noexcept override {
      return or_nan([&] { return at<double>(robot, x, u); });
    }
    Symbol trace(const Sight<Symbol>& robot, std::span<const Symbol> x,
                 std::span<const Symbol> u) const override {
      return at<Symbol>(robot, x, u);
    }
  };

  std::shared_ptr<const Interface> block_;
};

/// Cost of a limit: a logarithm inside, a parabola from -c = delta outwards. It is finite and
/// convex in c everywhere, with two continuous derivatives.
///
///   B(c) = -mu ln(-c)                                       for -c >= delta
///   B(c) = mu/2 (((-c - 2 delta) / delta)^2 - 1) - mu ln delta   beyond
struct RelaxedBarrier {
  Limit limit;
  double mu = 0.05;
  double delta = 0.02;

  static constexpr auto parameters() {
    constexpr Bounds of_limit = {above_zero.low, above_zero.high, "> 0, in the unit of the limit"};
    return Parameters{parameter("mu", &RelaxedBarrier::mu, "", above_zero,
                                "weight; the smaller, the nearer one comes to the limit"),
                      parameter("delta", &RelaxedBarrier::delta, "", of_limit,
                                "where the parabola takes over; 2 mu / delta must exceed the force")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const { check_parameters(*this, limit.name()); }

  /// B(c).
  template <class S>
  S of(const S& c) const {
    return -mu * (std::log(delta) + relaxed_log(c * (-1.0 / delta)));
  }

  /// B of a robot, with the arguments of `Limit`.
  template <class S>
  S operator()(const Sight<S>& robot, std::span<const S> x, std::span<const S> u) const {
    return of<S>(limit(robot, x, u));
  }
};

}  // namespace sightline
