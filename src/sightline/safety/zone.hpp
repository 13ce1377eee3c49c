/// The place of a robot in a Zone, and the convex pieces of space that a zone forbids.
///
/// The forbidden space of a prism kept outside is the prism. That of a prism kept inside is the
/// rest of space: half-spaces beyond the hull of the polygon, above and below, and the pockets
/// between polygon and hull. A convex piece is kept away from by any one of its faces.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "sightline/barrier.hpp"
#include "sightline/base.hpp"

namespace sightline {

/// An upright face; n . p - offset is the distance beyond it [m].
struct Face {
  Vec2<double> n;  ///< unit vector, out of the piece
  double offset;   ///< [m]
};

/// The points p with n . p < offset for all faces, and low < p_z < high.
struct ForbiddenPiece {
  std::vector<Face> faces;
  double low = -infinity, high = infinity;  ///< [m]
};

/// The word of a scenario for the side of a prism that robots keep.
constexpr std::string_view to_string(Zone::Keep keep) noexcept {
  return Zone::sides[static_cast<std::size_t>(keep)];
}

/// Distance to the zone's boundary [m], negative on the wrong side.
double zone_reserve(const Zone& zone, const Vec3<double>& p) noexcept;

/// The zones for a robot that lands or is on the ground: rooms without their floors.
std::vector<Zone> zones_to_land(std::vector<Zone> zones);

/// Pieces that cover the forbidden space. At a corner of less than 90 degrees a piece has another
/// face, which touches it there alone. A margin then moves the corner by at most sqrt(2) times the
/// margin.
std::vector<ForbiddenPiece> forbidden_pieces(const Zone& zone);

/// @throws std::invalid_argument if the polygon is not simple, or the heights leave no room
void validate(const Zone& zone);

}  // namespace sightline
