#include "sightline/run/steady_state.hpp"

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/model/state_roles.hpp"

namespace sightline {

std::vector<char> shown_states(const Model& model) {
  const StateRoles roles = roles_of(model);
  std::vector<char> shown(size(model.nx()));
  const auto mark = [&](int state) {
    if (state >= 0) shown[size(state)] = 1;
  };
  for (const int state : roles.position) mark(state);
  for (const int state : roles.direction) mark(state);
  for (const int state : roles.velocities) mark(state);
  mark(roles.angle);
  return shown;
}

std::vector<double> state_at_rest(const Model& model) {
  std::vector<double> x(size(model.nx()));
  model.at_rest({{0, 0, 1}, {1, 0}}, x.data());
  return x;
}

SteadyState settle(const Model& model, std::vector<double> x, std::span<const double> u) {
  constexpr double step = 1e-3, longest = 5.0, difference = 1e-6;  // [s]
  const std::vector<char> shown = shown_states(model);
  std::vector<double> rate(x.size());
  const bool all_shown = std::find(shown.begin(), shown.end(), 0) == shown.end();
  for (double t = 0; !all_shown && t < longest; t += step) {
    model.f(x.data(), u.data(), rate.data());
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += shown[i] ? 0.0 : step * rate[i];
  }
  model.f(x.data(), u.data(), rate.data());
  std::vector<double> later = x;
  for (std::size_t i = 0; i < x.size(); ++i) later[i] += difference * rate[i];
  const Sight<double> now = model.sight(x.data(), u.data()), then = model.sight(later.data(), u.data());
  const Vec3<double> a = (1 / difference) * (then.v - now.v);
  return {std::move(x), now.v, a, (now.d.x * then.d.y - now.d.y * then.d.x) / difference, now.lean};
}

double top_speed(const Model& model, std::span<const double> u_min, std::span<const double> u_max) {
  constexpr double step = 0.02, time = 60.0;  // [s]
  constexpr double still_grows = 1e-3;        // relative growth of a speed within the last half of the time
  constexpr std::size_t inputs_max = 8;
  const std::size_t nu = u_min.size();
  if (nu > inputs_max) return infinity;
  const int yaw = yaw_input(model);
  double fastest = 0.0;
  std::vector<double> u(nu);
  for (std::size_t corner = 0; corner < std::size_t{1} << nu; ++corner) {
    for (std::size_t i = 0; i < nu; ++i) u[i] = (corner >> i & 1) != 0 ? u_max[i] : u_min[i];
    if (yaw >= 0) {
      if ((corner >> size(yaw) & 1) != 0) continue;
      u[size(yaw)] = std::clamp(0.0, u_min[size(yaw)], u_max[size(yaw)]);
    }
    std::vector<double> x = state_at_rest(model);
    double half = 0.0, whole = 0.0;
    for (double t = 0; t < time; t += step) {
      model.step(x.data(), u.data(), step);
      const double speed = norm(model.sight(x.data(), u.data()).v);
      if (!std::isfinite(speed)) return infinity;
      if (t < time / 2) half = std::max(half, speed);
      whole = std::max(whole, speed);
    }
    if (whole > half * (1 + still_grows)) return infinity;
    fastest = std::max(fastest, whole);
  }
  return fastest;
}

}  // namespace sightline
