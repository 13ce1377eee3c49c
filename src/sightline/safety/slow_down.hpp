/// A robot that slows down on request, so that another one keeps it in view: a filter of its command.
///
/// Its horizontal speed stays within `unrequested`. From the arrival of a request on it falls by
/// `slowing` per time, until it is within `speed`. Its vertical command is always within `climb`.
/// Units are SI.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sightline/model.hpp"
#include "sightline/safety/view_certificate.hpp"
#include "sightline/safety/view_filter.hpp"

namespace sightline {

struct SlowDownOptions {
  double speed = 0.5;        ///< after a request [m/s], > 0
  double unrequested = 1.0;  ///< without one [m/s], >= speed
  double climb = 0.3;        ///< vertical, always [m/s]
  double slowing = 1.0;      ///< deceleration that a request causes [m/s^2], > 0
  double delay = 0.0;        ///< from a request to its arrival, rounded up to periods [s]
  double period = 0.01;      ///< [s]
};

/// The deceleration of which a robot is capable at every velocity [m/s^2]; <= 0: none.
/// @param wind  greatest acceleration by wind [m/s^2]
double least_deceleration(const ViewMotion& motion, double wind) noexcept;

/// By how much a robot that is requested in the first period in which it gained on a point of `speed`
/// gains on it at most, if positions are known after `age` [m].
double gain_until_slow(const SlowDownOptions& options, double age) noexcept;

class SlowDown {
 public:
  /// @param u_min, u_max  tightest limits of the inputs (nu)
  /// @throws std::invalid_argument as view_motion(), and beyond the sizes of a ViewFilter
  SlowDown(const Model& model, std::span<const double> u_min, std::span<const double> u_max,
           const SlowDownOptions& options);

  /// To be called in each period. Among the commands on the line from u to full braking it takes the
  /// nearest that keeps the bounds. Allocates nothing.
  /// @param requested  now
  /// @param x  state (nx)
  /// @param u  command (nu), within the limits; so it stays
  void filter(bool requested, std::span<const double> x, std::span<double> u) noexcept;
  /// Whether a command keeps the bounds from the last state on.
  bool keeps(std::span<const double> u) const noexcept;

 private:
  double speed_after(std::span<const double> u) const noexcept;

  Model model_;
  ViewMotion motion_;
  SlowDownOptions options_;
  std::vector<double> under_way_;  // requests, 1 or 0; the oldest is at next_
  std::size_t next_ = 0;
  std::vector<double> x_;
  double bound_ = infinity;  // of the speed at the next sample [m/s]
};

}  // namespace sightline
