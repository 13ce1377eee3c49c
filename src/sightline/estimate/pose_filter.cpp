#include "sightline/estimate/pose_filter.hpp"

#include "sightline/estimate/attitude_filter.hpp"
#include "sightline/estimate/delayed.hpp"
#include "sightline/estimate/heading_filter.hpp"

namespace sightline {

std::string_view to_string(FitVerdict verdict) {
  constexpr std::array<std::string_view, verdict_count> names = {
      "accepted", "accepted_position", "rejected", "started",  "restarted",
      "waiting",  "pending",           "too_old",  "repeated", "unusable"};
  return names[static_cast<std::size_t>(verdict)];
}

std::unique_ptr<PoseFilter> make_pose_filter(const FilterOptions& options, const SensorMount& mount) {
  options.check();
  if (options.filter == FilterKind::attitude)
    return std::make_unique<Delayed<AttitudeFilter>>(options, AttitudeFilter(options, mount));
  if (options.filter == FilterKind::chain)
    return std::make_unique<Delayed<ChainFilter>>(options, ChainFilter(options, mount));
  return std::make_unique<Delayed<HeadingFilter>>(options, HeadingFilter(options, mount));
}

}  // namespace sightline
