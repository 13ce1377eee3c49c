/// Reference of a robot over time: a state, or a pose at rest.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <functional>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "sightline/base/or_nan.hpp"
#include "sightline/model/model.hpp"
#include "sightline/potential/ramp.hpp"

namespace sightline {

/// A constant pose.
struct Constant {
  static constexpr std::string_view name = "constant";
  Vec3<double> p{};
  std::optional<double> heading{};

  static constexpr auto parameters() {
    return std::tuple{needed(parameter("p", &Constant::p, "m", any_finite, "position")),
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
    return std::tuple{
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
constexpr auto timed_parameters() {
  return std::tuple{
      ListParameter<R, double>{"times", &R::times, "s", "when; the first pose also holds before", true},
      ListParameter<R, Vec3<double>>{"p", &R::p, "m", "where, for each time"},
      ListParameter<R, double>{"heading", &R::heading, "rad", "for each time; left out: free", false, false}};
}

}  // namespace detail

/// Straight lines between poses at given times; the heading takes the shorter direction. Held
/// before the first and after the last time.
struct Waypoints {
  static constexpr std::string_view name = "waypoints";
  std::vector<double> times;
  std::vector<Vec3<double>> p;
  std::vector<double> heading = {};

  static constexpr auto parameters() { return detail::timed_parameters<Waypoints>(); }
  /// @throws std::invalid_argument unless the times increase, all lists have equal length and all
  /// numbers are finite
  void check() const;
  Pose<double> operator()(double t) const;
};

/// Poses that change at given times and hold until the next.
struct Steps {
  static constexpr std::string_view name = "steps";
  std::vector<double> times;
  std::vector<Vec3<double>> p;
  std::vector<double> heading = {};

  static constexpr auto parameters() { return detail::timed_parameters<Steps>(); }
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

}  // namespace sightline
