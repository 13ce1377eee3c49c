// Access to the plan and the settings of a Newton update.
#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/solver/newton/stages.hpp"
#include "sightline/solver/newton/update.hpp"

namespace sightline::newton {
namespace {

bool is_stage(const Workspace& w, int k, std::span<const double> u) noexcept {
  return k >= 0 && k < w.ocp.horizon().N && u.size() == w.u_out.size();
}

}  // namespace

void planned(const Workspace& w, double time, std::span<double> u) noexcept {
  if (u.size() != w.u_out.size()) return;
  const double stages = (time - w.plan_time) / w.ocp.horizon().h();
  const int k = static_cast<int>(clamp(std::isfinite(stages) ? stages : 0.0, 0.0, w.ocp.horizon().N - 1.0));
  for (int a = 0; a < static_cast<int>(w.ocp.agent_bodies().size()); ++a) {
    const Layout::View from = w.groups.layout().u(a);
    const std::size_t to = at(w.ocp.team().input_offset(w.ocp.agent_bodies()[at(a)]));
    for (int i = 0; i < w.groups.layout().part(a).nu; ++i) u[to + at(i)] = w.plan[from(k, i)];
  }
}

void plan(const Workspace& w, int k, std::span<double> u) noexcept {
  if (!is_stage(w, k, u)) return;
  for (int a = 0; a < static_cast<int>(w.ocp.agent_bodies().size()); ++a) {
    const Layout::View from = w.groups.layout().u(a);
    const std::size_t to = at(w.ocp.team().input_offset(w.ocp.agent_bodies()[at(a)]));
    for (int i = 0; i < w.groups.layout().part(a).nu; ++i) u[to + at(i)] = w.u[from(k, i)];
  }
}

void set_plan(Workspace& w, int k, std::span<const double> u) noexcept {
  if (!is_stage(w, k, u)) return;
  detach_plan(w);
  w.has_plan = true;
  w.started = false;
  for (int a = 0; a < static_cast<int>(w.ocp.agent_bodies().size()); ++a) {
    const Layout::View to = w.groups.layout().u(a);
    const std::size_t from = at(w.ocp.team().input_offset(w.ocp.agent_bodies()[at(a)]));
    for (int i = 0; i < w.groups.layout().part(a).nu; ++i) w.u[to(k, i)] = u[from + at(i)];
  }
}

void set_prediction(Workspace& w, const Prediction& prediction) noexcept {
  if (prediction.who.index < 0 || prediction.who.index >= w.ocp.team().bodies() ||
      w.ocp.team().is_agent(prediction.who))
    return;
  Prediction& to = w.predictions[at(prediction.who.index)];
  if (prediction.sights.size() > to.sights.capacity()) return;
  to.time = prediction.time;
  to.h = prediction.h;
  to.sights.assign(prediction.sights.begin(), prediction.sights.end());
}

void set_view_uncertainty(Workspace& w, std::span<const ViewUncertainty> of_bodies) noexcept {
  if (of_bodies.size() != w.predictions.size()) return;
  const Horizon& horizon = w.ocp.horizon();
  for (std::size_t b = 0; b < of_bodies.size(); ++b) {
    for (int k = 0; k < horizon.N; ++k)
      w.couplings->set_uncertainty(static_cast<int>(b), k, of_bodies[b].after(k * horizon.h()));
  }
}

void set_applied(Workspace& w, const AppliedInputs& applied) noexcept {
  if (applied.previous.size() != w.u_out.size() || applied.offset.size() != w.u_out.size()) return;
  w.limits_move = true;
  w.previous.assign(applied.previous.begin(), applied.previous.end());
  w.offset.assign(applied.offset.begin(), applied.offset.end());
  for (int a = 0; a < static_cast<int>(w.x_at.size()); ++a) {
    const BodyId robot = w.ocp.agent_bodies()[at(a)];
    if (applied.lean.size() == w.predictions.size()) w.groups.set_lean(a, applied.lean[at(robot)]);
    if (applied.u_ref.size() == w.u_out.size())
      w.groups.set_u_ref(a, applied.u_ref.data() + w.ocp.team().input_offset(robot));
  }
}

KernelUse kernels(const Workspace& w) {
  KernelUse use = w.groups.kernels();
  const auto add = [&](const std::string& name, const Program& program) {
    use.add(name, w.options.kernels == KernelChoice::compiled_if_there &&
                      find_formula(program, native_width) != nullptr);
  };
  for (const BodyPotential& p : w.potentials) {
    add(p.potential.names[0], p.potential.derivatives);
    for (std::size_t i = 0; i < p.potential.others.size(); ++i)
      add(p.potential.names[i + 1], p.potential.others[i]);
  }
  for (const SwarmPotential& s : w.swarms) add(s.name, s.derivatives);
  return use;
}

void restart(Workspace& w) noexcept {
  w.started = w.has_plan = false;
  detach_plan(w);
  std::fill_n(w.plan, w.groups.layout().u_length, 0.0);
  w.states = States::none;
  for (Prediction& prediction : w.predictions) prediction.sights.clear();
  w.plan_time = 0.0;
}

}  // namespace sightline::newton
