/// Action `wind = { acceleration = [0.3, 0.0, 0.0] }`: another steady wind.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "sightline/ocp/event/team_change.hpp"

namespace sightline {

/// Another steady wind, which rises over the ramp; for a simulated world.
struct SetWind {
  static constexpr std::string_view key = "wind", expected = "a table with acceleration";
  static constexpr bool changes_surroundings = true;
  static constexpr double usual_ramp = 1.0;

  Vec3<double> acceleration;  ///< in G [m/s^2]

  std::string apply(const TeamChange& change) const {
    change.now.around.wind = Surroundings::Wind{acceleration, change.t, change.ramp};
    return {};
  }
  std::string subject(const Team& /*all*/) const { return "the wind"; }
  std::string describe(const Team& /*all*/) const {
    return fmt::format("wind {:.4g}, {:.4g}, {:.4g}", acceleration.x, acceleration.y, acceleration.z);
  }

  template <class Text>
  static SetWind read(const Text& wind, std::string_view /*kind*/) {
    wind.expect_only({"acceleration"});
    return {wind.vec3("acceleration")};
  }
};

}  // namespace sightline
