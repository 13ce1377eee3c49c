/// Stages "measure", "localize" and "validate": from the world to the valid states of a period.
#pragma once

#include <algorithm>
#include <chrono>

#include "sightline/loop.hpp"
#include "sightline/run/stages/period.hpp"

namespace sightline::stages {

/// Copies as many items as `to` has room for. @return their number
template <class From, class To>
std::size_t keep(const From& from, To& to) noexcept {
  const std::size_t count = std::min(from.size(), to.size());
  std::copy_n(from.begin(), count, to.begin());
  return count;
}

/// Measures the world, and records the measurement unchanged.
struct Measure {
  World& world;

  void run(Period& p) noexcept {
    Sample& sample = *p.sample;
    p.seen = world.measure(p.t);
    p.allocated = p.allocations();
    p.began = std::chrono::steady_clock::now();
    const Measured& seen = p.seen;
    sample.time = p.t;
    sample.truth_known = !seen.truth.empty();
    keep(seen.measured, sample.measured);
    keep(seen.stamps, sample.stamps);
    keep(seen.attitudes, sample.attitudes);
    keep(p.presence, sample.presence);
    sample.detection_count = keep(seen.detections, sample.detections);
    sample.motion_count = keep(seen.motions, sample.motions);
    sample.broadcast_count = keep(seen.broadcasts, sample.broadcasts);
  }
};

/// Estimates the poses of localized robots.
struct Localize {
  Localizer* localizer;

  void run(Period& p) noexcept {
    if (localizer == nullptr) return;
    p.seen = localizer->estimate(p.t, p.seen);
    keep(localizer->estimates(), p.sample->estimates);
    p.sample->fit_count = keep(localizer->fits(), p.sample->fits);
  }
};

/// Refuses states that are not finite or too large, and records the true states if they are known.
struct Validate {
  void run(Period& p) noexcept {
    (void)p.measured.take(p.seen.measured, p.seen.stamps);
    keep(p.seen.truth.empty() ? p.seen.measured : p.seen.truth, p.sample->x);
  }
};

}  // namespace sightline::stages
