#include <algorithm>

#include "sightline/estimate/attitude_filter.hpp"
#include "sightline/estimate/heading_filter.hpp"
#include "sightline/estimate/out_of_sequence_filter.hpp"
#include "sightline/estimator.hpp"

namespace sightline {
namespace {

/// Number of sensors of a robot with correlated errors: its sightings of each body, and its compass.
int correlated_sources(const FilterOptions& options, int observed) {
  return (options.correlation_time > 0 ? observed : 0) +
         (options.compass_noise > 0 && options.compass_time > 0 ? 1 : 0);
}

template <int sources>
std::unique_ptr<PoseFilter> filter_for(const FilterOptions& options, const SensorMount& mount) {
  const auto made = [&](const auto& filter) -> std::unique_ptr<PoseFilter> {
    return std::make_unique<OutOfSequenceFilter<std::decay_t<decltype(filter)>>>(options, filter);
  };
  if (options.filter == FilterKind::attitude) return made(AttitudeFilterOf<sources>(options, mount));
  if (options.filter == FilterKind::chain) return made(HeadingFilterOf<1, sources>(options, mount));
  return made(HeadingFilterOf<0, sources>(options, mount));
}

}  // namespace

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
  if (!motion.compass || !(options.compass_noise > 0)) return std::nullopt;
  return Measurement{.of = Measures::heading,
                     .stamp = motion.t,
                     .source = compass_source,
                     .yaw = *motion.compass,
                     .yaw_variance = square(options.compass_noise)};
}

std::unique_ptr<PoseFilter> make_pose_filter(const FilterOptions& options, const SensorMount& mount,
                                             int observed) {
  options.check();
  const int sources = correlated_sources(options, observed);
  if (sources == 0) return filter_for<0>(options, mount);
  if (sources == 1) return filter_for<1>(options, mount);
  if (sources <= correlated_sources_max) return filter_for<correlated_sources_max>(options, mount);
  throw_invalid("errors of {} sensors are correlated in time, expected at most {}", sources,
                correlated_sources_max);
}

}  // namespace sightline
