#include "sightline/run/feed_forward.hpp"

#include <cmath>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/base/symmetric.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/potentials.hpp"
#include "sightline/run/steady_state.hpp"

namespace sightline {

FeedForward::FeedForward(const Agent& agent)
    : model_(agent.model), u_ref_(agent.u_ref), x_(size(model_.nx())), gain_(u_ref_.size()) {
  const StateRoles roles = roles_of(model_);
  bool needs_heading = false;
  for (const int state : {roles.direction[0], roles.direction[1], roles.angle})
    needs_heading = needs_heading || (state >= 0 && agent.Q[size(state)] > 0);
  using Column = std::array<double, rows>;
  std::vector<Column> columns;  // effects of velocities, then of inputs as fractions of half their range
  const auto add = [&](const SteadyState& more, const SteadyState& less, double by) {
    const Vec3<double> v = (1 / by) * (more.velocity - less.velocity),
                       a = (1 / by) * (more.acceleration - less.acceleration);
    columns.push_back({v.x, v.y, v.z, a.x, a.y, a.z, needs_heading ? (more.turn - less.turn) / by : 0.0});
  };
  for (const int state : roles.velocities) {
    constexpr double by = 0.1;  // [m/s]
    std::vector<double> up = state_at_rest(model_), down = up;
    up[size(state)] += by, down[size(state)] -= by;
    add(settle(model_, up, u_ref_), settle(model_, down, u_ref_), 2 * by);
  }
  const std::size_t velocities = columns.size();
  std::vector<double> reach;
  for (std::size_t k = 0; k < u_ref_.size(); ++k) {
    reach.push_back(0.5 * (agent.limits.u_max().front()[k] - agent.limits.u_min().front()[k]));
    constexpr double part = 0.1;
    std::vector<double> up = u_ref_, down = u_ref_;
    up[k] += part * reach[k], down[k] -= part * reach[k];
    add(settle(model_, state_at_rest(model_), up), settle(model_, state_at_rest(model_), down), 2 * part);
  }
  // (M'M + damping) y = M' e for each unit vector e of v, a and r.  The inputs' part of y
  // is the gain.
  constexpr double damping = 1e-9;
  const auto product = [](const Column& a, const Column& b) {
    double sum = 0.0;
    for (std::size_t r = 0; r < rows; ++r) sum += a[r] * b[r];
    return sum;
  };
  Symmetric A(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) A.at(i, j) = product(columns[i], columns[j]);
    A.at(i, i) += damping;
  }
  A.factor();
  for (std::size_t r = 0; r < rows; ++r) {
    std::vector<double> b;
    for (const Column& column : columns) b.push_back(column[r]);
    const std::vector<double> y = A.solve(std::move(b));
    for (std::size_t k = 0; k < u_ref_.size(); ++k) gain_[k][r] = y[velocities + k] * reach[k];
  }
}

void FeedForward::operator()(const Reference& x_ref, double t, const Vec2<double>& d,
                             std::span<double> u) noexcept {
  const auto pose = [&](double time) -> Pose<double> {
    x_ref(time, model_, x_);
    return model_.sight(x_.data(), u_ref_.data());
  };
  const Pose<double> before = pose(t - difference), now = pose(t), after = pose(t + difference);
  Vec3<double> v = (0.5 / difference) * (after.p - before.p),
               a = (1 / (difference * difference)) * ((after.p - now.p) - (now.p - before.p));
  const double r = (0.5 / difference) * heading_error(before.d, after.d);
  if (model_.turns()) {
    const Vec2<double> v_V = rotate<double>({d.x, -d.y}, {v.x, v.y}),
                       a_V = rotate<double>({d.x, -d.y}, {a.x, a.y});
    v.x = v_V.x, v.y = v_V.y, a.x = a_V.x, a.y = a_V.y;
  }
  for (std::size_t k = 0; k < u_ref_.size(); ++k) {
    const std::array<double, rows>& g = gain_[k];
    const double by = g[0] * v.x + g[1] * v.y + g[2] * v.z + g[3] * a.x + g[4] * a.y + g[5] * a.z + g[6] * r;
    u[k] = std::isfinite(by) ? u_ref_[k] + by : u_ref_[k];
  }
}

}  // namespace sightline
