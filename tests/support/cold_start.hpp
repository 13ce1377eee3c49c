/// Starts that a solver knows nothing of: the paper's pair anywhere, looking anywhere.
#pragma once

#include <algorithm>

#include "sightline/potential/bounds.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random_team.hpp"

namespace sightline {

enum class Reach {
  near,  ///< poses within 6 m
  far,   ///< 10 to 40 m from the reference
};

/// The paper's pair; with all built-in potentials, each robot has a band and a fence too.
inline Team cold_team(paper::Variant variant, bool all_potentials) {
  Team team = paper::team(variant);
  if (!all_potentials) return team;
  for (const AgentId agent : {paper::uav0, paper::uav1}) {
    team.constrain(0.5 * AltitudeBand{.z_min = 0.2, .z_max = 2.5}, agent);
    team.constrain(0.5 * Geofence{{-3, -3, 0}, {3, 3, 3}}, agent);
  }
  return team;
}

/// States of the two: anywhere, and in turn with the target behind, looking away from each other, in one place,
/// or so far apart that limits are active.
inline std::vector<double> cold_start(Random& random, const Team& team, Reach reach, int trial) {
  std::vector<double> x = random_states(random, team, 6.0);
  const std::span<double> a = std::span(x).first(7), b = std::span(x).last(7);
  if (reach == Reach::far) {
    for (const std::span<double> robot : {a, b}) {
      Vec3<double> direction = random_point(random, 1.0);
      direction = (uniform(random, 10.0, 40.0) / norm(direction)) * direction;
      robot[0] = direction.x, robot[1] = direction.y, robot[2] = direction.z + 1.0;
    }
  }
  const double behind = uniform(random, 0.5, 6.0);
  switch (trial % 5) {
    case 0:
      break;
    case 1:  // the target straight behind
      for (std::size_t i = 0; i < 3; ++i) b[i] = a[i];
      for (std::size_t i = 0; i < 2; ++i) b[i] -= behind * a[3 + i];
      break;
    case 2:  // opposing headings
      b[3] = -a[3], b[4] = -a[4];
      break;
    case 3:  // one place
      std::copy_n(a.begin(), 3, b.begin());
      break;
    default:  // saturating
      for (std::size_t i = 0; i < 3; ++i) a[i] = a[i] < 0 ? a[i] - 3.0 : a[i] + 3.0;
  }
  return x;
}

}  // namespace sightline
