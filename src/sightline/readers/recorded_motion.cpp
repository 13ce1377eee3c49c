#include "sightline/readers/recorded_motion.hpp"

#include <algorithm>
#include <cmath>

namespace sightline {

std::optional<Rotation> recorded_attitude(const Quaternion& q) {
  const double length = std::sqrt(q.w * q.w + dot(Vec3<double>{q.x, q.y, q.z}, {q.x, q.y, q.z}));
  if (!(length > 0) || !std::isfinite(length)) return {};
  return rotation({q.w / length, q.x / length, q.y / length, q.z / length});
}

void append_sample(RecordedMotion& motion, RecordedSample sample) {
  if (!std::isfinite(sample.t + sample.p.x + sample.p.y + sample.p.z)) return;
  if (!motion.empty()) {
    const RecordedSample& last = motion.back();
    if (!(sample.t > last.t)) return;
    if (std::isfinite(last.heading)) sample.heading = last.heading + wrap(sample.heading - last.heading);
  }
  motion.push_back(sample);
}

std::optional<RecordedSample> sample_at(const RecordedMotion& motion, double t, double gap) {
  const auto after =
      std::lower_bound(motion.begin(), motion.end(), t,
                       [](const RecordedSample& sample, double time) { return sample.t < time; });
  if (after == motion.end()) return {};
  if (after->t == t) return *after;
  if (after == motion.begin()) return {};
  const RecordedSample &a = *(after - 1), &b = *after;
  if (b.t - a.t > gap) return {};
  const double share = (t - a.t) / (b.t - a.t);
  return RecordedSample{t, a.p + share * (b.p - a.p), a.v + share * (b.v - a.v),
                        a.heading + share * (b.heading - a.heading)};
}

}  // namespace sightline
