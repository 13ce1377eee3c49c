/// Pose of a body that broadcasts it by radio, at any time between its messages and shortly after.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "sightline/base/parameter.hpp"
#include "sightline/estimate/measurement.hpp"

namespace sightline {

/// A broadcast: pose, velocity, yaw rate and pose covariance of a body.
struct BroadcastPose {
  double stamp = 0.0;     ///< [s]
  Vec3<double> p{}, v{};  ///< in G [m], [m/s]
  double psi = 0.0;       ///< heading [rad]
  double yaw_rate = 0.0;  ///< [rad/s]
  Mat<4, 4> P{};          ///< covariance of (p, psi)
};

/// Pose of an observed body, with its covariance, as reference of a sighting.
struct KnownPose {
  Vec3<double> p{};
  double psi = 0.0;
  Mat<4, 4> P{};
};

struct BroadcastOptions {
  static constexpr std::string_view name = "broadcast";

  double acceleration = 1.0;
  double velocity_sigma = 0.03;
  double turning = 0.5;
  double longest = 0.3;
  double sighting_rate = 30.0;

  static constexpr auto parameters() {
    using O = BroadcastOptions;
    return std::tuple{parameter("acceleration", &O::acceleration, "m/s^2", from_zero,
                                "of the body after its last message, standard deviation"),
                      parameter("velocity_sigma", &O::velocity_sigma, "m/s", from_zero,
                                "of the broadcast velocity, each axis"),
                      parameter("turning", &O::turning, "rad/s", from_zero,
                                "of its heading after its last message, besides the broadcast yaw rate"),
                      parameter("longest", &O::longest, "s", above_zero,
                                "after its last message that its pose is carried on"),
                      parameter("sighting_rate", &O::sighting_rate, "Hz", above_zero,
                                "of the sightings that are held against it")};
  }

  bool operator==(const BroadcastOptions&) const = default;
  /// @throws std::invalid_argument naming a number out of its range
  void check() const { check_parameters(*this); }
};

/// Between two messages the position is a cubic in time through their positions and velocities
/// (Hermite), and the heading is linear. After the last message the pose is extrapolated, and its
/// uncertainty grows by the options.
///
/// Several sightings between two messages share the error of the messages; a filter would take it
/// to be independent each time. So the covariance is multiplied by the number of sightings per
/// message, if that is above 1.
class BroadcastTrack {
 public:
  static constexpr std::size_t memory = 64;

  /// @throws std::invalid_argument from BroadcastOptions::check()
  explicit BroadcastTrack(const BroadcastOptions& options = {});

  /// Messages may be late and out of order. A message is ignored if it is not finite or has the
  /// stamp of a stored message.
  void take(const BroadcastPose& message) noexcept;
  bool is_known() const noexcept { return count_ > 0; }
  /// Newest message; requires is_known().
  const BroadcastPose& newest() const noexcept { return messages_[count_ - 1]; }
  /// Pose at time t [s]; empty before the first message or too long after the last one.
  std::optional<KnownPose> at(double t) const noexcept;
  void forget() noexcept { count_ = 0; }

 private:
  KnownPose between(const BroadcastPose& a, const BroadcastPose& b, double t) const noexcept;
  KnownPose after(const BroadcastPose& a, double t) const noexcept;
  double uses(double interval) const noexcept;

  BroadcastOptions options_;
  std::array<BroadcastPose, memory> messages_{};  // the first count_ are valid, sorted by stamp
  std::size_t count_ = 0;
};

}  // namespace sightline
