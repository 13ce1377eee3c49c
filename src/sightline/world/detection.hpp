/// What a camera says of another body.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "sightline/base/fixed.hpp"
#include "sightline/base/index.hpp"
#include "sightline/base/matrix.hpp"
#include "sightline/ocp/active_team.hpp"
#include "sightline/world/rigid_body.hpp"

namespace sightline {

/// A body seen by an observer's camera: its pose in the camera's frame S (x along the optical axis, y to the left, z up), and how well it
/// is known.
///
/// With the errors dp and dtheta of that covariance, the body's origin is at p + dp in S, and its axes are turned by exp(dtheta) after q,
/// dtheta in S as well. S is where [agent.NAME.sensor] says that it is: an error of the mounting is in p and q, and not in the covariance.
struct Detection {
  BodyId observer{}, target{};
  double stamp = 0.0;          ///< when it was so: the middle of the exposure [s]
  double arrival = 0.0;        ///< when the observer has it, not before the stamp [s]
  Vec3<double> p{};            ///< of the target's origin in S [m]
  Quaternion q = no_attitude;  ///< the target's axes in S; no_attitude where the position alone is known
  std::array<double, 21>
      covariance{};  ///< of (dp, dtheta), upper triangle row by row [m^2], [m rad], [rad^2]
  int tags = 0;      ///< that it was seen by

  bool is_oriented() const noexcept { return q != no_attitude; }
  void forget_attitude() noexcept {
    q = no_attitude;
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = std::max<std::size_t>(i, 3); j < 6; ++j) covariance[place(i, j)] = 0.0;
  }
  /// The place of row i and column j, of 6, in the covariance.
  static constexpr std::size_t place(std::size_t i, std::size_t j) noexcept {
    const std::size_t row = i < j ? i : j, column = i < j ? j : i;
    return row * (11 - row) / 2 + column;
  }
  /// The covariance with both triangles.
  Mat<6, 6> covariance_matrix() const noexcept {
    Mat<6, 6> all;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) all(i, j) = covariance[place(at(i), at(j))];
    return all;
  }
  void set_covariance(const Mat<6, 6>& all) noexcept {
    for (int i = 0; i < 6; ++i)
      for (int j = i; j < 6; ++j) covariance[place(at(i), at(j))] = all(i, j);
  }
};

}  // namespace sightline
