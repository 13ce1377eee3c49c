#include <algorithm>

#include "sightline/estimate/attitude_filter.hpp"
#include "sightline/estimate/heading_filter.hpp"
#include "sightline/estimate/out_of_sequence_filter.hpp"
#include "sightline/estimator.hpp"

namespace sightline {

std::string_view to_string(FitVerdict verdict) {
  constexpr std::array<std::string_view, verdict_count> names = {
      "accepted", "accepted_position", "rejected", "started",  "restarted",
      "waiting",  "pending",           "too_old",  "repeated", "unusable"};
  return names[static_cast<std::size_t>(verdict)];
}

double PoseEstimate::bearing_sigma(const KnownPose& other) const noexcept {
  constexpr double least = 0.2;  // smallest horizontal distance [m]; closer, the direction is undefined
  const double x = other.p.x - p.x, y = other.p.y - p.y, level = std::max(x * x + y * y, least * least);
  const auto variance = [&](const Mat<4, 4>& of) {
    return (y * y * of(0, 0) - 2 * x * y * of(0, 1) + x * x * of(1, 1)) / (level * level);
  };
  const double with_heading = P(3, 3) + 2 * (x * P(1, 3) - y * P(0, 3)) / level;
  return sqrt(std::max(0.0, variance(P) + variance(other.P) + with_heading));
}

std::optional<Measurement> compass_of(const MotionSample& motion, const FilterOptions& options) noexcept {
  constexpr int compass_source = -1;  // sightings use the index of a body
  if (!motion.compass || !(options.compass_noise > 0)) return std::nullopt;
  return Measurement{.of = Measures::heading,
                     .stamp = motion.t,
                     .source = compass_source,
                     .yaw = *motion.compass,
                     .yaw_variance = square(options.compass_noise)};
}

std::unique_ptr<PoseFilter> make_pose_filter(const FilterOptions& options, const SensorMount& mount) {
  options.check();
  if (options.filter == FilterKind::attitude)
    return std::make_unique<OutOfSequenceFilter<AttitudeFilter>>(options, AttitudeFilter(options, mount));
  if (options.filter == FilterKind::chain)
    return std::make_unique<OutOfSequenceFilter<ChainFilter>>(options, ChainFilter(options, mount));
  return std::make_unique<OutOfSequenceFilter<HeadingFilter>>(options, HeadingFilter(options, mount));
}

}  // namespace sightline
