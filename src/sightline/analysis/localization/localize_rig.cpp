#include "sightline/analysis/localization/localize_rig.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "sightline/analysis/localization/consistency.hpp"
#include "sightline/world/rigid_motion.hpp"

namespace sightline {
namespace {

constexpr double in_view_within = 1.0;  // [s]
constexpr double outlier_cost = 60.0;   // of eight coordinates that may be anywhere

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

/// What a smoother needs of one instant.
struct Instant {
  RigFilter::Step step{};  ///< that led to it
  RigidPose pose{};        ///< estimate after its sightings
  Column<6> velocity{};
  std::vector<RigidPose> places{};
  std::size_t estimate = 0;  ///< of RigLocalization::filter, if `shown`
  bool shown = false, anew = false;
  GrowingCovariance before_restart{0};  ///< P after the instant before, if the pose was started anew
};

/// Backward pass: d is the smoothed state in the frame of the prediction, and S its covariance.
class Smoother {
 public:
  Smoother(const RigFilter& last, RigLocalization& result)
      : result_(result),
        rig_(last.rig_order()),
        P_(last.covariance()),
        X_(last.pose()),
        v_(last.velocity()),
        places_(last.places()) {}

  void run(const std::vector<Instant>& all) {
    for (std::size_t k = all.size(); k-- > 0;) {
      if (all[k].shown) {
        RigLocalization::Estimate& to = result_.smoothed[all[k].estimate];
        to.pose = X_, to.P = P_.block(0, 0);
      }
      if (k > 0) back(all[k], all[k - 1]);
    }
  }

 private:
  void back(const Instant& to, const Instant& from) {
    const int n = to.step.n;
    P_ = P_.resized(n);
    places_.resize(size((n - rig_) / 6));
    if (to.anew) {
      // The start says nothing about the poses before it; what is known of the tags stays out.
      X_ = from.pose, v_ = from.velocity, P_ = to.before_restart, places_ = from.places;
      return;
    }
    std::vector<double> d(size(n));
    const auto put = [&](int row, const Column<6>& twist) {
      for (int i = 0; i < 6; ++i) d[size(row + i)] = twist(i, 0);
    };
    put(0, log_of(X_ * inverse(to.step.predicted)));
    if (rig_ > 6) put(6, v_ - to.step.velocity);
    for (std::size_t k = 0; k < places_.size(); ++k)
      put(rig_ + 6 * static_cast<int>(k), log_of(places_[k] * inverse(from.places[k])));
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
    for (int side = 0; side < 2; ++side)
      for (int j = 0; j < P_.order(); ++j)
        for (int i = 0; i < 6; ++i) {
          double sum = 0.0;
          for (int k = 0; k < 6; ++k) sum += F(i, k) * (side == 0 ? P_(6 + k, j) : P_(j, 6 + k));
          (side == 0 ? P_(i, j) : P_(j, i)) -= sum;
        }
  }

  RigLocalization& result_;
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

/// Times of the estimates.
std::vector<double> shown_times(const RigRecording& recording) {
  std::vector<double> times;
  for (const auto& one : recording.reference) times.push_back(one.t);
  if (times.empty()) {
    for (const auto& one : recording.sightings) times.push_back(one.t);
    for (const auto& one : recording.odometry) times.push_back(one.t);
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
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

}  // namespace

Mat<3, 3> position_covariance(const RigLocalization::Estimate& of) {
  // d p = rho + theta x p.
  Mat<3, 6> L;
  set_block(L, 0, 0, identity<3>());
  set_block(L, 0, 3, -1.0 * cross_matrix(of.pose.p));
  return L * of.P * transposed(L);
}

RigLocalization localize_rig(const RigRecording& recording, const RigNoise& noise, bool smooth) {
  RigLocalization result;
  RigFilter filter(recording, noise);
  OdometryTrack track(recording.odometry);
  const std::vector<double> shown = shown_times(recording);
  const std::vector<RigRecording::Sighting>& all = recording.sightings;
  result.fits.resize(all.size());
  std::vector<Instant> instants;
  std::optional<double> last, seen_at;
  RigidPose odometry{};
  std::size_t next_seen = 0, next_shown = 0;
  while (next_seen < all.size() || next_shown < shown.size()) {
    const double seen = next_seen < all.size() ? all[next_seen].t : infinity;
    const double due = next_shown < shown.size() ? shown[next_shown] : infinity;
    const double now = std::min(seen, due);
    const std::size_t first = next_seen;
    while (next_seen < all.size() && all[next_seen].t == now) ++next_seen;
    Instant instant;
    if (filter.started()) {
      const double dt = now - *last;
      if (filter.has_velocity()) {
        instant.step = filter.coast(dt, smooth);
      } else {
        const RigidPose there = track.at(now);
        instant.step = filter.move(inverse(odometry) * there, dt, smooth);
        odometry = there;
      }
    }
    last = now;
    if (seen == now) {
      const bool was_started = filter.started();
      const GrowingCovariance before = smooth && was_started ? filter.covariance() : GrowingCovariance(0);
      const std::span<TagFit> fits(result.fits.data() + first, next_seen - first);
      instant.anew = filter.take({all.data() + first, next_seen - first}, fits) && was_started;
      if (instant.anew) ++result.restarts, instant.before_restart = before;
      if (filter.started() && !was_started && !filter.has_velocity()) odometry = track.at(now);
      const bool any = std::any_of(fits.begin(), fits.end(), [](const TagFit& fit) {
        return fit.verdict != TagVerdict::waiting && fit.verdict != TagVerdict::rejected;
      });
      if (any) {
        if (seen_at) result.longest_unseen = std::max(result.longest_unseen, now - *seen_at);
        seen_at = now;
      }
    }
    if (due == now) ++next_shown;
    if (!filter.started()) continue;
    if (due == now) {
      instant.shown = true, instant.estimate = result.filter.size();
      result.filter.push_back(
          {now, filter.pose(), filter.covariance().block(0, 0), seen_at ? now - *seen_at : infinity});
    }
    if (smooth) {
      instant.pose = filter.pose(), instant.velocity = filter.velocity(), instant.places = filter.places();
      instants.push_back(std::move(instant));
    }
  }
  if (!filter.started())
    throw std::invalid_argument(
        "no view of a tag with a known pose gives a first pose, expected one sighting of such a tag");
  result.places = filter.places().size();
  if (smooth) {
    result.smoothed = result.filter;
    Smoother(filter, result).run(instants);
  }
  count(result);
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
  constexpr double first_factor = 2.0, last_factor = 1.15, least_gain = 0.5;
  constexpr int runs_max = 80;
  const bool velocity = recording.odometry.empty();
  const std::array members = {velocity ? &RigNoise::acceleration_walk : &RigNoise::position_walk,
                              velocity ? &RigNoise::turn_acceleration_walk : &RigNoise::rotation_walk};
  IdentifiedMotion found{noise, 0};
  const auto cost_with = [&](const RigNoise& tried) {
    ++found.runs;
    return localize_rig(recording, tried, false).cost;
  };
  double best = cost_with(noise);
  for (double factor = first_factor; factor > last_factor && found.runs < runs_max;) {
    bool better = false;
    for (double RigNoise::*const member : members)
      for (const double by : {factor, 1 / factor}) {
        RigNoise tried = found.noise;
        tried.*member *= by;
        const double cost = cost_with(tried);
        if (!(cost < best - least_gain)) continue;
        best = cost, found.noise = tried, better = true;
        break;
      }
    if (!better) factor = sqrt(factor);
  }
  return found;
}

}  // namespace sightline
