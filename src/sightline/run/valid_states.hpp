/// Measured states that are always finite and bounded.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "sightline/base/index.hpp"
#include "sightline/ocp/team.hpp"

namespace sightline {

/// States of all bodies (nx), each with the time of its measurement. All numbers are at most
/// `largest`, and headings have a length. Only take() changes them; it leaves a body with an
/// invalid measurement unchanged.
class ValidStates {
 public:
  /// A greater value is no physical quantity of a robot in SI units, and its square may overflow.
  static constexpr double largest = 1e9;

  /// @param start  states of all bodies (nx) until the first valid measurement; an invalid one is
  ///               replaced by rest at the origin
  ValidStates(const Team& team, std::span<const double> start);

  /// Takes states x (nx) and times [s] of a measurement. An invalid body keeps the time of its last
  /// valid measurement, minus infinity before the first.
  const ValidStates& take(std::span<const double> x, std::span<const double> stamps) noexcept;

  /// Takes states x (nx) that follow from `of`, such as predicted ones. A body is valid if it is
  /// valid in both.
  const ValidStates& take(std::span<const double> x, const ValidStates& of) noexcept;

  operator std::span<const double>() const noexcept { return x_; }
  std::size_t size() const noexcept { return x_.size(); }
  double operator[](std::size_t i) const noexcept { return x_[i]; }
  std::span<const double> stamps() const noexcept { return stamps_; }
  /// Whether the last take() had a valid state of the body.
  bool is_valid(BodyId body) const noexcept { return valid_[at(body)] != 0; }

 private:
  struct Body {
    Model model;
    std::size_t x, nx;  // offset and length
  };
  bool admits(const Body& body, std::span<const double> x) noexcept;
  void take_body(std::size_t i, std::span<const double> x, double stamp, bool can_be_valid) noexcept;

  std::vector<Body> bodies_;
  std::vector<double> x_, stamps_, scratch_;
  std::vector<char> valid_;  // of each body
};

}  // namespace sightline
