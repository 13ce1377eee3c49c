/// Motion and commands of a body as a recording has them, in the frame G.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/world.hpp"

namespace sightline {

struct RecordedSample {
  double t = 0.0;                                ///< [s], by the recording's clock
  Vec3<double> p{};                              ///< [m]
  Vec3<double> v{no_value, no_value, no_value};  ///< [m/s]; NaN: unknown
  double heading = no_value;                     ///< [rad], without jumps by full turns; NaN: unknown
};

/// Samples at times that rise.
using RecordedMotion = std::vector<RecordedSample>;

/// A commanded velocity.
struct VelocityCommand {
  double t = 0.0;         ///< [s]
  Vec3<double> v{};       ///< [m/s]
  double yaw_rate = 0.0;  ///< [rad/s], counter-clockwise seen from above
};

/// The attitude by a quaternion of any length; empty if that is not finite or is 0, as of a body of which
/// only the position is measured.
std::optional<Rotation> recorded_attitude(const Quaternion& q);

/// Sorts samples with a time t; equal times keep their order.
template <class Sample>
void sort_by_time(std::vector<Sample>& samples) {
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Sample& a, const Sample& b) { return a.t < b.t; });
}

/// Appends a sample; one that is not after the last, or has no finite position, is left out. The
/// heading is unwrapped.
void append_sample(RecordedMotion& motion, RecordedSample sample);

/// The motion at a time, linear between two samples at most `gap` [s] apart; empty elsewhere.
std::optional<RecordedSample> sample_at(const RecordedMotion& motion, double t, double gap);

}  // namespace sightline
