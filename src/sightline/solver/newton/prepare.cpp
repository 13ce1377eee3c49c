// Preparation of an update: measured states; references, limits and other bodies along the horizon.
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/solver/newton/stages.hpp"

namespace sightline::newton {
namespace {

/// References of the robots of a group along the horizon, from their measured headings.
void write_reference_inputs(Workspace& w, int g, double time) noexcept {
  const std::ptrdiff_t lanes = w.groups.layout().width;
  const int stages = w.ocp.horizon().N + 1;
  bool constant = true;
  for (const int a : w.groups.members(g)) {
    const Agent& agent = w.ocp.team().agents()[at(a)];
    constant &= agent.x_ref.is_constant();
    const HeadingErrorLimit& limit = w.heading_limits[at(a)];
    const bool stays = w.started && agent.x_ref.is_constant() && w.turned[at(a)] == 0;
    if (stays && !limit.applies()) continue;
    Group& group = w.groups.group_of(a);
    const int lane = w.groups.layout().place(a).lane;
    const double* const x = &group.x(0, 0, lane);
    double* const x_ref = &group.x_ref(0, 0, lane);
    if (stays && !limit.exceeded(x, x_ref, lanes)) continue;
    const std::ptrdiff_t stage = group.sizes().nx * lanes;
    agent.x_ref.along(time, w.ocp.horizon().h(), stages, agent.model, x_ref, stage, lanes);
    w.turned[at(a)] = limit(x, lanes, x_ref, stages, stage, lanes) ? 1 : 0;
  }
  w.groups.hold_reference(g, constant);
}

}  // namespace

bool accept(Workspace& w, std::span<const double> states) noexcept {
  if (static_cast<int>(states.size()) != w.ocp.nx()) return false;
  std::copy(states.begin(), states.end(), w.x_now.begin());
  const Team& team = w.ocp.team();
  for (int b = 0; b < team.bodies(); ++b) {
    if (!team.model(BodyId{b}).normalise(&w.x_now[at(team.state_offset(BodyId{b}))])) return false;
  }
  if (!w.started) w.groups.rest_at(w.x_now.data(), w.x_at);
  for (int a = 0; a < static_cast<int>(w.ocp.agent_bodies().size()); ++a) {
    Group& group = w.groups.group_of(a);
    const int lane = w.groups.layout().place(a).lane;
    const double* const x = &w.x_now[at(team.state_offset(w.ocp.agent_bodies()[at(a)]))];
    const int own = group.sizes().nx - group.sizes().before;
    for (int i = 0; i < own; ++i) group.x(0, i, lane) = x[i];
    const std::size_t input = at(team.input_offset(w.ocp.agent_bodies()[at(a)]));
    for (int i = 0; i < group.sizes().before; ++i) {
      const std::size_t at_u = input + at(i);
      group.x(0, own + i, lane) = w.previous.empty() ? w.u_out[at_u] : w.previous[at_u] - w.offset[at_u];
    }
  }
  return true;
}

void find_limits(Workspace& w, const Agent& agent, std::size_t input, double time, double ahead) noexcept {
  const std::size_t nu = agent.R.size();
  const std::span<double> low{w.limits.data(), nu}, high{w.limits.data() + nu, nu};
  agent.limits.at(time + ahead, low, high);
  if (w.previous.empty()) return;
  for (std::size_t i = 0; i < nu; ++i) {
    if (!agent.rate_max.empty()) {
      const double reach = agent.rate_max[i] * (w.ocp.horizon().dt + ahead), u = w.previous[input + i];
      const double slow_low = clamp(u - reach, low[i], high[i]),
                   slow_high = clamp(u + reach, low[i], high[i]);
      low[i] = slow_low, high[i] = slow_high;
    }
    low[i] -= w.offset[input + i], high[i] -= w.offset[input + i];
  }
}

void set_time(Workspace& w, double time) noexcept {
  w.time = time;
  const Team& team = w.ocp.team();
  const int N = w.ocp.horizon().N;
  const double h = w.ocp.horizon().h();
  w.groups.each(*w.pool, [&](int g, int) noexcept { write_reference_inputs(w, g, time); });
  for (int a = 0; a < static_cast<int>(w.ocp.agent_bodies().size()); ++a) {
    if (w.started && !w.limits_move) break;
    const Agent& agent = team.agents()[at(a)];
    const int nu = w.groups.layout().part(a).nu;
    const Layout::View u = w.groups.layout().u(a);
    const std::size_t input = at(team.input_offset(w.ocp.agent_bodies()[at(a)]));
    const bool constant = agent.limits.times().size() <= 1 && agent.rate_max.empty();
    for (int k = 0; k < N; ++k) {
      if (k == 0 || !constant) find_limits(w, agent, input, time, k * h);
      for (int i = 0; i < nu; ++i) {
        w.low[u(k, i)] = w.limits[at(i)];
        w.high[u(k, i)] = w.limits[at(nu + i)];
      }
    }
  }
  for (int k = 0; k < N; ++k) w.couplings->set_time(k, time + k * h);
  w.couplings->set_weights(time);
  for (int b = 0; b < team.bodies(); ++b) {
    if (team.is_agent(BodyId{b})) continue;
    Sight<double> sight = team.model(BodyId{b}).sight(&w.x_now[at(team.state_offset(BodyId{b}))], nullptr);
    if (const Prediction& prediction = w.predictions[at(b)]; prediction.holds(time, sight.p)) {
      for (int k = 0; k < N; ++k) w.couplings->set_body(b, k, prediction.at(time, k));
      continue;
    }
    for (int k = 0; k < N; ++k) {
      w.couplings->set_body(b, k, sight);
      sight.p = sight.p + h * sight.v;
    }
  }
  if (!w.limits_move || !w.started) return;
  detach_plan(w);
  // Inputs at a limit that moved are clamped and stay active; inputs away from their limits become
  // free.
  for (int i = 0; i < w.groups.layout().u_length; ++i) {
    w.u[i] = clamp(w.u[i], w.low[i], w.high[i]);
    w.active[i] = w.u[i] == w.low[i] || w.u[i] == w.high[i] ? w.active[i] : 0.0;
  }
}

void start(Workspace& w) noexcept {
  detach_plan(w);
  for (int i = 0; i < w.groups.layout().u_length; ++i) {
    w.u[i] = clamp(w.has_plan ? w.u[i] : 0.0, w.low[i], w.high[i]);
    w.active[i] = 0.0;
  }
  w.all_free = true;
  w.has_plan = w.globalising = false;
  w.watched = infinity;
  w.taken = w.wait = 0;
  w.pause = 1;
  w.extrapolated = false;
  w.krylov.forget();
}

}  // namespace sightline::newton
