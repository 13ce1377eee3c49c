#include "bridges/dds/links/frame_anchor.hpp"

#include <algorithm>

#include "sightline/base/now.hpp"

namespace sightline::dds {

void FrameAnchor::follow(Motion& local, int resets, Nanoseconds sampled) noexcept {
  if (begun_ && resets != resets_ && held_) {
    const double dt = to_seconds(std::max<Nanoseconds>(sampled - sampled_, 0));
    const Vec3<double> expected = last_.p + dt * last_.v;
    const Vec3<double> shift = expected - local.p;
    moved_ = moved_ + norm(shift - shift_);
    ++jumps_;
    shift_ = shift;
  }
  begun_ = true, resets_ = resets, sampled_ = sampled;
  local.p = local.p + shift_;
  last_ = local;
}

}  // namespace sightline::dds
