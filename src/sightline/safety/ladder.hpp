/// What a robot does when its data grow old: a ladder of rungs, the worst reason decides.
///
///   rung       its data are at most    what is applied
///   valid      fresh                   the plan
///   predicted  slow_after              the plan, from a state predicted to now
///   slowed     hold_after              the plan, scaled
///   hold       land_after              zero velocity, on the predicted state
///   land       older                   down at a steady speed without horizontal velocity; the end is the ground
///   grounded   -                       nothing any more
///
/// Edges. Each of valid, predicted, slowed and hold goes to each other one of them, whichever the ages ask for:
/// down as data grow old, up as they return. Each of the four goes to land. From land there is one edge, to
/// grounded, when the robot is on the ground; from grounded there is none. A robot that was blind for so long
/// that it lands, lands.
#pragma once

#include <cstdint>
#include <string_view>

namespace sightline {

enum class Rung : std::uint8_t { valid, predicted, slowed, hold, land, grounded };
inline constexpr int rung_count = 6;
std::string_view to_string(Rung rung);

/// Up to which age of its data a robot stays on a rung [s].
struct LadderTimes {
  double fresh = 0.02;      ///< younger data count as present, > 0
  double slow_after = 0.2;  ///< >= fresh
  double hold_after = 0.5;  ///< >= slow_after
  double land_after = 2.0;  ///< >= hold_after
};

/// How old what a robot flies by is [s]; infinity: there never was any.
struct Ages {
  double own = 0.0;       ///< the last good measurement of the robot itself
  double partners = 0.0;  ///< the oldest of those of the bodies that it feels a coupling with
  double plan = 0.0;      ///< the last good plan
};

/// The rung that data of one age allow.
Rung rung_at(const LadderTimes& times, double age) noexcept;

/// The rung after this one. What is too old of partners makes a robot hold, never land: it still knows where
/// it is itself.
Rung next_rung(Rung now, const LadderTimes& times, const Ages& ages, bool on_ground) noexcept;

}  // namespace sightline
