#include "bridges/dds/links/inertial_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "sightline/base/now.hpp"

namespace sightline::dds {
namespace {

constexpr std::int64_t inertial_needed = 20;  // before their rate is judged

}  // namespace

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
  for (; const InertialSample* const oldest = each_.front(); each_.pop()) last_ = *oldest;
}

bool InertialSamples::fill(Nanoseconds end, MotionSample& motion) noexcept {
  const Nanoseconds begin = end - to_nanoseconds(motion.dt);
  Vec3<double> turned{}, pushed{};
  double covered = 0.0;
  const auto add = [&](const InertialSample& sample, Nanoseconds since, Nanoseconds until) {
    const Nanoseconds within = std::min(until, end) - std::max(since, begin);
    const double share = to_seconds(std::max<Nanoseconds>(within, 0));
    turned = turned + share * sample.gyro;
    pushed = pushed + share * sample.force;
    covered += share;
  };
  for (; const InertialSample* const next = each_.front(); each_.pop()) {
    const Nanoseconds passed = next->stamp - last_.stamp;
    if (passed <= 0 && passed > -longest) continue;  // repeated, or out of order
    if (next->stamp - end <= ahead_most) {
      const Nanoseconds since = passed > 0 && passed < longest ? last_.stamp : next->stamp - longest;
      add(*next, since, next->stamp);
      if (next->stamp > end) break;  // the next motion sample takes the rest of it
    }
    last_ = *next;
  }
  if (each_.front() == nullptr) add(last_, last_.stamp, last_.stamp + held_);
  if (covered < covered_least * motion.dt) return false;
  motion.gyro = (1.0 / covered) * turned;
  motion.force = (1.0 / covered) * pushed;
  return true;
}

void examine_inertial(const InertialSamples& samples, const RawReader& reader, std::string_view otherwise,
                      const Surroundings& around, FindingList& to) {
  const ArrivalFigures f = samples.arrivals().figures(monotonic_now(), 0);
  if (f.count == 0)
    to.add(Aspect::topics, Light::red, "{}: no measurement of its IMU, which the attitude filter needs: {}",
           reader.topic(),
           reader.counts().received == 0 ? why_nothing_comes(reader, around)
           : samples.not_finite() == 0   ? std::string(otherwise)
                                         : fmt::format("{} are not finite", samples.not_finite()));
  if (reader.counts().foreign > 0)
    to.add(Aspect::writers, Light::red, "{}: {} messages of a second writer", reader.topic(),
           reader.counts().foreign.load());
  if (f.count < inertial_needed) return;
  const bool rare = f.rate < InertialSamples::rate_least;
  to.add(Aspect::rate, rare ? Light::red : Light::green,
         "{:.0f} measurements of its IMU a second, the longest gap {:.3f} s, the last {:.3f} s old{}", f.rate,
         f.gap_longest, f.age,
         rare ? fmt::format("; the attitude filter needs {:.0f}", InertialSamples::rate_least) : "");
}

}  // namespace sightline::dds
