/// Detection of a body by a camera.
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

/// Pose of a detected body in the observer's camera frame S (x along the optical axis, y left, z
/// up), with covariance.
///
/// With the errors dp and dtheta of that covariance, the body's origin is at p + dp in S. Its axes
/// are turned by exp(dtheta) after q, with dtheta in S. The key [agent.NAME.sensor] defines S; a
/// mounting error enters p and q, but not the covariance.
struct Detection {
  BodyId observer{}, target{};
  double stamp = 0.0;          ///< time of validity: the middle of the exposure [s]
  double arrival = 0.0;        ///< time at which the observer receives it, not before the stamp [s]
  Vec3<double> p{};            ///< target's origin in S [m]
  Quaternion q = no_attitude;  ///< target's axes in S; no_attitude if only the position is known
  std::array<double, 21>
      covariance{};  ///< of (dp, dtheta), upper triangle row by row [m^2], [m rad], [rad^2]
  int tags = 0;      ///< number of tags used

  bool is_oriented() const noexcept { return q != no_attitude; }
  void forget_attitude() noexcept {
    q = no_attitude;
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = std::max<std::size_t>(i, 3); j < 6; ++j) covariance[place(i, j)] = 0.0;
  }
  /// Index of row i and column j, both 0 to 5, in the packed covariance.
  static constexpr std::size_t place(std::size_t i, std::size_t j) noexcept {
    const std::size_t row = i < j ? i : j, column = i < j ? j : i;
    return row * (11 - row) / 2 + column;
  }
  /// The full symmetric covariance matrix.
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
