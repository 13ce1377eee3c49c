#include <algorithm>

#include "sightline/base.hpp"
#include "sightline/estimator.hpp"

namespace sightline {
namespace {

const BroadcastOptions& checked_broadcast(const BroadcastOptions& options) {
  options.check();
  return options;
}

bool is_usable(const BroadcastPose& m) {
  bool usable = std::isfinite(m.stamp) && is_finite(m.p) && is_finite(m.v) && std::isfinite(m.psi) &&
                std::isfinite(m.yaw_rate);
  for (int i = 0; i < 4; ++i) {
    usable = usable && m.P(i, i) >= 0;
    for (int j = 0; j < 4; ++j) usable = usable && std::isfinite(m.P(i, j));
  }
  return usable;
}

}  // namespace

BroadcastTrack::BroadcastTrack(const BroadcastOptions& options) : options_(checked_broadcast(options)) {}

void BroadcastTrack::take(const BroadcastPose& message) noexcept {
  if (!is_usable(message)) return;
  BroadcastPose* end = messages_.data() + count_;
  BroadcastPose* place =
      std::lower_bound(messages_.data(), end, message.stamp,
                       [](const BroadcastPose& m, double stamp) { return m.stamp < stamp; });
  if (place != end && place->stamp == message.stamp) return;
  if (count_ < memory) {
    std::copy_backward(place, end, end + 1);
    ++count_;
  } else {
    if (place == messages_.data()) return;
    std::copy(messages_.data() + 1, place, messages_.data());
    --place;
  }
  *place = message;
}

std::optional<KnownPose> BroadcastTrack::at(double t) const noexcept {
  constexpr double gap = 0.5;  // longest interval between two messages for interpolation [s]
  const BroadcastPose* end = messages_.data() + count_;
  const BroadcastPose* next = std::lower_bound(
      messages_.data(), end, t, [](const BroadcastPose& m, double stamp) { return m.stamp < stamp; });
  if (next != end && next->stamp == t) return between(*next, *next, t);
  if (next == messages_.data()) return std::nullopt;
  const BroadcastPose& last = *(next - 1);
  if (next != end && next->stamp - last.stamp <= gap) return between(last, *next, t);
  if (t - last.stamp > options_.longest) return std::nullopt;
  return after(last, t);
}

double BroadcastTrack::uses(double interval) const noexcept {
  return std::max(1.0, interval * options_.sighting_rate);
}

KnownPose BroadcastTrack::between(const BroadcastPose& a, const BroadcastPose& b, double t) const noexcept {
  const double h = b.stamp - a.stamp, s = h > 0 ? (t - a.stamp) / h : 0.0, s2 = s * s, s3 = s2 * s;
  KnownPose pose;
  pose.p = (2 * s3 - 3 * s2 + 1) * a.p + (h * (s3 - 2 * s2 + s)) * a.v + (3 * s2 - 2 * s3) * b.p +
           (h * (s3 - s2)) * b.v;
  pose.psi = wrap(a.psi + s * wrap(b.psi - a.psi));
  pose.P = uses(h) * ((1 - s) * a.P + s * b.P);
  return pose;
}

KnownPose BroadcastTrack::after(const BroadcastPose& a, double t) const noexcept {
  const double d = t - a.stamp;
  const std::size_t place = static_cast<std::size_t>(&a - messages_.data());
  const double more = uses(place > 0 ? a.stamp - messages_[place - 1].stamp : d);
  KnownPose pose;
  pose.p = a.p + d * a.v;
  pose.psi = wrap(a.psi + d * a.yaw_rate);
  const double drift = square(0.5 * options_.acceleration * d * d) + square(options_.velocity_sigma * d);
  pose.P = a.P;
  for (int i = 0; i < 3; ++i) pose.P(i, i) += drift;
  pose.P(3, 3) += square(options_.turning * d);
  pose.P = more * pose.P;
  return pose;
}

}  // namespace sightline
