#include "sightline/run/stages/log.hpp"

#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sightline/base.hpp"
#include "sightline/loop.hpp"

namespace sightline::stages {
namespace {

constexpr std::int64_t no_paths = std::numeric_limits<std::int64_t>::max();
constexpr double end_after_stop = 1.0;  // longest wait of the last sample after a stop request [s]

std::array<std::size_t, 12> sizes_of(const Sample& s) {
  return {s.x.size(),        s.attitudes.size(),  s.path.size(),   s.solvers.size(),
          s.barriers.size(), s.views.size(),      s.levels.size(), s.detections.size(),
          s.motions.size(),  s.broadcasts.size(), s.fits.size(),   s.estimates.size()};
}

/// Moves events into a sample; those that do not fit wait for the next one. Events that change the
/// team go first: their sample is the first of the new team.
void move_events(std::vector<Event>& events, Sample& sample) noexcept {
  for (std::size_t first = 0, k = 0; events.size() > sample.events.size() && k < events.size(); ++k) {
    if (events[k].kind == EventKind::event_in_force) std::swap(events[first++], events[k]);
  }
  const auto fit = static_cast<std::ptrdiff_t>(std::min(events.size(), sample.events.size()));
  std::copy_n(events.begin(), fit, sample.events.begin());
  sample.event_count = static_cast<int>(fit);
  events.erase(events.begin(), events.begin() + fit);
}

}  // namespace

Log::Log(Sink<Sample>& sink, const Clock& clock, const LoopOptions& options, const Sample& size, Period& p)
    : sink_(sink),
      clock_(clock),
      options_(options),
      path_every_(std::max<std::int64_t>(1, std::llround(options.path_interval / options.period))),
      next_path_(options.path_interval > 0 ? 0 : no_paths),
      spare_(size) {
  const Sample* item = sink.claim();
  const bool has_room = item == nullptr || item->path_u.empty() ||  // or room for each stage
                        item->path_u.size() * item->x.size() == item->path.size() * item->u.size();
  if (item == nullptr || !has_room || sizes_of(*item) != sizes_of(spare_) ||
      item->events.size() < spare_.events.size()) {
    throw_invalid(
        "the sink's samples are not of this loop's size, expected room in it for copies of sized_sample()");
  }
  p.events.reserve(64 + 2 * p.u.size() + 2 * spare_.solvers.size() + spare_.events.size());
}

Sample* Log::wait_for(Claim claim, double after_stop) noexcept {
  constexpr timespec nap = {0, 100'000};
  // Counted in sleeps, so that a suspended process does not count its pause as a wait for the log.
  constexpr double nap_length = 1e-4;
  Sample* slot = (sink_.*claim)();
  for (std::int64_t naps = 0; slot == nullptr && clock_.waits_for_log() && !is_stuck_; ++naps) {
    const double waited = static_cast<double>(naps) * nap_length;
    if (options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed) && waited >= after_stop)
      break;
    is_stuck_ = waited >= options_.log_patience || sink_.is_abandoned();
    ::nanosleep(&nap, nullptr);
    slot = (sink_.*claim)();
  }
  if (slot != nullptr) is_stuck_ = false;
  return slot;
}

void Log::open(Period& p) noexcept {
  Sample* const slot = wait_for(&Sink<Sample>::claim, 0.0);
  p.sample = slot != nullptr ? slot : &spare_;
  p.sample->of = Sample::Of::update;
  p.sample->has_path = p.k >= next_path_;
  if (p.sample->has_path) next_path_ = (p.k / path_every_ + 1) * path_every_;
}

void Log::run(Period& p) noexcept {
  LoopOutcome& outcome = p.outcome;
  outcome.max_allocations = std::max(outcome.max_allocations, p.allocations() - p.allocated);
  if (p.sample == &spare_) {
    ++outcome.dropped;
    sink_.drop(spare_);
    return;
  }
  if (outcome.dropped > reported_) {
    reported_ = outcome.dropped;
    p.emit({p.t, EventKind::samples_dropped, 0, static_cast<double>(reported_)});
  }
  move_events(p.events, *p.sample);
  sink_.publish();
}

void Log::show(const Period& p, double t, std::span<const double> truth) noexcept {
  Sample* const slot = sink_.claim_between();
  if (slot == nullptr) return;
  fill(p, t, truth, true, *slot);
  sink_.publish();
}

void Log::show_end(Period& p, World& world) noexcept {
  std::span<const double> x = world.truth();
  const bool is_truth = !x.empty();
  if (!sink_.takes_between() || (!is_truth && (!p.outcome.finite || options_.localizer != nullptr))) return;
  Sample* const slot = wait_for(&Sink<Sample>::claim_between, end_after_stop);
  if (slot == nullptr) return;
  if (!is_truth) x = world.measure(p.t).measured;
  fill(p, p.t, x, is_truth, *slot);
  move_events(p.events, *slot);
  sink_.publish();
}

/// Fills a sample without an update.
void Log::fill(const Period& p, double t, std::span<const double> x, bool is_truth,
               Sample& sample) const noexcept {
  sample.of = Sample::Of::states;
  sample.time = t;
  sample.truth_known = is_truth;
  sample.has_path = false;
  sample.event_count = 0;
  std::ranges::copy(x, sample.x.begin());
  std::ranges::copy(p.gate.applied(), sample.u.begin());
  std::ranges::copy(p.presence, sample.presence.begin());
  if (options_.guard != nullptr) std::ranges::copy(options_.guard->levels(), sample.levels.begin());
}

}  // namespace sightline::stages
