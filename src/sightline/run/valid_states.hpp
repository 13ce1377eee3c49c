/// States that everything behind a measurement can compute with.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "sightline/base/index.hpp"
#include "sightline/ocp/team.hpp"

namespace sightline {

/// States of all bodies (nx), each with the time of its measurement. At any time all are numbers of at most `largest`, and a
/// heading has a length: take() is the only way in, and leaves a body that is measured otherwise as it was.
class ValidStates {
 public:
  /// Beyond, no quantity in SI units is that of a robot, and its square may overflow.
  static constexpr double largest = 1e9;

  /// @param start  states of all bodies (nx) until the first valid measurement; of a body where it is not valid itself, at rest
  ///               in the origin
  ValidStates(const Team& team, std::span<const double> start);

  /// States x (nx) and times [s] of a measurement. The time of a body that is not valid stays that of its last valid one, minus
  /// infinity before there was one.
  const ValidStates& take(std::span<const double> x, std::span<const double> stamps) noexcept;

  /// States x (nx) that follow from `of`, such as those at a later time: a body is valid where it is in both.
  const ValidStates& take(std::span<const double> x, const ValidStates& of) noexcept;

  operator std::span<const double>() const noexcept { return x_; }
  std::size_t size() const noexcept { return x_.size(); }
  double operator[](std::size_t i) const noexcept { return x_[i]; }
  std::span<const double> stamps() const noexcept { return stamps_; }
  /// Whether the last take() had valid states of the body.
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
