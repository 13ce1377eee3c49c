/// At which distance a robot with a camera knows its place best by the tags of another body, and where it loses them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/analysis/explain.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/world/view_flight.hpp"

namespace sightline {

struct ViewAtDistance {
  double distance = 0.0;  ///< of the two bodies [m]
  ViewFigures figures{};  ///< of fly_beside(), means of several flights
};

/// A camera, and tags that it looks for.
struct ViewBand {
  BodyId observer{}, target{};
  double speed = 0.0;  ///< greatest of the target's reference or motion [m/s]
  std::optional<std::size_t>
      same_as{};                       ///< an earlier one with equal camera, tags and speed: the same figures
  std::vector<ViewAtDistance> rows{};  ///< rising, to where next to nothing is seen
  /// Where no view is lost, not `band_sway` nearer either, and the error is at most `band_error` times the least there.
  std::optional<DistanceBand> serves{};
};

inline constexpr double band_step = 0.25, band_sway = 0.15;  ///< [m]
inline constexpr double band_error = 1.5;
/// Losses of the view that count as none [1/min].
inline constexpr double band_losses = 0.1;

/// Of each robot with a camera and each body with tags that a potential of view couples it with, at first or by an event.
/// @param flights  at each distance, >= 1
std::vector<ViewBand> view_bands(const Scenario& scenario, int flights = 3);

/// A table of one camera and its tags.
std::string to_string(const ViewBand& band, const Team& team);

/// What cannot be known at the start of robots that know their places by whom they see: those that are localized by vision, and
/// those that turn by a choice (`best`).
std::vector<std::string> unobservable_robots(const Scenario& scenario);

}  // namespace sightline
