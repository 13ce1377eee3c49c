/// Properties of a potential, found by sampling: whether its region is that of its limit, where its
/// gradient vanishes, where its local minima are, and how stiff it is.
///
/// The target is placed in the sensor frame S of an observer at the origin (`moved_to` places it
/// elsewhere), both at rest. A potential without a sensor is sampled in V. Numbers are those of the
/// potential alone, without its weight.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/analysis/field.hpp"

namespace sightline {

struct VerdictOptions {
  double reach = 6.0;    ///< R, radius of the sampled volume around the sensor [m]; increased if the
                         ///< limit is farther
  double flat = 0.03;    ///< a gradient below this counts as zero [1/m], [1/rad]
  int samples = 60'000;  ///< in the volume
};

/// Least and greatest half-angle of a region around the axis of a sensor [rad].
struct HalfAngle {
  double least, greatest;
};

/// A local minimum outside the limit.
struct Trap {
  Vec3<double> p_S;  ///< position of the target in the sensor frame [m]
  double l;
};

/// A wider rounding of the corners, and the greatest second derivative that remains.
struct Cure {
  double smooth;
  double curvature;  ///< [1/m^2]
};

/// Above this second derivative [1/m^2] commands may alternate: the solver's steps are too long for
/// it.
inline constexpr double stiff = 1e4;

struct Verdict {
  std::string name;
  VerdictOptions options;
  bool has_view = false;      ///< the potential has a sensor
  bool sees_heading = false;  ///< the potential depends on the observer's heading
  std::optional<Vec3<double>>
      around{};  ///< observer's start [m], if the potential depends on the places in G

  double outside = 0.0;  ///< fraction of the volume that breaks the limit

  // Does the region agree with the inequalities?
  double step_disagrees = 0.0;     ///< fraction of the volume where the unit step and the limit disagree
  double sigmoid_disagrees = 0.0;  ///< fraction where (l > level) and the limit disagree
  double level = 0.0;              ///< median of l at the limit
  double bias = 0.0;               ///< median distance beyond the limit at which l has half of its step [m]
  double bias_worst = 0.0;         ///< the bias of the greatest magnitude, at most 1 m [m]
  double bias_angle = 0.0;         ///< median angle of the bias, seen from the sensor [rad]
  std::optional<HalfAngle> of_step, of_limit;  ///< cones of the unit step and of the limit

  // Where does the gradient vanish? Fractions of the volume that breaks the limit.
  double flat_in_position = 0.0;
  double flat_in_yaw = 0.0;                ///< 0 if it does not depend on the heading
  double flat_in_both = 0.0;               ///< no gradient in position and none in yaw
  double flat_in_yaw_behind = 0.0;         ///< fraction of the volume behind the sensor, x_S < 0
  double turns_away = 0.0;                 ///< fraction where it turns the target out of view
  std::optional<double> flat_beyond;       ///< the gradient vanishes from this distance on [m]
  std::optional<double> flat_within;       ///< the gradient vanishes up to this distance [m]
  std::optional<double> flat_in_yaw_from;  ///< the yaw gradient vanishes from this angle off the
                                           ///< axis on [rad]

  // Where are its local minima?
  std::vector<Trap> traps;    ///< minima by the position, outside the limit
  double traps_in_yaw = 0.0;  ///< fraction of the viewable places from which turning can end out of view

  // How stiff is it?
  double condition = 0.0;         ///< median condition number of the Hessian by the position, at the limit
  double condition_worst = 0.0;   ///< greatest
  double curvature_worst = 0.0;   ///< greatest magnitude of a second derivative [1/m^2]
  double curvature_in_yaw = 0.0;  ///< the same by the heading [1/rad^2]
  std::optional<Cure> cure{};     ///< of a Region whose second derivative exceeds `stiff`

  std::vector<std::string> words;     ///< the whole verdict, a sentence each
  std::vector<std::string> warnings;  ///< what to consider before a flight, a sentence each
};

/// Judges a potential. Set-up: allocates, takes some ten milliseconds; several times that for a
/// stiff Region.
Verdict judge(const Potential& potential, const VerdictOptions& options = {});

/// The verdict as a JSON object; missing values are null.
std::string to_json(const Verdict& verdict);

}  // namespace sightline
