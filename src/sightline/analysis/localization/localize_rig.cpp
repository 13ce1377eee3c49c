#include "sightline/analysis/localization/localize_rig.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "sightline/analysis/localization/consistency.hpp"
#include "sightline/base/symmetric.hpp"
#include "sightline/world/rigid_motion.hpp"

namespace sightline {
namespace {

constexpr double in_view_within = 1.0;   // [s]
constexpr double outlier_cost = 60.0;    // of eight coordinates that may be anywhere
constexpr double least_period = 0.0095;  // of steps at samples that jitter about 100 Hz [s]

/// Poses between those of a list in order of time; beyond its ends, the nearest motion goes on for one
/// sample.
class OdometryTrack {
 public:
  explicit OdometryTrack(const std::vector<RigRecording::TimedPose>& all) : all_(all) {}
  RigidPose at(double t) {
    while (next_ + 1 < all_.size() && all_[next_].t < t) ++next_;
    const std::size_t b = std::max<std::size_t>(next_, 1);
    if (b >= all_.size()) return all_.front().pose;
    const auto &from = all_[b - 1], &to = all_[b];
    const double span = to.t - from.t;
    if (!(span > 0)) return to.pose;
    return between(from.pose, to.pose, std::clamp((t - from.t) / span, -1.0, 2.0));
  }

 private:
  const std::vector<RigRecording::TimedPose>& all_;
  std::size_t next_ = 0;
};

/// Turns by a gyroscope whose rate is linear between its samples, and constant beyond them.
class TurnTrack {
 public:
  explicit TurnTrack(const std::vector<RigRecording::TurnRate>& all) : all_(all) {}
  /// The rotation vector of the turn over [from, to], times that rise; empty without a gyroscope.
  std::optional<Vec3<double>> turn(double from, double to) {
    if (all_.empty()) return {};
    Rotation R;
    while (next_ < all_.size() && all_[next_].t <= from) ++next_;
    for (double t = from; t < to;) {
      const double end = next_ < all_.size() ? std::min(to, all_[next_].t) : to;
      R = compose(R, turn_by((0.5 * (end - t)) * (rate(t) + rate(end))));
      if (next_ < all_.size() && end == all_[next_].t) ++next_;
      t = end;
    }
    return rotation_vector(R);
  }

 private:
  /// At a time between the sample before the next one and it.
  Vec3<double> rate(double t) const {
    if (next_ == 0) return all_.front().omega;
    if (next_ == all_.size()) return all_.back().omega;
    const RigRecording::TurnRate &a = all_[next_ - 1], &b = all_[next_];
    return a.omega + ((t - a.t) / (b.t - a.t)) * (b.omega - a.omega);
  }

  const std::vector<RigRecording::TurnRate>& all_;
  std::size_t next_ = 0;
};

/// One instant of the filter.
struct Instant {
  double t = 0.0;
  bool started = false, shown = false, anew = false;
  std::size_t first = 0;       ///< of its sightings
  std::vector<TagFit> fits{};  ///< of its sightings
  // For a smoother.
  RigFilter::Step step{};  ///< that led to it
  RigidPose pose{};        ///< estimate after its sightings
  Column<6> velocity{};
  std::vector<RigidPose> places{};
  std::vector<RigFilter::Forgotten> forgotten{};
  GrowingCovariance before_restart{0};  ///< P after the instant before, if the pose was started anew
};

/// A time to which the filter is propagated, with an estimate or without.
struct RigStop {
  double t = 0.0;
  bool shown = false;
};

/// The way of a filter through a recording. A copy goes on from where it is.
class RigRun {
 public:
  /// @param stops  in order of time; both must outlive this object
  RigRun(const RigRecording& recording, const RigNoise& noise, const std::vector<RigStop>& stops)
      : recording_(recording),
        stops_(stops),
        filter_(recording, noise),
        track_(recording.odometry),
        turns_(recording.turn_rates) {}

  bool done() const { return next_seen_ >= recording_.sightings.size() && next_stop_ >= stops_.size(); }
  const RigFilter& filter() const { return filter_; }

  Instant next(bool smooth) {
    const std::vector<RigRecording::Sighting>& all = recording_.sightings;
    const double seen = next_seen_ < all.size() ? all[next_seen_].t : infinity;
    const RigStop due = next_stop_ < stops_.size() ? stops_[next_stop_] : RigStop{infinity};
    Instant instant{.t = std::min(seen, due.t), .shown = due.shown && due.t <= seen, .first = next_seen_};
    while (next_seen_ < all.size() && all[next_seen_].t == instant.t) ++next_seen_;
    if (due.t == instant.t) ++next_stop_;
    const bool was_started = filter_.started();
    // A restart makes the step that led to it void.
    GrowingCovariance before(0);
    if (smooth && was_started && seen == instant.t) before = filter_.covariance();
    if (was_started) instant.step = propagate(instant.t, smooth);
    last_ = instant.t;
    if (seen == instant.t) {
      instant.fits.resize(next_seen_ - instant.first);
      instant.anew =
          filter_.take({all.data() + instant.first, instant.fits.size()}, instant.fits) && was_started;
      if (filter_.started() && !was_started && !recording_.odometry.empty()) odometry_ = track_.at(instant.t);
      if (smooth) instant.forgotten = filter_.forgotten();
      if (instant.anew) instant.before_restart = std::move(before);
    }
    instant.started = filter_.started();
    instant.pose = filter_.pose(), instant.velocity = filter_.velocity();
    if (smooth) instant.places = filter_.places();
    return instant;
  }

 private:
  RigFilter::Step propagate(double t, bool smooth) {
    const double dt = t - last_;
    const auto turn = turns_.turn(last_, t);
    if (recording_.odometry.empty()) return filter_.coast(turn, dt, smooth);
    const RigidPose there = track_.at(t), motion = inverse(odometry_) * there;
    odometry_ = there;
    return filter_.move(motion, turn, dt, smooth);
  }

  const RigRecording& recording_;
  const std::vector<RigStop>& stops_;
  RigFilter filter_;
  OdometryTrack track_;
  TurnTrack turns_;
  double last_ = 0.0;
  RigidPose odometry_{};
  std::size_t next_seen_ = 0, next_stop_ = 0;
};

/// Backward pass: d is the smoothed state in the frame of the prediction, and S its covariance.
class Smoother {
 public:
  Smoother(const RigFilter& last, RigLocalization& result)
      : result_(result),
        shown_(result.smoothed.size()),
        rig_(last.rig_order()),
        P_(last.covariance()),
        X_(last.pose()),
        v_(last.velocity()),
        places_(last.places()) {}

  /// Goes back over the instants of a run, of which only the starts of its pieces are there.
  void run(std::vector<RigRun> starts, std::size_t piece) {
    std::optional<Instant> after;
    for (; !starts.empty(); starts.pop_back()) {
      std::vector<Instant> all;
      for (RigRun run = starts.back(); all.size() < piece && !run.done();) all.push_back(run.next(true));
      for (; !all.empty() && all.back().started; all.pop_back()) {
        if (after) back(*after, all.back());
        if (all.back().shown) {
          RigLocalization::Estimate& to = result_.smoothed[--shown_];
          to.pose = X_, to.P = P_.block(0, 0);
        }
        after = std::move(all.back());
      }
    }
  }

 private:
  /// Leaves out what came after an estimate of n numbers.
  void shrink(int n) {
    P_ = P_.resized(n);
    places_.resize(size((n - rig_) / 6));
  }

  /// Error of the smoothed state in the frame of an estimate.
  std::vector<double> error_from(const RigidPose& pose, const Column<6>& velocity,
                                 const std::vector<RigidPose>& places) const {
    std::vector<double> d(size(P_.order()));
    const auto put = [&](int row, const Column<6>& twist) {
      for (int i = 0; i < 6; ++i) d[size(row + i)] = twist(i, 0);
    };
    put(0, log_of(X_ * inverse(pose)));
    if (rig_ > 6) put(6, v_ - velocity);
    for (std::size_t k = 0; k < places_.size(); ++k)
      put(rig_ + 6 * static_cast<int>(k), log_of(places_[k] * inverse(places[k])));
    return d;
  }

  /// The place as it was: what comes after depends on it through the other numbers alone,
  ///
  ///   d_T = K d,   P_T. = K P,   P_TT = P_TT' - K P_.T' + K P K^T,   K = P_T.' P'^-1,
  ///
  /// with ' of the filter.
  void remember(const RigFilter::Forgotten& was) {
    const int n = was.P.order(), row = rig_ + 6 * static_cast<int>(was.place), others = n - 6;
    shrink(n);
    const auto other = [&](int i) { return i < row ? i : i + 6; };
    Symmetric P(size(others));
    for (int i = 0; i < others; ++i)
      for (int j = 0; j <= i; ++j) P.at(size(i), size(j)) = was.P(other(i), other(j));
    P.factor();
    const std::vector<double> d = error_from(was.pose, was.velocity, was.places);
    Column<6> xi;
    Mat<6, 6> P_TT = was.P.block(row, row);
    std::vector<std::vector<double>> K, KP;
    for (int i = 0; i < 6; ++i) {
      std::vector<double> with(size(others)), smoothed(size(others));
      for (int j = 0; j < others; ++j) with[size(j)] = was.P(row + i, other(j));
      const std::vector<double> gain = P.solve(std::move(with));
      for (int j = 0; j < others; ++j) {
        xi(i, 0) += gain[size(j)] * d[size(other(j))];
        for (int k = 0; k < others; ++k) smoothed[size(j)] += gain[size(k)] * P_(other(k), other(j));
      }
      K.push_back(gain), KP.push_back(smoothed);
    }
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        for (int k = 0; k < others; ++k)
          P_TT(i, j) +=
              KP[size(i)][size(k)] * K[size(j)][size(k)] - K[size(i)][size(k)] * was.P(other(k), row + j);
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < others; ++j) P_(row + i, other(j)) = P_(other(j), row + i) = KP[size(i)][size(j)];
    make_symmetric(P_TT);
    P_.set(row, row, P_TT);
    places_[was.place] = exp_of(xi) * was.places[was.place];
  }

  void back(const Instant& to, const Instant& from) {
    if (to.anew) {
      // The start has no information about the poses before it; that about the tags is left out.
      X_ = from.pose, v_ = from.velocity, P_ = to.before_restart, places_ = from.places;
      return;
    }
    for (auto was = to.forgotten.rbegin(); was != to.forgotten.rend(); ++was) remember(*was);
    const int n = to.step.n;
    shrink(n);
    std::vector<double> d = error_from(to.step.predicted, to.step.velocity, from.places);
    const auto G = [&](int i, int j) { return to.step.G[size(i * n + j)]; };
    const auto Q = [&](int i, int j) { return to.step.Q[size(i * rig_ + j)]; };
    std::vector<double> less(size(rig_));
    for (int i = 0; i < rig_; ++i)
      for (int j = 0; j < n; ++j) less[size(i)] += G(i, j) * d[size(j)];
    for (int i = 0; i < rig_; ++i) d[size(i)] -= less[size(i)];
    // C P C^T + F^-1 (Q - G_U Q) F^-T.
    multiply_sides(G);
    for (int i = 0; i < rig_; ++i)
      for (int j = 0; j < rig_; ++j) {
        double sum = Q(i, j);
        for (int k = 0; k < rig_; ++k) sum -= G(i, k) * Q(k, j);
        P_(i, j) += sum;
      }
    if (rig_ > 6) undo_velocity(to.step.per_velocity, d);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < i; ++j) P_(i, j) = P_(j, i) = 0.5 * (P_(i, j) + P_(j, i));
    Column<6> xi, xi_v;
    for (int i = 0; i < 6; ++i) xi(i, 0) = d[size(i)], xi_v(i, 0) = rig_ > 6 ? d[size(6 + i)] : 0.0;
    X_ = exp_of(xi) * from.pose, v_ = from.velocity + xi_v;
  }

  template <class Gain>
  void multiply_sides(const Gain& G) {
    const int n = P_.order();
    std::vector<double> rows(size(rig_ * n));
    for (int side = 0; side < 2; ++side) {
      std::fill(rows.begin(), rows.end(), 0.0);
      for (int i = 0; i < rig_; ++i)
        for (int k = 0; k < n; ++k) {
          const double g = G(i, k);
          for (int j = 0; j < n; ++j) rows[size(i * n + j)] += g * (side == 0 ? P_(k, j) : P_(j, k));
        }
      for (int i = 0; i < rig_; ++i)
        for (int j = 0; j < n; ++j) (side == 0 ? P_(i, j) : P_(j, i)) -= rows[size(i * n + j)];
    }
  }

  /// F^-1 on d, and on both sides of P: xi_X -= (d xi_X / d xi_v) xi_v.
  void undo_velocity(const Mat<6, 6>& F, std::vector<double>& d) {
    for (int i = 0; i < 6; ++i)
      for (int k = 0; k < 6; ++k) d[size(i)] -= F(i, k) * d[size(6 + k)];
    P_.add_to_pose(-1.0 * F);
  }

  RigLocalization& result_;
  std::size_t shown_;
  const int rig_;
  GrowingCovariance P_;
  RigidPose X_;
  Column<6> v_;
  std::vector<RigidPose> places_;
};

/// Rotation nearest to a matrix with a positive determinant, by Newton steps of its polar form.
Mat<3, 3> nearest_rotation(Mat<3, 3> A) {
  for (int k = 0; k < 60; ++k) {
    const auto row = [&](int i) { return Vec3<double>{A(i, 0), A(i, 1), A(i, 2)}; };
    const Vec3<double> a = row(0), b = row(1), c = row(2);
    const double det = dot(a, cross(b, c));
    // The rows of A^-T.
    const std::array other = {(1 / det) * cross(b, c), (1 / det) * cross(c, a), (1 / det) * cross(a, b)};
    Mat<3, 3> next;
    for (int i = 0; i < 3; ++i) {
      const Vec3<double> mean = 0.5 * (row(i) + other[size(i)]);
      next(i, 0) = mean.x, next(i, 1) = mean.y, next(i, 2) = mean.z;
    }
    A = next;
  }
  return A;
}

/// The motion that takes the poses b to the poses a best, which count by the inverse of their variance.
RigidPose alignment_of(const std::vector<RigLocalization::Estimate>& a, const std::vector<RigidPose>& b) {
  Vec3<double> middle_a{}, middle_b{};
  std::vector<double> share;
  double whole = 0.0;
  for (const RigLocalization::Estimate& one : a) {
    share.push_back(1 / trace(position_covariance(one)));
    whole += share.back();
  }
  for (double& one : share) one /= whole;
  for (std::size_t k = 0; k < a.size(); ++k)
    middle_a = middle_a + share[k] * a[k].pose.p, middle_b = middle_b + share[k] * b[k].p;
  Mat<3, 3> sum;
  for (std::size_t k = 0; k < a.size(); ++k)
    sum += share[k] * (outer(a[k].pose.p - middle_a, b[k].p - middle_b) +
                       matrix(a[k].pose.R) * transposed(matrix(b[k].R)));
  const Mat<3, 3> R = nearest_rotation(sum);
  return {middle_a - R * middle_b, rotation_from(R)};
}

template <class Wanted>
RigAccuracy accuracy_of(const std::vector<RigLocalization::Estimate>& all,
                        const std::vector<RigidPose>& reference, const Wanted& wanted) {
  RigAccuracy of;
  double squares = 0.0, turns = 0.0, most = 0.0, variance = 0.0, sum = 0.0;
  std::vector<double> nees;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (!wanted(all[k])) continue;
    const RigidPose& is = reference[k];
    const double error = norm(is.p - all[k].pose.p);
    const RigidPose off = is * inverse(all[k].pose);
    squares += square(error), most = std::max(most, error);
    turns += square(norm(rotation_vector(off.R)));
    variance += trace(position_covariance(all[k]));
    nees.push_back(mahalanobis(log_of(off), all[k].P));
    sum += nees.back();
  }
  of.samples = nees.size();
  if (of.samples == 0) return of;
  const auto n = static_cast<double>(of.samples);
  of.rmse = sqrt(squares / n), of.max_error = most, of.attitude_rmse = sqrt(turns / n);
  of.sigma = sqrt(variance / n), of.anees = sum / n;
  of.independent = independent_values(nees);
  of.bounds = anees_bounds(6, of.independent);
  return of;
}

/// Estimates are at the times of the reference, or of all samples without one.
std::vector<RigStop> stops_of(const RigRecording& recording) {
  const bool compared = !recording.reference.empty();
  std::vector<RigStop> all;
  const auto add = [&](const auto& samples, double period, bool shown) {
    double last = -infinity;
    for (const auto& one : samples) {
      if (!(one.t - last > period && one.t >= recording.start && one.t <= recording.end)) continue;
      last = one.t;
      all.push_back({one.t, shown});
    }
  };
  add(recording.reference, 0.0, true);
  if (!compared) add(recording.sightings, 0.0, true), add(recording.odometry, least_period, true);
  // A turn over a gap of the sightings would bend the arc, and be known up to full turns alone.
  add(recording.turn_rates, least_period, !compared);
  std::sort(all.begin(), all.end(),
            [](const RigStop& a, const RigStop& b) { return a.t != b.t ? a.t < b.t : a.shown && !b.shown; });
  const auto same = [](const RigStop& a, const RigStop& b) { return a.t == b.t; };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  return all;
}

void count(RigLocalization& result) {
  double squares = 0.0;
  std::size_t gated = 0;
  for (const TagFit& fit : result.fits) {
    if (fit.verdict == TagVerdict::waiting)
      ++result.waiting;
    else if (fit.verdict == TagVerdict::rejected)
      ++result.rejected;
    else
      ++result.accepted;
    if (fit.verdict == TagVerdict::accepted) squares += fit.squared, ++gated;
    result.cost += fit.verdict == TagVerdict::accepted ? std::min(outlier_cost, fit.squared + fit.log_det)
                                                       : outlier_cost;
  }
  if (gated > 0) result.innovation = squares / (8 * static_cast<double>(gated));
}

/// Runs the filter, and the smoother, without a comparison with the reference.
RigLocalization rig_estimates(const RigRecording& recording, const RigNoise& noise, bool smooth) {
  RigLocalization result;
  const std::vector<RigStop> stops = stops_of(recording);
  const std::size_t sightings = recording.sightings.size(), tags = recording.tags.size();
  result.fits.reserve(sightings), result.filter.reserve(stops.size());
  // The smoother's gains are as large as the state, at each instant. So the filter goes over a piece again for
  // the smoother; the copies of the filter, (6 tags)^2 numbers each, take about the memory of a piece.
  const auto piece =
      static_cast<std::size_t>(sqrt(static_cast<double>((sightings + stops.size()) * tags))) + 1;
  const auto begun = std::chrono::steady_clock::now();
  std::vector<RigRun> starts;
  RigRun run(recording, noise, stops);
  std::optional<double> seen_at;
  std::vector<bool> mapped(tags);
  for (std::size_t k = 0; !run.done(); ++k) {
    if (smooth && k % piece == 0) starts.push_back(run);
    const Instant instant = run.next(false);
    if (instant.anew) ++result.restarts;
    bool any = false;
    for (std::size_t i = 0; i < instant.fits.size(); ++i) {
      const TagFit& fit = instant.fits[i];
      result.fits.push_back(fit);
      if (fit.verdict == TagVerdict::waiting || fit.verdict == TagVerdict::rejected) continue;
      any = mapped[recording.sightings[instant.first + i].tag] = true;
    }
    if (seen_at) result.longest_unseen = std::max(result.longest_unseen, instant.t - *seen_at);
    if (any) seen_at = instant.t;
    if (instant.started && instant.shown)
      result.filter.push_back({instant.t, instant.pose, run.filter().covariance().block(0, 0),
                               seen_at ? instant.t - *seen_at : infinity});
  }
  if (!run.filter().started())
    throw std::invalid_argument(
        "no view of a tag with a known pose gives a first pose, expected one sighting of such a tag");
  result.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  result.places = static_cast<std::size_t>(std::count(mapped.begin(), mapped.end(), true));
  if (smooth) {
    result.smoothed = result.filter;
    Smoother(run.filter(), result).run(std::move(starts), piece);
  }
  count(result);
  return result;
}

}  // namespace

Mat<6, 6> pose_covariance(const RigLocalization::Estimate& of) {
  // d p = rho + theta x p.
  Mat<6, 6> L = identity<6>();
  set_block(L, 0, 3, -1.0 * cross_matrix(of.pose.p));
  return L * of.P * transposed(L);
}

Mat<3, 3> position_covariance(const RigLocalization::Estimate& of) {
  return block<3, 3>(pose_covariance(of), 0, 0);
}

RigLocalization localize_rig(const RigRecording& recording, const RigNoise& noise, bool smooth) {
  RigLocalization result = rig_estimates(recording, noise, smooth);
  result.seconds = recording.end - recording.start;
  if (recording.reference.empty() || result.filter.empty()) return result;
  auto at = recording.reference.begin();
  for (const RigLocalization::Estimate& one : result.filter) {
    while (at->t < one.t) ++at;
    result.reference.push_back(at->pose);
  }
  result.alignment = alignment_of(result.filter, result.reference);
  for (RigidPose& pose : result.reference) pose = result.alignment * pose;
  const auto any = [](const RigLocalization::Estimate&) { return true; };
  result.of_filter = accuracy_of(result.filter, result.reference, any);
  result.in_view = accuracy_of(result.filter, result.reference, [](const RigLocalization::Estimate& one) {
    return one.unseen <= in_view_within;
  });
  if (smooth) {
    // The smoother has an alignment of its own.
    std::vector<RigidPose> reference = result.reference;
    const RigidPose more = alignment_of(result.smoothed, reference);
    for (RigidPose& pose : reference) pose = more * pose;
    result.of_smoother = accuracy_of(result.smoothed, reference, any);
  }
  return result;
}

IdentifiedMotion identify_motion(const RigRecording& recording, RigNoise noise) {
  constexpr double widest_factor = 2.0, finest_factor = 1.15, least_decrease = 0.5;
  constexpr int trials_max = 80;
  const bool velocity = recording.odometry.empty(), gyro = !recording.turn_rates.empty();
  const std::array members = {velocity ? &RigNoise::acceleration_walk : &RigNoise::position_walk,
                              gyro       ? &RigNoise::gyro_noise
                              : velocity ? &RigNoise::turn_acceleration_walk
                                         : &RigNoise::rotation_walk};
  IdentifiedMotion found{noise, 0};
  const auto cost_with = [&](const RigNoise& tried) {
    ++found.runs;
    return rig_estimates(recording, tried, false).cost;
  };
  double best = cost_with(noise);
  for (double factor = widest_factor; factor > finest_factor && found.runs < trials_max;) {
    bool better = false;
    for (double RigNoise::*const member : members)
      for (const double by : {factor, 1 / factor}) {
        RigNoise tried = found.noise;
        tried.*member *= by;
        const double cost = cost_with(tried);
        if (!(cost < best - least_decrease)) continue;
        best = cost, found.noise = tried, better = true;
        break;
      }
    if (!better) factor = sqrt(factor);
  }
  return found;
}

}  // namespace sightline
