#include "sightline/estimate/joint_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/base/refuse.hpp"

namespace sightline {
namespace {

const FilterOptions& checked_joint(const FilterOptions& options, std::size_t robots) {
  options.check();
  if (robots == 0) refuse("a joint filter has no robot, expected at least one");
  return options;
}

}  // namespace

JointFilter::JointFilter(const FilterOptions& options, std::span<const SensorMount> mounts)
    : options_(checked_joint(options, mounts.size())),
      n_(mounts.size() * static_cast<std::size_t>(states)),
      slots_(memory),
      robots_(mounts.size()),
      P_(n_ * n_),
      Gt_(4 * n_),
      Kt_(4 * n_),
      error_(n_),
      doubts_(mounts.size()),
      last_(mounts.size()),
      now_(-std::numeric_limits<double>::infinity()) {
  for (const SensorMount& mount : mounts) filters_.emplace_back(options, mount);
  for (Slot& slot : slots_) {
    slot.motion = last_;
    slot.robots = robots_;
    slot.P = P_;
  }
}

void JointFilter::advance(std::span<const MotionSample> motion) noexcept {
  if (motion.size() != filters_.size()) return;
  const double end = motion[0].t + motion[0].dt;
  for (const MotionSample& u : motion)
    if (!is_usable(u) || u.t != motion[0].t || u.dt != motion[0].dt) return;
  if (end <= now_) return;
  if (count_ == memory) drop_slot();
  Slot& slot = at(count_++);
  std::copy(motion.begin(), motion.end(), slot.motion.begin());
  std::copy(motion.begin(), motion.end(), last_.begin());
  slot.from = std::isfinite(now_) ? now_ : motion[0].t;
  slot.until = now_ = end;
  std::copy(robots_.begin(), robots_.end(), slot.robots.begin());
  std::copy(P_.begin(), P_.end(), slot.P.begin());
  run(slot, slot.until, nullptr);
}

Fit JointFilter::take(int observer, const Measurement& z, int target) noexcept {
  if (observer < 0 || observer >= robots() || target >= robots() || target == observer || !z.is_usable())
    return {FitVerdict::unusable};
  if (z.stamp >= now_) return {FitVerdict::unusable};
  if (count_ == 0 || z.stamp < at(0).from) return {FitVerdict::too_old};
  Heard heard{z.stamp, observer + robots() * z.source, observer, target < 0 ? anchor : target, z};
  heard.z.other_error = OtherError::fresh;
  if (heard_.has(heard)) return {FitVerdict::repeated};
  Fit fit;
  if (robot(observer).known) {
    if (!remember(heard)) return {FitVerdict::too_old};
    fit = replay(&heard, slot_of(z.stamp));
  }
  fit.verdict = judge(heard, fit.verdict);
  return fit;
}

PoseEstimate JointFilter::estimate(int i) const noexcept {
  const auto place = static_cast<std::size_t>(i);
  const Robot& of = robots_[place];
  if (!of.known) return {};
  PoseEstimate estimate = filters_[place].read(of.state, last_[place]);
  estimate.stamp = now_;
  estimate.last_accepted = of.last_accepted;
  estimate.P = covariance(i, i);
  return estimate;
}

Mat<4, 4> JointFilter::covariance(int i, int j) const noexcept {
  Mat<4, 4> block_ij;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < 4; ++b) block_ij.row[a][b] = P_[(row(i) + a) * n_ + row(j) + b];
  return block_ij;
}

std::size_t JointFilter::slot_of(double stamp) noexcept {
  std::size_t slot = count_ - 1;
  while (slot > 0 && at(slot).from > stamp) --slot;
  return slot;
}

void JointFilter::drop_slot() noexcept {
  first_ = (first_ + 1) % memory;
  --count_;
  if (count_ > 0) heard_.drop_before(at(0).from);  // it is in the states since
}

bool JointFilter::remember(const Heard& heard) noexcept {
  if (heard_.is_full()) {
    // Room for one: no state before the oldest is kept.
    const double oldest = heard_.begin()->stamp;
    while (count_ > 1 && at(0).from <= oldest) drop_slot();
    if (heard_.is_full() || heard.stamp < at(0).from) return false;
  }
  heard_.insert(heard);
  return true;
}

/// Over dt [s] of a sample.
void JointFilter::move(const Slot& slot, double dt) noexcept {
  if (!(dt > 0)) return;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    robots_[i].reckoned.advance(slot.motion[i], dt);
    if (!robots_[i].known) continue;
    const HeadingTransition step = filters_[i].move(robots_[i].state, slot.motion[i], dt);
    const std::size_t at_i = i * static_cast<std::size_t>(states);
    const auto place = [](int k) { return static_cast<std::size_t>(k); };
    step.rows(static_cast<int>(n_), [&](int a, int j) -> double& { return P(at_i + place(a), place(j)); });
    step.rows(static_cast<int>(n_), [&](int a, int j) -> double& { return P(place(j), at_i + place(a)); });
    step.add_noise(options_, [&](int a, int b) -> double& { return P(at_i + place(a), at_i + place(b)); });
  }
}

/// A sighting of a target in here, with the pose that it is supposed to have.
Measurement JointFilter::completed(const Heard& heard) const noexcept {
  Measurement z = heard.z;
  if (heard.target == anchor || z.of != Measures::sighting) return z;
  const HeadingFilter::State& target = robots_[static_cast<std::size_t>(heard.target)].state;
  z.p_other = target.p, z.psi_other = target.psi, z.P_other = {};
  return z;
}

Fit JointFilter::weigh(const Heard& heard, const Slot& slot) noexcept {
  const auto i = static_cast<std::size_t>(heard.robot);
  Fit fit{FitVerdict::rejected};
  const bool of_robot = heard.target != anchor && heard.z.of == Measures::sighting;
  if (!robots_[i].known || (of_robot && !robot(heard.target).known)) return fit;
  const Measurement z = completed(heard);
  HeadingFilter::State s = robots_[i].state;
  s.P(3, 3) = P(row(heard.robot) + 3, row(heard.robot) + 3);
  const Innovation<4, states> of = filters_[i].innovation(s, z, slot.motion[i]);
  // Expected is R_GV^T (p_target - p), and the yaw psi_target - psi.
  Mat<4, 4> H_target;
  if (of_robot) {
    set_block(H_target, 0, 0, turn_z(-s.psi));
    H_target(3, 3) = -1.0;
  }
  const bool heading = z.measures_heading();
  for (int a = z.measures_position() ? 0 : 3; a < (heading ? 4 : 3); ++a)
    fit.y[static_cast<std::size_t>(a)] = of.y(a, 0);
  if (!z.measures_position()) {
    if (apply<1>(heard, last_one(of), {}, fit)) fit.verdict = FitVerdict::accepted;
    return fit;
  }
  if (heading && apply<4>(heard, of, H_target, fit)) {
    fit.verdict = FitVerdict::accepted;
  } else if (const Fit both = fit; apply<3>(heard, first<3>(of), block<3, 4>(H_target, 0, 0), fit)) {
    fit.verdict = heading ? FitVerdict::accepted_position : FitVerdict::accepted;
  } else if (heading) {
    fit = both;
  }
  return fit;
}

/// As update() of kalman.hpp, over the robots that see and are seen.
template <int m>
bool JointFilter::apply(const Heard& heard, const Innovation<m, states>& of, const Mat<m, 4>& H_target,
                        Fit& fit) noexcept {
  const std::size_t own = row(heard.robot), seen = heard.target == anchor ? own : row(heard.target);
  const auto place = [](int k) { return static_cast<std::size_t>(k); };
  const auto Gt = [&](int a, std::size_t j) -> double& { return Gt_[place(a) * n_ + j]; };
  const auto Kt = [&](int a, std::size_t j) -> double& { return Kt_[place(a) * n_ + j]; };
  // H times a column of a matrix, by its entries.
  const auto H_times = [&](int a, const auto& entry) {
    double sum = 0.0;
    for (int k = 0; k < states; ++k) sum += of.H(a, k) * entry(own + place(k));
    for (int k = 0; k < 4; ++k) sum += H_target(a, k) * entry(seen + place(k));
    return sum;
  };
  for (int a = 0; a < m; ++a)
    for (std::size_t j = 0; j < n_; ++j) Gt(a, j) = H_times(a, [&](std::size_t l) { return P(l, j); });
  Mat<m, m> S = of.R;
  for (int a = 0; a < m; ++a)
    for (int b = 0; b < m; ++b) S(a, b) += H_times(b, [&](std::size_t l) { return Gt(a, l); });
  const Cholesky<m> factor(S);
  fit.dimension = m;
  fit.squared = mahalanobis(of.y, S);
  if (!factor.positive || !(fit.squared <= chi_squared_gate<m>)) return false;

  const Mat<m, m> inverse = factor.solve(identity<m>());
  for (std::size_t j = 0; j < n_; ++j) {
    error_[j] = 0.0;
    for (int a = 0; a < m; ++a) {
      double sum = 0.0;
      for (int b = 0; b < m; ++b) sum += inverse(a, b) * Gt(b, j);
      Kt(a, j) = sum;
      error_[j] += sum * of.y(a, 0);
    }
  }
  // (1 - K H) P (1 - K H)^T + K R K^T, a row at a time.
  for (std::size_t i = 0; i < n_; ++i) {
    for (int a = 0; a < m; ++a)
      for (std::size_t j = 0; j < n_; ++j) P(i, j) -= Kt(a, i) * Gt(a, j);
    std::array<double, static_cast<std::size_t>(m)> c;
    for (int a = 0; a < m; ++a) {
      double sum = H_times(a, [&](std::size_t l) { return P(i, l); });
      for (int b = 0; b < m; ++b) sum -= of.R(a, b) * Kt(b, i);
      c[place(a)] = sum;
    }
    for (int a = 0; a < m; ++a)
      for (std::size_t j = 0; j < n_; ++j) P(i, j) -= c[place(a)] * Kt(a, j);
  }
  correct();
  return true;
}

/// By error_; what HeadingFilter::correct() does to its covariance, for each robot.
void JointFilter::correct() noexcept {
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (!robots_[i].known) continue;
    const std::size_t from = i * static_cast<std::size_t>(states);
    Column<states> e;
    for (int k = 0; k < states; ++k) e(k, 0) = error_[from + static_cast<std::size_t>(k)];
    filters_[i].correct(robots_[i].state, e);
    const double dx = e(0, 0), dy = e(1, 0);
    for (std::size_t j = 0; j < n_; ++j)
      P(from, j) -= dy * P(from + 3, j), P(from + 1, j) += dx * P(from + 3, j);
    for (std::size_t j = 0; j < n_; ++j)
      P(j, from) -= dy * P(j, from + 3), P(j, from + 1) += dx * P(j, from + 3);
  }
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t j = 0; j < i; ++j) P(i, j) = P(j, i) = 0.5 * (P(i, j) + P(j, i));
}

/// From the beginning of a slot to a time in it, with what was measured before that.
Fit JointFilter::run(const Slot& slot, double until, const Heard* watched) noexcept {
  Fit seen;
  double t = slot.from;
  for (const Heard* h = heard_.from(slot.from); h != heard_.end() && h->stamp < until; ++h) {
    move(slot, h->stamp - t);
    t = h->stamp;
    const Fit one = weigh(*h, slot);
    if (watched != nullptr && h->stamp == watched->stamp && h->source == watched->source) seen = one;
  }
  move(slot, until - t);
  const double gap = slot.motion[0].t - slot.from;
  if (!(gap > 1e-6) || until < slot.until) return seen;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (!robots_[i].known) continue;
    const std::size_t from = i * static_cast<std::size_t>(states);
    for (std::size_t k = 0; k < 3; ++k)
      P(from + k, from + k) += square(0.5 * unmeasured_acceleration * gap * gap);
    P(from + 3, from + 3) += square(0.5 * unmeasured_turning * gap * gap);
  }
  return seen;
}

/// From the beginning of a slot to now.
Fit JointFilter::replay(const Heard* watched, std::size_t from) noexcept {
  std::copy(at(from).robots.begin(), at(from).robots.end(), robots_.begin());
  std::copy(at(from).P.begin(), at(from).P.end(), P_.begin());
  Fit seen;
  for (std::size_t i = from; i < count_; ++i) {
    std::copy(robots_.begin(), robots_.end(), at(i).robots.begin());
    std::copy(P_.begin(), P_.end(), at(i).P.begin());
    const Fit one = run(at(i), at(i).until, i == from ? watched : nullptr);
    if (i == from) seen = one;
  }
  return seen;
}

Meaning JointFilter::meaning(const Heard& heard, double psi, double psi_variance) noexcept {
  const Slot& slot = at(slot_of(heard.stamp));
  const auto i = static_cast<std::size_t>(heard.robot);
  Reckoned reckoned = slot.robots[i].reckoned;
  reckoned.advance(slot.motion[i], heard.stamp - slot.from);
  Measurement z = completed(heard);
  if (heard.target != anchor) z.P_other = covariance(heard.target, heard.target);
  const Place place = filters_[i].place_meant(z, psi, psi_variance, slot.motion[i]);
  return {heard.stamp, place.p, psi, sqrt(trace(place.P)), sqrt(psi_variance), reckoned};
}

/// What a measurement says of the robot's estimate itself, or of where it may begin.
FitVerdict JointFilter::judge(const Heard& heard, FitVerdict verdict) noexcept {
  const auto i = static_cast<std::size_t>(heard.robot);
  Doubts& doubts = doubts_[i];
  const Measurement z = completed(heard);
  const bool begun = robots_[i].known;
  if (begun && verdict != FitVerdict::rejected) {
    robots_[i].last_accepted = std::max(robots_[i].last_accepted, z.stamp);
    if (z.measures_position()) doubts.contradictions.clear();
    if (verdict == FitVerdict::accepted && z.measures_heading()) doubts.turned.clear();
    if (verdict == FitVerdict::accepted) return verdict;
  }
  const bool can_begin =
      z.of == Measures::sighting && z.has_yaw && (heard.target == anchor || robot(heard.target).known);
  if (!can_begin) return begun ? verdict : FitVerdict::waiting;
  Meaning meant = meaning(heard, z.heading(), z.heading_variance());
  if (!begun) {
    if (doubts.candidates.add(meant) < options_.start_sightings) return FitVerdict::waiting;
    begin(heard);
    return FitVerdict::started;
  }
  if (verdict == FitVerdict::accepted_position) {
    meant.sigma = std::numeric_limits<double>::infinity();  // the place is not in question
    if (doubts.turned.add(meant) < options_.restart_sightings) return verdict;
  } else if (doubts.contradictions.add(meant) < options_.restart_sightings) {
    return verdict;
  }
  begin(heard);
  return FitVerdict::restarted;
}

/// A robot begins at the stamp of its sighting, from that alone; the others go on.
void JointFilter::begin(const Heard& heard) noexcept {
  for (std::size_t slot = slot_of(heard.stamp); slot-- > 0;) drop_slot();
  Slot& begun = at(0);
  std::copy(begun.robots.begin(), begun.robots.end(), robots_.begin());
  std::copy(begun.P.begin(), begun.P.end(), P_.begin());
  run(begun, heard.stamp, nullptr);

  const auto i = static_cast<std::size_t>(heard.robot);
  const Measurement z = completed(heard);
  const double psi = z.heading(), variance = z.heading_variance();
  const Place place = filters_[i].place_meant(z, psi, variance, begun.motion[i]);
  const HeadingFilter::State fresh = filters_[i].begin(place, psi, variance, begun.motion[i]);
  const std::size_t own = row(heard.robot);
  for (std::size_t a = own; a < own + static_cast<std::size_t>(states); ++a)
    for (std::size_t j = 0; j < n_; ++j) P(a, j) = P(j, a) = 0.0;
  if (heard.target != anchor) {
    // (p, psi) of the target moves those of the robot: p by p and by the turn of the way between them, psi by
    // psi.
    Mat<4, 4> J = identity<4>();
    set_block(J, 0, 3, column(place.per_turn));
    const std::size_t seen = row(heard.target);
    for (std::size_t j = 0; j < n_; ++j)
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) P(own + a, j) += J.row[a][b] * P(seen + b, j);
    for (std::size_t j = 0; j < n_; ++j)
      for (std::size_t a = 0; a < 4; ++a)
        if (j < own || j >= own + static_cast<std::size_t>(states)) P(j, own + a) = P(own + a, j);
    const Mat<4, 4> inherited = J * covariance(heard.target, heard.target) * transposed(J);
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < 4; ++b) P(own + a, own + b) = inherited.row[a][b];
  }
  for (std::size_t a = 0; a < static_cast<std::size_t>(states); ++a)
    for (std::size_t b = 0; b < static_cast<std::size_t>(states); ++b)
      P(own + a, own + b) += fresh.P.row[a][b];
  robots_[i].state = fresh;
  robots_[i].known = true;
  robots_[i].last_accepted = heard.stamp;
  doubts_[i] = {};

  begun.from = heard.stamp;
  std::copy(robots_.begin(), robots_.end(), begun.robots.begin());
  std::copy(P_.begin(), P_.end(), begun.P.begin());
  heard_.drop_before(heard.stamp);
  replay(nullptr, 0);
}

}  // namespace sightline
