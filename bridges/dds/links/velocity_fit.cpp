#include "bridges/dds/links/velocity_fit.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "sightline/base/now.hpp"

namespace sightline::dds {
namespace {

double fit_heading(const Quaternion& q) {
  if (q == no_attitude) return 0.0;
  const Vec2<double> d = heading(rotation(q));
  return std::atan2(d.y, d.x);
}

}  // namespace

VelocityFit::Outcome VelocityFit::take(const Vec3<double>& p, const Quaternion& q, Nanoseconds stamp,
                                       Motion& motion) noexcept {
  Values at = {p.x, p.y, p.z, fit_heading(q)};
  if (count_ > 0) {
    // Unwraps the heading: the shorter way from the last one.
    at[3] = newest_.at[3] + std::remainder(at[3] - newest_.at[3], 2 * std::numbers::pi);
    assert(stamp > newest_.stamp && "stamps rise");
    const Nanoseconds since = stamp - newest_.stamp;
    const bool goes_on = since < silence;
    if (goes_on && !is_near(at, to_seconds(since)) && ++outside_ <= most_outside) return Outcome::jump;
    if (!goes_on || outside_ > most_outside) begin();
  }
  outside_ = 0;
  newest_ = {stamp, at};
  if (count_ == 0 || stamp - pose(0).stamp >= densest) {
    poses_[next_] = newest_;
    next_ = (next_ + 1) % most;
    count_ = std::min(count_ + 1, most);
  }
  const auto is_old = [&](Nanoseconds age) { return age > longest || (age > window && count_ > least); };
  while (count_ > 0 && is_old(stamp - pose(count_ - 1).stamp)) --count_;
  fitted_ = count_ >= least;
  if (!fitted_) return Outcome::too_few;
  fit(stamp);
  motion = {p, q, {slope_[0], slope_[1], slope_[2]}, slope_[3]};
  return Outcome::good;
}

void VelocityFit::begin() noexcept {
  count_ = 0;
  fitted_ = false;
  outside_ = 0;
}

bool VelocityFit::is_near(const Values& at, double dt) const noexcept {
  double off = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double led = newest_.at[i] + (fitted_ ? dt * (slope_[i] + 0.5 * dt * curvature_[i]) : 0.0);
    off = std::hypot(off, at[i] - led);
  }
  const double led = newest_.at[3] + (fitted_ ? dt * slope_[3] : 0.0);
  return off < gate_p + (fitted_ ? 0.0 : gate_v * dt) + gate_a * dt * dt &&
         std::abs(at[3] - led) < gate_turn + gate_turn_a * dt * dt;
}

/// y = A + B u + C (u^2 - (S3/S2) u - S2/n) with u = t - mean(t). The three terms are orthogonal
/// over the poses, so B and C are independent sums.
void VelocityFit::fit(Nanoseconds stamp) noexcept {
  std::array<double, most> u;
  double mean = 0.0;
  const double n = static_cast<double>(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    u[i] = to_seconds(pose(i).stamp - stamp);
    mean += u[i] / n;
  }
  double s2 = 0.0, s3 = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    u[i] -= mean;
    s2 += u[i] * u[i], s3 += u[i] * u[i] * u[i];
  }
  const auto bent = [&](double v) { return v * v - s3 / s2 * v - s2 / n; };
  double qq = 0.0;
  for (std::size_t i = 0; i < count_; ++i) qq += bent(u[i]) * bent(u[i]);
  for (std::size_t k = 0; k < slope_.size(); ++k) {
    double b = 0.0, c = 0.0;
    for (std::size_t i = 0; i < count_; ++i) {
      const double y = pose(i).at[k] - newest_.at[k];
      b += u[i] * y, c += bent(u[i]) * y;
    }
    b /= s2, c /= qq;
    slope_[k] = b + c * (-2 * mean - s3 / s2);  // at the newest, u = -mean
    curvature_[k] = 2 * c;
  }
}

}  // namespace sightline::dds
