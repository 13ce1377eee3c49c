#include "sightline/judge/tracking_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "sightline/base.hpp"

namespace sightline {
namespace {

bool weighs(const Agent& agent, std::span<const int> states) {
  return std::any_of(states.begin(), states.end(), [&](int k) { return k >= 0 && agent.Q[size(k)] > 0; });
}

}  // namespace

bool tracks_position(const Agent& agent, const StateRoles& roles) { return weighs(agent, roles.position); }
bool tracks_heading(const Agent& agent, const StateRoles& roles) {
  return weighs(agent, roles.direction) || weighs(agent, std::array{roles.angle});
}

TrackingError::TrackingError(const Model& model, double from)
    : roles_(roles_of(model)), from_(from), x_ref_(size(model.nx())) {}

void TrackingError::add(const Agent& agent, double time, const Sight<double>& seen) {
  const bool to_place = tracks_position(agent, roles_), to_heading = tracks_heading(agent, roles_);
  if (!(to_place || to_heading) || time < from_ - same_time) return;
  agent.x_ref(time, agent.model, x_ref_);
  const Sight<double> wanted = agent.model.sight(x_ref_.data(), agent.u_ref.data());
  const Vec2<double> d = wanted.d;
  if (to_heading && !(d.x == 0 && d.y == 0)) {
    const double error =
        atan2(d.x * seen.d.y - d.y * seen.d.x, d.x * seen.d.x + d.y * seen.d.y);  // the shorter way around
    heading_squares_ += square(error);
    ++headings_;
  }
  if (!to_place) return;
  const Vec3<double> e = seen.p - wanted.p;
  squares_ += dot(e, e);
  sum_ = sum_ + e;
  ++places_;
}

// Without samples all results are 0 / 0 = NaN.
double TrackingError::rms_position() const { return std::sqrt(squares_ / static_cast<double>(places_)); }
double TrackingError::offset() const { return norm(sum_) / static_cast<double>(places_); }
double TrackingError::rms_rest() const {
  const double mean_square = squares_ / static_cast<double>(places_), offset2 = square(offset());
  return std::sqrt(mean_square - std::min(mean_square, offset2));
}
double TrackingError::rms_heading() const {
  return std::sqrt(heading_squares_ / static_cast<double>(headings_));
}

}  // namespace sightline
