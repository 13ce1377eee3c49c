#include "bridges/dds/links/frame_anchor.hpp"

#include <cmath>

namespace sightline::dds {
namespace {

constexpr Nanoseconds clock_turned_back = 1'000'000'000;  // an older stamp means that the clock was set back

}  // namespace

bool FrameAnchor::follow(Motion& local, int resets, Nanoseconds sampled) noexcept {
  if (!std::isfinite(local.p.x + local.p.y + local.p.z + local.v.x + local.v.y + local.v.z)) return false;
  const Nanoseconds since = sampled - sampled_;
  if (begun_ && since <= 0 && since > -clock_turned_back) return false;
  if (begun_ && resets != resets_ && held_) {
    const double dt = 1e-9 * static_cast<double>(since > 0 ? since : 0);
    const Vec3<double> expected = last_.p + dt * last_.v;
    const Vec3<double> shift = expected - local.p;
    moved_ = moved_ + norm(shift - shift_);
    ++jumps_;
    shift_ = shift;
  }
  begun_ = true, resets_ = resets, sampled_ = sampled;
  local.p = local.p + shift_;
  last_ = local;
  return true;
}

}  // namespace sightline::dds
