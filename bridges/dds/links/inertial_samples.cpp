#include "bridges/dds/links/inertial_samples.hpp"

#include <algorithm>
#include <cmath>

#include "sightline/base/now.hpp"

namespace sightline::dds {

void InertialSamples::put(const InertialSample& sample, Nanoseconds arrived) noexcept {
  if (!is_finite(sample.gyro) || !is_finite(sample.force)) {
    ++not_finite_;
    return;
  }
  arrivals_.note(sample.stamp, arrived);
  InertialSample* const place = each_.claim();
  if (place == nullptr) return;
  *place = sample;
  each_.publish();
}

void InertialSamples::forget() noexcept {
  for (; const InertialSample* const oldest = each_.front(); each_.pop()) last_ = oldest->stamp;
}

bool InertialSamples::fill(Nanoseconds end, MotionSample& motion) noexcept {
  const Nanoseconds begin = end - to_nanoseconds(motion.dt);
  Vec3<double> turned{}, pushed{};
  double covered = 0.0;
  for (; const InertialSample* const next = each_.front(); each_.pop()) {
    const Nanoseconds passed = next->stamp - last_;
    if (passed <= 0 && passed > -longest) continue;  // repeated, or out of order
    if (next->stamp - end <= ahead_most) {
      const Nanoseconds since = passed > 0 && passed < longest ? last_ : next->stamp - longest;
      const Nanoseconds within = std::min(next->stamp, end) - std::max(since, begin);
      const double share = to_seconds(std::max<Nanoseconds>(within, 0));
      turned = turned + share * next->gyro;
      pushed = pushed + share * next->force;
      covered += share;
      if (next->stamp > end) break;  // the next motion sample takes the rest of it
    }
    last_ = next->stamp;
  }
  if (covered < covered_least * motion.dt) return false;
  motion.gyro = (1.0 / covered) * turned;
  motion.force = (1.0 / covered) * pushed;
  return true;
}

}  // namespace sightline::dds
