/// Properties of a potential, found by sampling: is its region the one its limit states, where does it
/// have no gradient, where are its local minima, how stiff is it.
///
/// The target is placed in the sensor frame S of an observer at the origin (`moved_to` puts it elsewhere), both at rest; a
/// potential without a sensor is sampled in V. Numbers are those of the potential by itself, without its weight.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/analysis/field.hpp"

namespace sightline {

struct VerdictOptions {
  double reach = 6.0;  ///< R: how far around the sensor is looked at [m]; further for a limit that is further
  double flat = 0.03;  ///< a gradient below this counts as zero [1/m], [1/rad]
  int samples = 60'000;  ///< of the volume
};

/// Least and greatest half-angle of a region round the axis of a sensor [rad].
struct HalfAngle {
  double least, greatest;
};

/// A local minimum outside the limit.
struct Trap {
  Vec3<double> p_S;  ///< the target in the sensor frame
  double l;
};

/// A rounder corner, and the greatest second derivative that is left.
struct Cure {
  double smooth;
  double curvature;  ///< [1/m^2]
};

/// A second derivative beyond this is more than a solver takes in its steps: commands may alternate [1/m^2].
inline constexpr double stiff = 1e4;

struct Verdict {
  std::string name;
  VerdictOptions options;
  bool has_view = false;      ///< it has a sensor
  bool sees_heading = false;  ///< it depends on the observer's heading
  std::optional<Vec3<double>>
      around{};  ///< it depends on where in G the two are: the observer stood there [m]

  double outside = 0.0;  ///< share of the volume that breaks the limit

  // Is the region what the inequalities say?
  double step_disagrees = 0.0;     ///< share of the volume where the unit step and the limit disagree
  double sigmoid_disagrees = 0.0;  ///< where l above its value at the limit and the limit do
  double level = 0.0;              ///< l at the limit, the median
  double bias = 0.0;        ///< distance beyond the limit at which l has half of its step, the median [m]
  double bias_worst = 0.0;  ///< of the greatest size, at most 1 m [m]
  double bias_angle = 0.0;  ///< the median, seen from the sensor [rad]
  std::optional<HalfAngle> of_step, of_limit;  ///< the cones of the unit step and of the limit

  // Where does the gradient vanish? Shares of the volume that breaks the limit.
  double flat_in_position = 0.0;
  double flat_in_yaw = 0.0;                ///< 0 if it does not see the heading
  double flat_in_both = 0.0;               ///< no gradient in position and none in yaw
  double flat_in_yaw_behind = 0.0;         ///< of what lies behind the sensor, x_S < 0
  double turns_away = 0.0;                 ///< where it turns the target out of view, not into it
  std::optional<double> flat_beyond;       ///< from this distance on nothing pulls [m]
  std::optional<double> flat_within;       ///< up to this distance nothing pushes [m]
  std::optional<double> flat_in_yaw_from;  ///< from this angle off the axis on nothing turns it [rad]

  // Where does it come to rest?
  std::vector<Trap> traps;    ///< minima by the position, outside the limit
  double traps_in_yaw = 0.0;  ///< share of places from where the target can be turned into view and is not

  // How stiff is it?
  double condition = 0.0;         ///< of the Hessian by the position at the limit, the median
  double condition_worst = 0.0;   ///< greatest
  double curvature_worst = 0.0;   ///< greatest second derivative in size [1/m^2]
  double curvature_in_yaw = 0.0;  ///< [1/rad^2]
  std::optional<Cure> cure{};     ///< of a Region whose second derivative exceeds `stiff`

  std::vector<std::string> words;     ///< all of it, a sentence each
  std::vector<std::string> warnings;  ///< what to know before a flight, a sentence each
};

/// Set-up: allocates, takes some ten milliseconds; of a stiff Region a few times that.
Verdict judge(const Potential& potential, const VerdictOptions& options = {});

/// The verdict as an object of JSON; what there is none of is null.
std::string to_json(const Verdict& verdict);

}  // namespace sightline
