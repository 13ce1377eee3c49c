// What the loop makes of a measurement, before anybody is asked for a plan.
#include <algorithm>
#include <chrono>

#include "sightline/base/index.hpp"
#include "sightline/run/loop.hpp"

namespace sightline {

/// Keeps in a sample what was told, and says where robots are that were not.
Measured Loop::localize(double t, const Measured& told, Sample& sample) noexcept {
  allocated_ = allocations();
  began_ = std::chrono::steady_clock::now();
  std::copy(told.measured.begin(), told.measured.end(), sample.measured.begin());
  std::copy(told.stamps.begin(), told.stamps.end(), sample.stamps.begin());
  const auto keep = [](const auto& from, auto& to) {
    const std::size_t count = std::min(from.size(), to.size());
    std::copy_n(from.begin(), count, to.begin());
    return count;
  };
  sample.detection_count = keep(told.detections, sample.detections);
  sample.motion_count = keep(told.motions, sample.motions);
  sample.broadcast_count = keep(told.broadcasts, sample.broadcasts);
  if (options_.localizer == nullptr) return told;
  Measured seen = options_.localizer->estimate(t, told);
  keep(options_.localizer->estimates(), sample.estimates);
  sample.fit_count = keep(options_.localizer->fits(), sample.fits);
  return seen;
}

/// The inputs are in force from t on.
bool Loop::apply(double t, std::int64_t periods) noexcept {
  if (options_.localizer != nullptr) options_.localizer->apply(gate_.applied(), options_.period, periods);
  return world_.apply(t, *estimate_, gate_.applied(), options_.period, periods);
}

/// The states that the commands of t meet, predicted from the estimate of t.
const ValidStates& Loop::compensate(double t) noexcept {
  if (options_.compensation == nullptr) return *estimate_;
  for (int i = 0; i < world_.team().bodies(); ++i) {
    const BodyId body{i};
    const bool trusted = options_.guard == nullptr || options_.guard->trusts(body);
    if (trusted && presence_[size(i)] != Presence::absent) options_.compensation->look(body, measured_);
  }
  return met_.take(options_.compensation->ahead(t, *estimate_), *estimate_);
}

/// What is added to the inputs of all robots.
std::span<const double> Loop::added() const noexcept {
  return options_.compensation != nullptr ? options_.compensation->added() : std::span<const double>(none_);
}

/// What that makes bodies lean.
std::span<const Vec2<double>> Loop::added_lean() const noexcept {
  if (options_.compensation == nullptr) return {};
  return options_.compensation->lean();
}

}  // namespace sightline
