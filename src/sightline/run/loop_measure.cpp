// The parts of the loop around an update: localization, application of commands, and samples
// without an update.
#include <algorithm>
#include <chrono>
#include <thread>

#include "sightline/base/index.hpp"
#include "sightline/run/loop.hpp"

namespace sightline {

/// Copies a measurement into the sample, and estimates the poses of localized robots.
Measured Loop::localize(double t, const Measured& reported, Sample& sample) noexcept {
  allocated_ = allocations();
  began_ = std::chrono::steady_clock::now();
  std::copy(reported.measured.begin(), reported.measured.end(), sample.measured.begin());
  std::copy(reported.stamps.begin(), reported.stamps.end(), sample.stamps.begin());
  const auto keep = [](const auto& from, auto& to) {
    const std::size_t count = std::min(from.size(), to.size());
    std::copy_n(from.begin(), count, to.begin());
    return count;
  };
  sample.detection_count = keep(reported.detections, sample.detections);
  sample.motion_count = keep(reported.motions, sample.motions);
  sample.broadcast_count = keep(reported.broadcasts, sample.broadcasts);
  if (options_.localizer == nullptr) return reported;
  Measured seen = options_.localizer->estimate(t, reported);
  keep(options_.localizer->estimates(), sample.estimates);
  sample.fit_count = keep(options_.localizer->fits(), sample.fits);
  return seen;
}

/// Applies the inputs from t on. If several periods pass and the truth is known, the sink receives
/// the states at the end of each but the last, as far as it has room.
bool Loop::apply(double t, std::int64_t periods) noexcept {
  if (options_.localizer != nullptr) options_.localizer->apply(gate_.applied(), options_.period, periods);
  const bool shows = periods > 1 && outcome_.updates > 0 && !world_.truth().empty();
  const std::int64_t together = shows ? 1 : periods;
  for (std::int64_t k = 0; k < periods; k += together) {
    const double from = t + static_cast<double>(k) * options_.period;
    if (!world_.apply(from, *estimate_, gate_.applied(), options_.period, together)) return false;
    if (k + together == periods) break;
    if (Sample* const slot = sink_.claim_between(); slot != nullptr) {
      fill(*slot, from + options_.period, world_.truth(), true);
      sink_.publish();
    }
  }
  return true;
}

/// Fills a sample without an update.
void Loop::fill(Sample& sample, double t, std::span<const double> x, bool is_truth) const noexcept {
  sample.of = Sample::Of::states;
  sample.time = t;
  sample.truth_known = is_truth;
  sample.has_path = false;
  sample.event_count = 0;
  std::copy(x.begin(), x.end(), sample.x.begin());
  const auto applied = gate_.applied();
  std::copy(applied.begin(), applied.end(), sample.u.begin());
  std::copy(presence_.begin(), presence_.end(), sample.presence.begin());
  if (options_.guard == nullptr) return;
  const auto levels = options_.guard->levels();
  std::copy(levels.begin(), levels.end(), sample.levels.begin());
}

/// Publishes the states after the last command, true or else measured, with the events that are in
/// no sample yet.
void Loop::show_end(double t) noexcept {
  std::span<const double> x = world_.truth();
  const bool is_truth = !x.empty();
  if (!sink_.takes_between() || (!is_truth && (!outcome_.finite || options_.localizer != nullptr))) return;
  Sample* slot = sink_.claim_between();
  while (slot == nullptr && clock_.waits_for_log()) {
    std::this_thread::yield();
    slot = sink_.claim_between();
  }
  if (slot == nullptr) return;
  if (!is_truth) x = world_.measure(t).measured;
  fill(*slot, t, x, is_truth);
  move_events(*slot);
  sink_.publish();
}

/// Moves events into a sample; those that do not fit wait for the next one. Events that change the
/// team go first: their sample is the first of the new team.
void Loop::move_events(Sample& sample) noexcept {
  for (std::size_t first = 0, k = 0; events_.size() > sample.events.size() && k < events_.size(); ++k) {
    if (events_[k].kind == EventKind::event_in_force) std::swap(events_[first++], events_[k]);
  }
  const auto fit = static_cast<std::ptrdiff_t>(std::min(events_.size(), sample.events.size()));
  std::copy_n(events_.begin(), fit, sample.events.begin());
  sample.event_count = static_cast<int>(fit);
  events_.erase(events_.begin(), events_.begin() + fit);
}

/// The states at which the commands of t take effect, predicted from the estimate of t.
const ValidStates& Loop::compensate(double t) noexcept {
  if (options_.compensation == nullptr) return *estimate_;
  for (int i = 0; i < world_.team().bodies(); ++i) {
    const BodyId body{i};
    const bool trusted = options_.guard == nullptr || options_.guard->trusts(body);
    if (trusted && presence_[size(i)] != Presence::absent) options_.compensation->look(body, measured_);
  }
  return met_.take(options_.compensation->ahead(t, *estimate_), *estimate_);
}

/// Offset to the inputs of all robots.
std::span<const double> Loop::added() const noexcept {
  return options_.compensation != nullptr ? options_.compensation->added() : std::span<const double>(none_);
}

/// Tilt of each body due to added().
std::span<const Vec2<double>> Loop::added_lean() const noexcept {
  if (options_.compensation == nullptr) return {};
  return options_.compensation->lean();
}

}  // namespace sightline
