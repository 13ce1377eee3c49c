/// Inertial measurements of a robot, from the receive thread to its attitude filter.
#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>

#include "bridges/dds/topics/conversion.hpp"
#include "bridges/dds/topics/latency_monitor.hpp"
#include "bridges/dds/topics/surroundings.hpp"
#include "sightline/estimator.hpp"
#include "sightline/loop.hpp"

namespace sightline::dds {

/// Whether the end of a link reads the robot's IMU.
enum class Inertial { unread, read };

/// Means of an IMU since its previous measurement.
struct InertialSample {
  Nanoseconds stamp = 0;  ///< end of the means, by the robot's clock
  Vec3<double> gyro{};    ///< angular velocity in B [rad/s]
  Vec3<double> force{};   ///< specific force in B, (0, 0, g) at rest [m/s^2]
};

/// Averages the measurements over the motion samples of the robot's odometry. The stamps of both are
/// by one clock, so offset, drift and transport delay have no influence.
///
/// A measurement covers the time since the previous one, at most `longest`. So one that follows a
/// lost one stands for both. A motion sample needs measurements over `covered_least` of its length,
/// which arrived before the odometry at its end or in the same period. The newest one holds for
/// `held` more, where odometry and measurements come in any order.
class InertialSamples {
 public:
  static constexpr Nanoseconds longest = 20'000'000;
  static constexpr double covered_least = 0.5;
  static constexpr double rate_least = 1e9 / static_cast<double>(longest);  ///< for a whole cover [1/s]

  explicit InertialSamples(Nanoseconds held = 0) : held_(held) {}

  // Receive thread only; allocates nothing.
  /// Queues a measurement. One that is not finite is only counted.
  void put(const InertialSample& sample, Nanoseconds arrived) noexcept;

  // Control thread only; allocates nothing.
  /// Discards everything that has arrived.
  void forget() noexcept;
  /// Sets gyro and force of a motion sample to the means over it.
  /// @param end  of the motion sample, by the robot's clock; increasing from call to call
  /// @return false if too little of it was measured
  bool fill(Nanoseconds end, MotionSample& motion) noexcept;

  // Any thread may call these.
  const LatencyMonitor& arrivals() const noexcept { return arrivals_; }
  std::int64_t not_finite() const noexcept { return not_finite_; }

 private:
  static constexpr std::size_t kept = 256;  // 0.6 s at 400 Hz
  static constexpr Nanoseconds ahead_most =
      100'000'000;  // of the odometry; beyond: before a jump of the clock

  SpscQueue<InertialSample> each_{kept, InertialSample{}};
  LatencyMonitor arrivals_;
  std::atomic<std::int64_t> not_finite_{0};
  Nanoseconds held_;
  InertialSample last_{};  // newest measurement that is used up; its stamp is 0 if there is none
};

/// Adds the findings about the measurements that `reader` receives.
/// @param otherwise  why messages that arrive have no measurement, in a few words
void examine_inertial(const InertialSamples& samples, const RawReader& reader, std::string_view otherwise,
                      const Surroundings& around, FindingList& to);

}  // namespace sightline::dds
