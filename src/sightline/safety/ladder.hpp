/// Fallback levels of a robot: what it does when its data grow old, or uncertain. The worst reason decides.
///
///   level      age of its data         what is applied
///   valid      fresh                   the plan
///   predicted  slow_after              the plan, from a state predicted to the present
///   slowed     hold_after              the plan, scaled
///   hold       land_after              zero velocity, by the predicted state
///   land       older                   down at a steady speed without horizontal velocity; the end is the ground
///   grounded   -                       no command
///
/// Of a position that is estimated its standard deviation decides as well: within sigma_hold it is as good as a measured
/// one, within sigma_land the robot holds, beyond it lands.
///
/// Transitions. Between valid, predicted, slowed and hold there is a transition in each direction, chosen by the ages:
/// down as data grow old, up as they return. From each of the four there is one to land. From land there is one, to
/// grounded, when the robot is on the ground; from grounded there is none. A robot that has begun to land goes
/// on landing, also when its data return.
#pragma once

#include <cstdint>
#include <string_view>

namespace sightline {

enum class FallbackLevel : std::uint8_t { valid, predicted, slowed, hold, land, grounded };
inline constexpr int fallback_level_count = 6;
std::string_view to_string(FallbackLevel level);

/// Greatest age of a robot's data on each level [s].
struct LadderTimes {
  double fresh = 0.02;      ///< younger data count as present, > 0
  double slow_after = 0.2;  ///< >= fresh
  double hold_after = 0.5;  ///< >= slow_after
  double land_after = 2.0;  ///< >= hold_after
};

/// Greatest standard deviation of an estimated position [m], the root of the sum over its axes.
struct LadderSigmas {
  double hold = 1.0;  ///< beyond, the robot holds, > 0
  double land = 2.0;  ///< beyond, it lands, > hold
};

/// Ages of the data that a robot uses [s]; infinity: there never were any.
struct Ages {
  double own = 0.0;       ///< the last good measurement of the robot itself
  double partners = 0.0;  ///< the oldest of those of the bodies that it feels a coupling with
  double plan = 0.0;      ///< the last good plan
};

/// The level that data of one age allow.
FallbackLevel level_at(const LadderTimes& times, double age) noexcept;
/// The level that an estimate of this deviation allows: valid, hold or land. Of infinity, an estimate that there is not, hold:
/// its age decides further.
FallbackLevel level_at(const LadderSigmas& sigmas, double sigma) noexcept;

/// The next level. Old data of partners make a robot hold and never land: its own position is still
/// known.
/// @param by_sigma  the least that the deviations of estimates allow
FallbackLevel next_level(FallbackLevel now, const LadderTimes& times, const Ages& ages, bool on_ground,
                         FallbackLevel by_sigma = FallbackLevel::valid) noexcept;

}  // namespace sightline
