#include "sightline/solver/newton/workspace.hpp"

#include <algorithm>

#include "sightline/base.hpp"
#include "sightline/solver/newton/stages.hpp"

namespace sightline::newton {
namespace {

/// Threads pay above a team size; below it the calling thread does all work.
std::shared_ptr<ThreadPool> pool_for(const Ocp& ocp, const NewtonRiccatiOptions& options) {
  const bool pays = static_cast<int>(ocp.agent_bodies().size()) >= NewtonRiccatiOptions::shared_from;
  return thread_pool_if(pays, options.pool);
}

/// Memory for the parts of c that are in use at the same time.
Rows room_for_c(const Layout& layout, const ThreadPool& pool, bool has_swarms) {
  if (has_swarms) return {1, layout.c_length};
  int longest = 0;
  for (const Layout::Part& part : layout.groups)
    longest = std::max(longest, padded(layout.stages * part.nc() * layout.width));
  return {pool.threads(), longest};
}

}  // namespace

Workspace::Workspace(Ocp problem, const NewtonRiccatiOptions& chosen)
    : ocp(std::move(problem)),
      options(check_parameters(chosen, "solver")),
      potentials(
          trace_potentials(ocp, [](const Program& p) { return find_formula(p, native_width) != nullptr; })),
      swarms(trace_swarms(ocp, [](const Program& p) { return find_formula(p, native_width) != nullptr; })),
      influence(influence_graph(potentials, static_cast<int>(ocp.agent_bodies().size()), swarms)),
      groups(ocp, potentials, options.kernels, influence.order),
      couplings(make_couplings(potentials, groups.layout(), ocp.team().bodies(), options.kernels, swarms)),
      pool(pool_for(ocp, options)),
      schedule(static_cast<int>(groups.layout().groups.size()), couplings->coupled_groups(), pool->threads()),
      krylov(groups.layout(), influence, *couplings, pool->threads(), options.max_krylov,
             options.krylov_stop),
      descent(potentials, groups.layout(), influence),
      u_vectors(13, groups.layout().u_length),
      s_vectors(2, groups.layout().s_length),
      c(room_for_c(groups.layout(), *pool, !swarms.empty())),
      u(u_vectors[0]),
      du(u_vectors[1]),
      active(u_vectors[2]),
      H_u(u_vectors[3]),
      low(u_vectors[4]),
      high(u_vectors[5]),
      plan(u_vectors[6]),
      u_start(u_vectors[7]),
      u_next(u_vectors[8]),
      plan_before(u_vectors[9]),
      H_before(u_vectors[10]),
      per_scale(u_vectors[11]),
      scale_2(u_vectors[12]),
      s(s_vectors[0]),
      ds(s_vectors[1]),
      x_now(at(ocp.nx())),
      limits(at(2 * ocp.nu())),
      u_out(at(ocp.nu())),
      raw_u(at(ocp.nu())),
      x_out(1, ocp.nx() * (ocp.horizon().N + 1)) {
  damped.resize(groups.layout().groups.size());
  proposals.resize(groups.layout().groups.size());
  held.resize(groups.layout().groups.size());
  previous.reserve(u_out.size());
  offset.reserve(u_out.size());
  for (const BodyId body : ocp.agent_bodies()) x_at.push_back(ocp.team().state_offset(body));
  for (const Agent& agent : ocp.team().agents()) heading_limits.emplace_back(agent.model, agent.Q, agent.Q_f);
  turned.resize(heading_limits.size());
  for (const Agent& agent : ocp.team().agents()) limits_move |= agent.limits.times().size() > 1;
  std::fill_n(per_scale, groups.layout().u_length, 1.0);
  std::fill_n(scale_2, groups.layout().u_length, 1.0);
  for (int a = 0; a < static_cast<int>(ocp.agent_bodies().size()); ++a) {
    const std::vector<double> scales = input_scales(ocp.team().agents()[at(a)]);
    const Layout::View inputs = groups.layout().u(a);
    for (int k = 0; k < ocp.horizon().N; ++k) {
      for (int i = 0; i < groups.layout().part(a).nu; ++i) {
        per_scale[inputs(k, i)] = 1.0 / scales[at(i)];
        scale_2[inputs(k, i)] = scales[at(i)] * scales[at(i)];
      }
    }
  }
  predictions.resize(at(ocp.team().bodies()));
  for (int b = 0; b < ocp.team().bodies(); ++b) {
    if (!ocp.team().is_agent(BodyId{b})) predictions[at(b)].sights.reserve(at(ocp.horizon().N + 1));
  }
}

std::span<const double> Workspace::predicted_states() noexcept {
  if (states == States::none) return {};
  if (states == States::rolled_out) write_states(*this);
  states = States::written;
  return {x_out[0], at(ocp.nx()) * at(ocp.horizon().N + 1)};
}

}  // namespace sightline::newton
