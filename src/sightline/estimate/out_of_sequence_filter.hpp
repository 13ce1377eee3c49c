/// Filter for delayed measurements: stores states, motion and measurements, and applies each
/// measurement at its stamp, whenever it arrives.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "sightline/base/bounded.hpp"
#include "sightline/estimate/agreement.hpp"
#include "sightline/estimate/kalman.hpp"
#include "sightline/estimate/stamped_list.hpp"
#include "sightline/estimator.hpp"

namespace sightline {

/// Implements PoseFilter with the mathematics of `Filter` (HeadingFilter, AttitudeFilter).
///
/// The memory is a ring of samples, each with the state at its start, and all measurements sorted
/// by stamp. Rejected measurements stay in it: the gate may decide otherwise after an earlier
/// measurement arrives.
///
/// An estimate starts when `start_sightings` measurements agree on one pose (Agreement). It
/// restarts from the last of `restart_sightings` rejected measurements that agree on one pose, with
/// no accepted measurement in between. Headings are counted separately. If the position fits and
/// the heading does not, only the position is used. As many agreeing headings of sightings also
/// cause a restart; compass headings discard the estimate.
template <class Filter>
class OutOfSequenceFilter final : public PoseFilter {
 public:
  using State = typename Filter::State;
  static constexpr int n = Filter::n;

  OutOfSequenceFilter(const FilterOptions& options, const Filter& filter)
      : filter_(filter),
        start_(options.start_sightings),
        restart_(options.restart_sightings),
        slots_(memory) {}

  void advance(const MotionSample& motion) noexcept override;
  Fit take(const Measurement& z) noexcept override;
  void start(const Vec3<double>& p, double psi, const Mat<4, 4>& P) noexcept override;
  void forget() noexcept override;
  PoseEstimate estimate() const noexcept override;
  /// State at the end of the last sample; valid if there is an estimate.
  const State& state() const noexcept { return state_; }

 private:
  static constexpr std::size_t pending_max = 8;
  static constexpr double ahead = 0.05;  // largest lead of a stamp over the last sample [s]

  /// A sample and the estimate at its start.
  struct Slot {
    MotionSample motion{};
    double from = 0.0, until = 0.0;
    State state{};  // before the measurements at `from`
    DeadReckoning reckoned{};
  };
  struct Heading {  // of a compass, before the first estimate
    double psi, variance, stamp;
    DeadReckoning reckoned;
  };

  Slot& at(std::size_t i) noexcept { return slots_[(first_ + i) % memory]; }
  const Slot& at(std::size_t i) const noexcept { return slots_[(first_ + i) % memory]; }
  std::size_t slot_of(double stamp) const noexcept;
  void drop_slot() noexcept;

  bool remember(const Measurement& z) noexcept;

  Fit weigh(State& s, const Measurement& z, const MotionSample& motion) const noexcept;
  Fit intersect(State& s, const Measurement& z, const MotionSample& motion) const noexcept;
  template <int m>
  bool apply(State& s, const Innovation<m, n>& of, Fit& fit) const noexcept;
  Fit run(const Slot& slot, State& s, const Measurement* watched) noexcept;
  Fit replay(std::size_t from, const Measurement* watched) noexcept;

  DeadReckoning dead_reckoning_at(const Slot& slot, double stamp) const noexcept;
  PoseHypothesis meaning(const Measurement& z, const Slot& slot, double psi,
                         double psi_variance) const noexcept;
  FitVerdict consider(const Measurement& z, std::size_t slot) noexcept;
  FitVerdict judge(const Measurement& z, FitVerdict verdict) noexcept;
  void begin(const Measurement& z, std::size_t slot, double psi, double psi_variance) noexcept;

  Filter filter_;
  int start_, restart_;
  std::vector<Slot> slots_;  // ring
  std::size_t first_ = 0, count_ = 0;
  StampedList<Measurement, memory> measured_{};
  Bounded<Measurement, pending_max> pending_;
  State state_{};
  MotionSample last_{};
  DeadReckoning dead_reckoning_{};
  double now_ = -std::numeric_limits<double>::infinity();
  bool known_ = false;
  double begun_ = 0.0, last_accepted_ = 0.0;
  Agreement candidates_, contradictions_, turned_;
  Heading compass_{0.0, 0.0, -std::numeric_limits<double>::infinity(), {}};
};

template <class Filter>
void OutOfSequenceFilter<Filter>::advance(const MotionSample& motion) noexcept {
  if (!is_usable(motion) || motion.t + motion.dt <= now_) return;
  if (count_ == memory) drop_slot();
  Slot& slot = at(count_++);
  slot.motion = last_ = motion;
  slot.from = std::isfinite(now_) ? now_ : motion.t;
  slot.until = now_ = motion.t + motion.dt;
  slot.reckoned = dead_reckoning_;
  slot.state = state_;
  dead_reckoning_.advance(motion, slot.until - slot.from);
  if (known_) run(slot, state_, nullptr);
  const Bounded<Measurement, pending_max> waiting = pending_;
  pending_.clear();
  for (const Measurement& z : waiting) take(z);
}

template <class Filter>
Fit OutOfSequenceFilter<Filter>::take(const Measurement& z) noexcept {
  if (!z.is_usable()) return {FitVerdict::unusable};
  if (z.stamp >= now_) {
    if (z.stamp > now_ + ahead || pending_.is_full()) return {FitVerdict::unusable};
    pending_.push_back(z);
    return {FitVerdict::pending};
  }
  if (count_ == 0 || z.stamp < at(0).from || (known_ && z.stamp <= begun_)) return {FitVerdict::too_old};
  if (!known_) return {consider(z, slot_of(z.stamp))};
  if (measured_.has(z)) return {FitVerdict::repeated};
  if (!remember(z)) return {FitVerdict::too_old};
  Fit fit = replay(slot_of(z.stamp), &z);
  fit.verdict = judge(z, fit.verdict);
  return fit;
}

template <class Filter>
void OutOfSequenceFilter<Filter>::start(const Vec3<double>& p, double psi, const Mat<4, 4>& P) noexcept {
  forget();
  count_ = 0;  // the earlier samples cannot be replayed
  state_ = filter_.begin(p, psi, P, last_);
  known_ = true;
  begun_ = last_accepted_ = now_;
}

template <class Filter>
void OutOfSequenceFilter<Filter>::forget() noexcept {
  known_ = false;
  measured_.clear();
  pending_.clear();
  candidates_.clear();
  contradictions_.clear();
  turned_.clear();
}

template <class Filter>
PoseEstimate OutOfSequenceFilter<Filter>::estimate() const noexcept {
  if (!known_) return {};
  PoseEstimate estimate = filter_.read(state_, last_);
  estimate.stamp = now_;
  estimate.last_accepted = last_accepted_;
  return estimate;
}

/// Index of the sample that contains a stamp of the memory.
template <class Filter>
std::size_t OutOfSequenceFilter<Filter>::slot_of(double stamp) const noexcept {
  std::size_t slot = count_ - 1;
  while (slot > 0 && at(slot).from > stamp) --slot;
  return slot;
}

template <class Filter>
void OutOfSequenceFilter<Filter>::drop_slot() noexcept {
  first_ = (first_ + 1) % memory;
  --count_;
  if (count_ > 0) measured_.drop_before(at(0).from);  // the states since then include it
}

template <class Filter>
bool OutOfSequenceFilter<Filter>::remember(const Measurement& z) noexcept {
  if (measured_.is_full()) {
    // Make room for one: keep no state before the oldest measurement.
    const double oldest = measured_.begin()->stamp;
    while (count_ > 1 && at(0).from <= oldest) drop_slot();
    if (measured_.is_full() || z.stamp < at(0).from) return false;
  }
  measured_.insert(z);
  return true;
}

template <class Filter>
template <int m>
bool OutOfSequenceFilter<Filter>::apply(State& s, const Innovation<m, n>& of, Fit& fit) const noexcept {
  Column<n> e;
  const Gated gated = update(s.P, of, e);
  fit.dimension = m;
  fit.squared = gated.squared;
  if (gated.accepted) filter_.correct(s, e);
  return gated.accepted;
}

template <class Filter>
Fit OutOfSequenceFilter<Filter>::weigh(State& s, const Measurement& z,
                                       const MotionSample& motion) const noexcept {
  const Innovation<4, n> of = filter_.innovation(s, z, motion);
  Fit fit{FitVerdict::rejected};
  const bool heading = z.measures_heading();
  for (int i = z.measures_position() ? 0 : 3; i < (heading ? 4 : 3); ++i)
    fit.y[static_cast<std::size_t>(i)] = of.y(i, 0);
  if (!z.measures_position()) {
    if (apply(s, last_one(of), fit)) fit.verdict = FitVerdict::accepted;
    return fit;
  }
  if (heading && apply(s, of, fit)) {
    fit.verdict = FitVerdict::accepted;
  } else if (const Fit both = fit; apply(s, first<3>(of), fit)) {
    fit.verdict = heading ? FitVerdict::accepted_position : FitVerdict::accepted;
  } else if (heading) {
    fit = both;
  }
  return fit;
}

/// Covariance intersection (Julier and Uhlmann 1997): P / w and P_other / (1 - w) are bounds for
/// any correlation of the two errors. Uses the w with the smallest variance; leaves s unchanged if
/// no w reduces the variance.
template <class Filter>
Fit OutOfSequenceFilter<Filter>::intersect(State& s, const Measurement& z,
                                           const MotionSample& motion) const noexcept {
  constexpr std::array weights = {0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995};
  // Variance of the position and of the heading at a lever arm of 1.4 m.
  const auto variance = [&](const State& of) {
    const Mat<4, 4> P = filter_.read(of, motion).P;
    return P(0, 0) + P(1, 1) + P(2, 2) + 2.0 * P(3, 3);
  };
  const State before = s;
  double least = variance(before);
  Fit best{FitVerdict::rejected};
  for (const double w : weights) {
    State trial = before;
    trial.P = (1 / w) * trial.P;
    Measurement bounded = z;
    bounded.other_error = OtherError::fresh;
    bounded.P_other = (1 / (1 - w)) * z.P_other;
    const Fit fit = weigh(trial, bounded, motion);
    if (best.verdict == FitVerdict::rejected || fit.verdict == FitVerdict::accepted) best = fit;
    if (fit.verdict == FitVerdict::rejected || variance(trial) >= least) continue;
    least = variance(trial);
    s = trial;
  }
  return best;
}

/// Propagates s from the start of a slot to its end, with the measurements in it.
/// @return fit of the watched measurement
template <class Filter>
Fit OutOfSequenceFilter<Filter>::run(const Slot& slot, State& s, const Measurement* watched) noexcept {
  Fit seen;
  double t = slot.from;
  for (const Measurement* z = measured_.from(slot.from); z != measured_.end() && z->stamp < slot.until; ++z) {
    filter_.advance(s, slot.motion, z->stamp - t);
    t = z->stamp;
    filter_.receive(s, *z);
    const Fit one =
        z->other_error == OtherError::unknown ? intersect(s, *z, slot.motion) : weigh(s, *z, slot.motion);
    if (watched != nullptr && z->stamp == watched->stamp && z->source == watched->source) seen = one;
  }
  filter_.advance(s, slot.motion, slot.until - t);
  filter_.end(s, slot.motion);
  if (const double gap = slot.motion.t - slot.from; gap > 1e-6) filter_.blur(s, gap);
  return seen;
}

/// Repeats all updates from the start of a slot to the present.
template <class Filter>
Fit OutOfSequenceFilter<Filter>::replay(std::size_t from, const Measurement* watched) noexcept {
  state_ = at(from).state;
  Fit seen;
  for (std::size_t i = from; i < count_; ++i) {
    at(i).state = state_;
    const Fit one = run(at(i), state_, i == from ? watched : nullptr);
    if (i == from) seen = one;
  }
  return seen;
}

template <class Filter>
DeadReckoning OutOfSequenceFilter<Filter>::dead_reckoning_at(const Slot& slot, double stamp) const noexcept {
  DeadReckoning reckoned = slot.reckoned;
  reckoned.advance(slot.motion, stamp - slot.from);
  return reckoned;
}

template <class Filter>
PoseHypothesis OutOfSequenceFilter<Filter>::meaning(const Measurement& z, const Slot& slot, double psi,
                                                    double psi_variance) const noexcept {
  const Place place = filter_.place_meant(z, psi, psi_variance, slot.motion);
  return {z.stamp, place.p, psi, sqrt(trace(place.P)), sqrt(psi_variance), dead_reckoning_at(slot, z.stamp)};
}

/// Evaluates a measurement while there is no estimate.
template <class Filter>
FitVerdict OutOfSequenceFilter<Filter>::consider(const Measurement& z, std::size_t slot) noexcept {
  const DeadReckoning reckoned = dead_reckoning_at(at(slot), z.stamp);
  if (z.of == Measures::heading) {
    if (z.stamp > compass_.stamp) compass_ = {z.yaw, z.yaw_variance, z.stamp, reckoned};
    return FitVerdict::waiting;
  }
  double psi = z.heading(), variance = z.heading_variance();
  if (!z.measures_heading()) {
    if (std::abs(z.stamp - compass_.stamp) > Agreement::window) return FitVerdict::waiting;
    psi = compass_.psi + wrap(reckoned.psi - compass_.reckoned.psi);
    variance = compass_.variance;
  }
  if (candidates_.add(meaning(z, at(slot), psi, variance)) < start_) return FitVerdict::waiting;
  begin(z, slot, psi, variance);
  return FitVerdict::started;
}

/// Decides on a restart after a measurement was applied or rejected.
template <class Filter>
FitVerdict OutOfSequenceFilter<Filter>::judge(const Measurement& z, FitVerdict verdict) noexcept {
  const bool heading = z.measures_heading();
  if (verdict != FitVerdict::rejected) {
    last_accepted_ = std::max(last_accepted_, z.stamp);
    if (z.measures_position()) contradictions_.clear();
    if (verdict == FitVerdict::accepted && heading) turned_.clear();
    if (verdict == FitVerdict::accepted) return verdict;
  }
  const std::size_t slot = slot_of(z.stamp);
  // Without a measured heading, the estimate's is used, which may be wrong.
  constexpr double unknown_heading = 0.15;  // [rad^2]
  const double psi = heading ? z.heading() : filter_.heading(state_);
  const double variance = heading ? z.heading_variance() : unknown_heading;
  PoseHypothesis hypothesis = meaning(z, at(slot), psi, variance);
  if (verdict == FitVerdict::accepted_position || z.of == Measures::heading) {
    hypothesis.sigma = std::numeric_limits<double>::infinity();  // the position is not in question
    if (turned_.add(hypothesis) < restart_) return verdict;
  } else if (contradictions_.add(hypothesis) < restart_) {
    return verdict;
  }
  if (z.of == Measures::heading) {
    // Only a sighting gives the position that belongs to another heading.
    forget();
    compass_ = {z.yaw, z.yaw_variance, z.stamp, hypothesis.reckoned};
    return FitVerdict::rejected;
  }
  begin(z, slot, psi, variance);
  return FitVerdict::restarted;
}

/// Starts the estimate at the stamp of z, from z alone.
template <class Filter>
void OutOfSequenceFilter<Filter>::begin(const Measurement& z, std::size_t slot, double psi,
                                        double psi_variance) noexcept {
  while (slot-- > 0) drop_slot();
  Slot& begun = at(0);
  begun.reckoned = dead_reckoning_at(begun, z.stamp);
  begun.from = z.stamp;
  begun.state =
      filter_.begin(filter_.place_meant(z, psi, psi_variance, begun.motion), psi, psi_variance, begun.motion);
  filter_.share(begun.state, z, begun.motion);
  measured_.drop_before(std::nextafter(z.stamp, std::numeric_limits<double>::infinity()));
  candidates_.clear();
  contradictions_.clear();
  turned_.clear();
  known_ = true;
  begun_ = z.stamp;
  last_accepted_ = z.stamp;
  replay(0, nullptr);
}

}  // namespace sightline
