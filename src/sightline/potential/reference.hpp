/// What a robot is asked to do over time: a state, or a pose at rest, that moves over the horizon.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <functional>
#include <numbers>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/model/model.hpp"

namespace sightline {

/// A circle at constant height: p = centre + radius (cos(rate t), sin(rate t), 0), (70); the heading is free.
struct Circle {
  static constexpr std::string_view name = "circle";
  Vec3<double> centre{};  ///< [m]
  double radius = 0.5;    ///< [m], >= 0
  double rate = 0.3;      ///< [rad/s]

  Pose<double> operator()(double t) const;
};

/// Straight lines between poses at given times; held before the first and after the last.
struct Waypoints {
  static constexpr std::string_view name = "waypoints";
  std::vector<double> times;    ///< [s], rising
  std::vector<Vec3<double>> p;  ///< [m], one for each time
  std::vector<double> heading =
      {};  ///< [rad], one for each time, or none: free; between two, the shorter way round

  /// @throws std::invalid_argument unless the times rise and all lists are as long
  void check() const;
  Pose<double> operator()(double t) const;
};

/// Poses that change at given times and hold until the next.
struct Steps {
  static constexpr std::string_view name = "steps";
  std::vector<double> times;         ///< [s], rising; the first pose also holds before
  std::vector<Vec3<double>> p;       ///< [m], one for each time
  std::vector<double> heading = {};  ///< [rad], one for each time, or none: free

  /// @throws std::invalid_argument unless the times rise and all lists are as long
  void check() const;
  Pose<double> operator()(double t) const;
};

/// A reference x*(t) of any form. A pose stands for the robot at rest there; a heading of (0, 0) is no
/// heading.
class Reference {
 public:
  /// The origin at rest, without a heading.
  Reference() : Reference([](double) { return Pose<double>{}; }) {}

  /// t -> Pose<double>.
  /// @throws std::invalid_argument from the trajectory's own check()
  template <std::invocable<double> F>
  requires std::same_as<std::invoke_result_t<F, double>, Pose<double>> Reference(F pose)
      : write_(
            [pose](double t, const Model& model, std::span<double> x) { model.at_rest(pose(t), x.data()); }) {
    if constexpr (requires { pose.check(); }) pose.check();
  }

  /// t -> std::array<double, nx>, or another range of always the same length: the whole state.
  template <std::invocable<double> F>
  requires std::convertible_to<std::invoke_result_t<F, double>, std::span<const double>> Reference(F state)
      : write_([state](double t, const Model&, std::span<double> x) {
          const auto& value = state(t);
          std::copy_n(value.begin(), x.size(), x.begin());
        }),
        length_(std::size(state(0.0))) {}

  /// A constant state of length nx.
  template <std::size_t n>
  Reference(const std::array<double, n>& state)
      : Reference(std::vector<double>(state.begin(), state.end())) {}
  Reference(const std::vector<double>& state) : Reference([state](double) -> const auto& { return state; }) {}

  /// x*(t) into x, of length nx. Allocates nothing if the function it was made from does not.
  void operator()(double t, const Model& model, std::span<double> x) const { write_(t, model, x); }

  /// Numbers in the state it gives; 0 for a pose, which suits any robot.
  std::size_t length() const { return length_; }

 private:
  std::function<void(double, const Model&, std::span<double>)> write_;
  std::size_t length_ = 0;
};

}  // namespace sightline
