#include "sightline/run/settled.hpp"

#include <algorithm>

#include "sightline/base/index.hpp"
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

Settled settle(const Model& model, std::vector<double> x, std::span<const double> u) {
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

}  // namespace sightline
