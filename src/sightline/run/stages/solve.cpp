#include "sightline/run/stages/solve.hpp"

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/loop.hpp"

namespace sightline::stages {

Solve::Solve(const World& world, const Controllers& controllers, const LoopOptions& options, const Period& p)
    : team_(world.team()),
      options_(options),
      warm_up_(options.warm_up),
      use_applied_(options.compensation != nullptr),
      u_min_(p.u.size()),
      u_max_(p.u.size()),
      plan_(p.u.size()) {
  for (const Agent& agent : team_.agents()) use_applied_ |= !agent.rate_max.empty() || !agent.R_rate.empty();
  for (const LatePlan& late : options.late_plans) late.check();
  for (Solver& solver : controllers) {
    const double dt = solver.ocp().horizon().dt;
    if (std::abs(dt - options.period) > 1e-9) {
      throw_invalid("controller {}: horizon.period = {}, expected the loop's {}", controllers_.size(), dt,
                    options.period);
    }
    controllers_.emplace_back(team_, solver, controllers_.size());
  }
  if (options.guard != nullptr && controllers.size() == 1)
    options.guard->set_connectivity(controllers[0].get().connectivity());
  check_steered(p.presence);
}

void Solve::check_steered(const std::vector<Presence>& presence) const {
  std::vector<int> steered_by(presence.size(), -1);
  for (std::size_t c = 0; c < controllers_.size(); ++c) {
    for (const Controller::Member& m : controllers_[c].members) {
      if (m.limits == nullptr) continue;
      int& other = steered_by[size(m.body.index)];
      if (other >= 0) {
        throw_invalid("\"{}\" is steered by controllers {} and {}, expected one", team_.name(m.body), other,
                      c);
      }
      other = static_cast<int>(c);
    }
  }
  for (int i = 0; i < team_.bodies(); ++i) {
    if (presence[size(i)] == Presence::steered && steered_by[size(i)] < 0) {
      throw_invalid("\"{}\" is steered by no controller, expected one whose team has it",
                    team_.name(BodyId{i}));
    }
  }
}

void Solve::run(Period& p) noexcept {
  Sample& sample = *p.sample;
  if (p.outcome.updates == 0) std::fill(p.planned_at.begin(), p.planned_at.end(), p.t);
  if (sample.has_path) begin_path(p);
  std::copy(p.u.begin(), p.u.end(), sample.raw_u.begin());  // for robots without a controller
  const std::span<Controller> requested = controllers();
  for (std::size_t c = 0; c < requested.size(); ++c) {
    Controller& controller = requested[c];
    const int index = static_cast<int>(c);
    const std::int64_t before = p.allocations();
    const Solution solution = solve(controller, p);
    command(index, controller, solution, p);
    sample.solvers[c] = {solution.status,        solution.residual,        solution.iterations,
                         1e6 * solution.elapsed, p.allocations() - before, solution.neighbours.pairs,
                         controller.answered};
    if (p.outcome.updates > 0 && solution.status != controller.status)
      p.emit({p.t, EventKind::solver_status, index, static_cast<double>(solution.status)});
    controller.status = solution.status;
    const int left_out = solution.neighbours.left_out;
    if (left_out > controller.left_out)
      p.emit({p.t, EventKind::pairs_left_out, index, static_cast<double>(left_out)});
    controller.left_out = left_out == 0 ? 0 : std::max(controller.left_out, left_out);
    if (sample.has_path) write_path(controller, solution, p);
  }
  ++p.outcome.updates;
  if (options_.team_switcher == nullptr) return;
  // Robots without a solver brake, and their plans count as new.
  for (UncontrolledRobot& robot : options_.team_switcher->present().uncontrolled) {
    robot.steer(p.t, *p.met, p.added, u_min_, u_max_, p.u);
    std::copy_n(&p.u[robot.u], robot.nu, &sample.raw_u[robot.u]);
    p.planned_at[size(robot.body.index)] = p.t;
  }
}

void Solve::warm_up(Clock& clock, std::int64_t k) noexcept {
  warm_up_.before(clock, k, [this]() noexcept {
    for (Controller& controller : controllers()) controller.solver->warm_up();
  });
}

std::span<Controller> Solve::controllers() noexcept {
  if (options_.team_switcher == nullptr) return controllers_;
  return {&*options_.team_switcher->present().controller, 1};
}

bool Solve::knows_all() const noexcept {
  return (options_.guard == nullptr || options_.guard->knows_all()) &&
         (options_.localizer == nullptr || options_.localizer->knows_all());
}

/// Passes states, applied inputs, u* and uncertainties to the solver.
void Solve::request(Controller& controller, const Period& p) noexcept {
  controller.gather(team_, *p.met, p.u);
  const Team& team = controller.solver->ocp().team();
  for (std::size_t i = 0; options_.compensation != nullptr && i < controller.members.size(); ++i) {
    const Controller::Member& m = controller.members[i];
    if (m.limits == nullptr) continue;
    options_.compensation->write_reference_inputs(m.body, team.agent(BodyId{static_cast<int>(i)}).x_ref,
                                                  p.t + p.lead,
                                                  std::span<const double>(*p.met).data() + m.world_x,
                                                  std::span(controller.u_ref).subspan(m.ocp_u, m.nu));
  }
  if (use_applied_) controller.set_applied({p.gate.applied(), p.added, p.added_lean});
  if (options_.localizer != nullptr) controller.set_view_uncertainty(options_.localizer->uncertainties());
  controller.requested_at = p.t;
}

/// Runs an update. While a late update is in progress, uses the previous plan's inputs for this
/// time.
Solution Solve::solve(Controller& controller, const Period& p) noexcept {
  Solver& solver = *controller.solver;
  Solution solution{.u = controller.plan, .raw_u = controller.plan, .x = {}};
  controller.answered = false;
  if (!knows_all()) {
    solution.status = Status::invalid_state;
  } else if (!controller.at_work) {
    request(controller, p);
    const auto late = std::find_if(options_.late_plans.begin(), options_.late_plans.end(),
                                   [&](const LatePlan& l) { return l.strikes(p.t); });
    if (late == options_.late_plans.end()) {
      controller.answered = true;
      return solver.solve(p.t + p.lead, controller.states);
    }
    controller.at_work = true;
    controller.done_at = p.t + late->delay;
  }
  if (!controller.at_work) return solution;
  if (p.t >= controller.done_at - same_time) {
    controller.at_work = false;
    controller.answered = true;
    solution = solver.solve(controller.requested_at + p.lead, controller.states);
    solution.u = solution.raw_u = controller.plan;
  } else {
    solution.status = Status::deadline;
  }
  solver.planned(p.t + p.lead, controller.plan);
  return solution;
}

void Solve::command(int index, const Controller& controller, const Solution& solution, Period& p) noexcept {
  const std::size_t nu = size(controller.solver->ocp().nu());
  for (const Controller::Member& m : controller.members) {
    if (m.limits == nullptr) continue;
    const std::span<double> held = std::span(p.u).subspan(m.world_u, m.nu);
    const auto u_min = std::span(u_min_).first(m.nu), u_max = std::span(u_max_).first(m.nu);
    m.limits->at(p.t + p.lead, u_min, u_max);  // the solver's limits
    for (std::size_t i = 0; i < m.nu; ++i) {
      u_min[i] -= p.added[m.world_u + i], u_max[i] -= p.added[m.world_u + i];
    }
    bool good = solution.u.size() == nu;
    for (std::size_t i = 0; good && i < m.nu; ++i) {
      const double u = solution.u[m.ocp_u + i];
      good = u >= u_min[i] && u <= u_max[i];  // false for NaN
    }
    for (std::size_t i = 0; i < m.nu; ++i) {
      if (good) held[i] = solution.u[m.ocp_u + i];
      held[i] = std::clamp(held[i], u_min[i], u_max[i]);
      p.sample->raw_u[m.world_u + i] = solution.raw_u.size() == nu ? solution.raw_u[m.ocp_u + i] : held[i];
    }
    if (good && controller.answered && gives_plan(solution.status))
      p.planned_at[size(m.body.index)] = controller.requested_at;
    if (good) continue;
    ++p.outcome.refused;
    p.emit({p.t, EventKind::input_refused, index, static_cast<double>(m.body.index)});
  }
}

/// Fills the paths with the estimate and the applied inputs, for bodies without a plan.
void Solve::begin_path(const Period& p) const noexcept {
  Sample& sample = *p.sample;
  for (std::size_t i = 0; i < sample.path.size(); ++i) sample.path[i] = (*p.estimate)[i % p.estimate->size()];
  sample.path_time = p.t + p.lead;
  for (std::size_t i = 0; i < sample.path_u.size(); ++i) sample.path_u[i] = p.gate.applied()[i % p.u.size()];
}

void Solve::write_path(const Controller& controller, const Solution& solution, const Period& p) noexcept {
  Sample& sample = *p.sample;
  const Horizon& horizon = controller.solver->ocp().horizon();
  const std::size_t nx = size(controller.solver->ocp().nx()), world_nx = sample.x.size();
  const std::size_t N = size(horizon.N);
  const std::span<const double> planned = solution.x;
  if (planned.size() != (N + 1) * nx || !all_finite(planned)) return;
  // Another controller's horizon may have other stages: interpolate linearly, hold after the last.
  const double ratio = sample.path_step / horizon.h();
  for (std::size_t i = 0; i * world_nx < sample.path.size(); ++i) {
    const double at = std::min(static_cast<double>(i) * ratio, static_cast<double>(N));
    const std::size_t stage = std::min(static_cast<std::size_t>(at), N - 1);
    const double w = at - static_cast<double>(stage);
    const double *from = &planned[stage * nx], *to = from + nx;
    for (const Controller::Member& m : controller.members) {
      for (std::size_t q = 0; q < m.nx; ++q) {
        double& x = sample.path[i * world_nx + m.world_x + q];
        x = (1 - w) * from[m.ocp_x + q] + w * to[m.ocp_x + q];
        if (options_.compensation != nullptr) x += options_.compensation->held()[m.world_x + q];
      }
    }
  }
  const std::size_t world_nu = sample.u.size();
  const std::span<double> u = std::span(plan_).first(size(controller.solver->ocp().nu()));
  for (std::size_t i = 0; i * world_nu < sample.path_u.size(); ++i) {
    controller.solver->planned(sample.path_time + static_cast<double>(i) * sample.path_step, u);
    for (const Controller::Member& m : controller.members) {
      if (m.limits == nullptr) continue;
      for (std::size_t j = 0; j < m.nu; ++j)
        sample.path_u[i * world_nu + m.world_u + j] = u[m.ocp_u + j] + p.added[m.world_u + j];
    }
  }
}

}  // namespace sightline::stages
