/// Distances at which a robot with a camera localizes best by another body's tags, and at which it
/// loses them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/analysis.hpp"
#include "sightline/scenario.hpp"
#include "sightline/world/view_flight.hpp"

namespace sightline {

struct ViewAtDistance {
  double distance = 0.0;  ///< of the two bodies [m]
  ViewFigures figures{};  ///< of fly_beside(), means of several flights
};

/// A camera and the tags that it observes.
struct ViewBand {
  BodyId observer{}, target{};
  std::string camera{};  ///< "uav0", or "uav0 left" with the name of its sensor
  double speed = 0.0;    ///< greatest speed of the target's reference or motion [m/s]
  std::optional<std::size_t>
      same_as{};  ///< index of an earlier band with equal camera, tags and speed, hence equal figures
  std::vector<ViewAtDistance> rows{};  ///< ascending, up to the distance where almost nothing is detected
  /// Distances [m] without loss of the view, also `band_sway` nearer, where the error is at most
  /// `band_error` times the least such error.
  std::optional<DistanceBand> serves{};
};

inline constexpr double band_step = 0.25, band_sway = 0.15;  ///< [m]
inline constexpr double band_error = 1.5;
/// Losses of the view [1/min] up to this rate count as none.
inline constexpr double band_losses = 0.1;

/// For each robot with a camera and each body with tags that a potential of view couples, at first
/// or by an event.
/// @param flights  number at each distance, >= 1
std::vector<ViewBand> view_bands(const Scenario& scenario, int flights = 3);

/// A table for one camera and its tags.
std::string to_string(const ViewBand& band, const Team& team);

/// A sentence for each state that is not observable at the start. Covers robots that are localized
/// by vision and observers that choose their target (`best`).
std::vector<std::string> unobservable_robots(const Scenario& scenario);

}  // namespace sightline
