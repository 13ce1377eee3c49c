/// Fallback levels of a robot, chosen by the age and the uncertainty of its data. The worst reason
/// decides.
///
///   level      greatest age of data    applied command
///   valid      fresh                   the plan
///   predicted  slow_after              the plan, from a state predicted to the present
///   slowed     hold_after              the plan, scaled
///   hold       land_after              zero velocity, by the predicted state
///   land       older                   steady descent without horizontal velocity, to the ground
///   grounded   -                       zero velocity
///
/// For an estimated position its standard deviation decides as well. Within sigma_hold it counts as
/// a measured one, within sigma_land the robot holds, beyond it lands.
///
/// Transitions: between valid, predicted, slowed and hold, in each direction, by the ages. From
/// each of the four to land. From land to grounded, when the robot is on the ground. From grounded
/// there is none. A robot that has begun to land continues to land, also when its data return.
#pragma once

#include <cstdint>
#include <string_view>

namespace sightline {

enum class FallbackLevel : std::uint8_t { valid, predicted, slowed, hold, land, grounded };
inline constexpr int fallback_level_count = 6;
std::string_view to_string(FallbackLevel level);

/// Greatest age of a robot's data at each level [s].
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

/// Ages of the data that a robot uses [s]; infinity: no data so far.
struct Ages {
  double own = 0.0;       ///< the last good measurement of the robot itself
  double partners = 0.0;  ///< the oldest measurement of the bodies whose couplings act on it
  double plan = 0.0;      ///< the last good plan
};

/// The level for data of this age [s].
FallbackLevel level_at(const LadderTimes& times, double age) noexcept;
/// The level for an estimate with this standard deviation [m]: valid, hold or land. For infinity
/// (no estimate) it is hold, and the age decides further.
FallbackLevel level_at(const LadderSigmas& sigmas, double sigma) noexcept;

/// The next level. Old data of partners make a robot hold and never land, since its own position is
/// still known.
/// @param by_sigma  best level that the standard deviations of estimates allow
FallbackLevel next_level(FallbackLevel now, const LadderTimes& times, const Ages& ages, bool on_ground,
                         FallbackLevel by_sigma = FallbackLevel::valid) noexcept;

}  // namespace sightline
