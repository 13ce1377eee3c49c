/// Common limits of one robot, for a RelaxedBarrier. Each is scaled so that c is -1 farthest from
/// its borders.
#pragma once

#include <algorithm>

#include "sightline/potential/relaxed_barrier.hpp"

namespace sightline {

/// Keeps the horizontal speed v of a robot in G between two bounds, min^2 <= v^2 = v_x^2 + v_y^2 <=
/// max^2.
///
///   c = v^2 / max^2 - 1                                     min = 0
///   c = ((2 v^2 - max^2 - min^2) / (max^2 - min^2))^2 - 1   min > 0, for fixed-wing aircraft
///
/// For a multirotor v^2 is v_f^2 + v_s^2.
struct SpeedLimit {
  double max = 1.0;
  double min = 0.0;

  static constexpr std::string_view name = "speed";
  static constexpr auto parameters() {
    return std::tuple{parameter("max", &SpeedLimit::max, "m/s", above_zero, "greatest horizontal speed"),
                      parameter("min", &SpeedLimit::min, "m/s", from_zero, "least, below max")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    check_parameters(*this);
    require(min < max, name, "min", min, "below max");
  }

  template <class S>
  S operator()(const Sight<S>& robot) const {
    const S v2 = square(robot.v.x) + square(robot.v.y);
    if (min == 0) return v2 * (1.0 / square(max)) - 1.0;
    const double low = square(min), high = square(max);
    return square((2.0 * v2 - (high + low)) * (1.0 / (high - low))) - 1.0;
  }
};

/// Keeps two inputs of a robot within a disc, for example u_f and u_s of a multirotor, which set
/// its tilt.
///
///   c = (u_i^2 + u_j^2) / radius^2 - 1
struct InputDisc {
  double radius = 1.0;
  int i = 0, j = 1;

  static constexpr std::string_view name = "input_disc";
  static constexpr auto parameters() {
    constexpr Bounds place = {0.0, 1000.0, "0 to 1000"};
    return std::tuple{parameter("radius", &InputDisc::radius, "", above_zero, "in the unit of the inputs"),
                      parameter("i", &InputDisc::i, "", place, "the one input, from 0; of a multirotor u_f"),
                      parameter("j", &InputDisc::j, "", place, "the other; of a multirotor u_s")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    check_parameters(*this);
    require(j != i, name, "j", j, "another input than i");
  }

  int inputs() const { return std::max(i, j) + 1; }

  template <class S>
  S operator()(std::span<const S> /*x*/, std::span<const S> u) const {
    const S &a = u[static_cast<std::size_t>(i)], &b = u[static_cast<std::size_t>(j)];
    return (a * a + b * b) * (1.0 / square(radius)) - 1.0;
  }
};

}  // namespace sightline
