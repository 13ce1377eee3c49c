// Results of an update.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/solver/newton/stages.hpp"
#include "sightline/solver/newton/update.hpp"

namespace sightline::newton {

Deadline deadline(const Workspace& w) noexcept {
  constexpr double longest = 1e6;  // [s], effectively no deadline
  const std::chrono::duration<double> given(std::min(w.options.deadline, longest));
  return {w.begin + std::chrono::duration_cast<Clock::duration>(given), w.options.deadline > 0};
}

bool late(const Workspace& w) noexcept { return deadline(w).passed(); }

void write_inputs(Workspace& w) noexcept {
  for (int a = 0; a < static_cast<int>(w.ocp.agent_bodies().size()); ++a) {
    const Layout::View u = w.groups.layout().u(a);
    const std::size_t to = at(w.ocp.team().input_offset(w.ocp.agent_bodies()[at(a)]));
    for (int i = 0; i < w.groups.layout().part(a).nu; ++i) {
      w.u_out[to + at(i)] = w.u[u(0, i)];
      w.raw_u[to + at(i)] = w.u_next[u(0, i)] + w.du[u(0, i)];
    }
  }
}

void write_states(Workspace& w) noexcept {
  const Team& team = w.ocp.team();
  const int N = w.ocp.horizon().N;
  w.groups.each(*w.pool,
                [&](int g, int) noexcept { w.groups.copy_states(g, w.x_out[0], w.ocp.nx(), w.x_at); });
  for (int b = 0; b < team.bodies(); ++b) {
    if (team.is_agent(BodyId{b})) continue;
    const std::size_t from = at(team.state_offset(BodyId{b}));
    const Prediction& prediction = w.predictions[at(b)];
    const bool is_predicted = prediction.holds(w.time, {w.x_now[from], w.x_now[from + 1], w.x_now[from + 2]});
    for (int k = 0; k <= N; ++k) {
      double* const to = w.x_out[0] + from + at(k * w.ocp.nx());
      const std::size_t nx = at(team.model(BodyId{b}).nx());
      if (is_predicted && k > 0) {
        write_body(prediction.at(w.time, k), {to, nx});
        continue;
      }
      std::copy_n(&w.x_now[from], nx, to);
      for (std::size_t i = 0; i < 3; ++i) to[i] += k * w.ocp.horizon().h() * to[3 + i];
    }
  }
}

Solution fall_back(Workspace& w, double time, Status status) noexcept {
  const Team& team = w.ocp.team();
  w.started = false;
  planned(w, time, w.raw_u);
  for (int a = 0; a < static_cast<int>(w.ocp.agent_bodies().size()); ++a) {
    const int nu = w.groups.layout().part(a).nu;
    const std::size_t to = at(team.input_offset(w.ocp.agent_bodies()[at(a)]));
    find_limits(w, team.agents()[at(a)], to, std::isfinite(time) ? time : w.plan_time, 0.0);
    for (int i = 0; i < nu; ++i) {
      w.u_out[to + at(i)] = clamp(w.raw_u[to + at(i)], w.limits[at(i)], w.limits[at(nu + i)]);
    }
  }
  return {.u = w.u_out,
          .raw_u = w.raw_u,
          .x = {},
          .status = status,
          .elapsed = std::chrono::duration<double>(Clock::now() - w.begin).count()};
}

}  // namespace sightline::newton
