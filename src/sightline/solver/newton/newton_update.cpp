#include "sightline/solver/newton/newton_update.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sightline/base/index.hpp"
#include "sightline/base/no_value.hpp"
#include "sightline/base/subnormals.hpp"

namespace sightline {
namespace {

void check(bool holds, std::string_view option, double value, std::string_view expected) {
  if (holds && std::isfinite(value)) return;
  throw std::invalid_argument(fmt::format("solver.{} = {}, expected {}", option, value, expected));
}

NewtonRiccatiOptions checked(const NewtonRiccatiOptions& o) {
  check(o.max_newton_steps >= 1 && o.max_newton_steps <= 1000, "max_newton_steps", o.max_newton_steps,
        "1 to 1000");
  check(o.tolerance > 0, "tolerance", o.tolerance, "> 0 1/s");
  check(o.max_krylov >= 0 && o.max_krylov <= 1000, "max_krylov", o.max_krylov, "0 to 1000");
  check(o.krylov_stop >= 0, "krylov_stop", o.krylov_stop, ">= 0");
  check(o.step_cap > 0, "step_cap", o.step_cap, "> 0");
  check(o.deadline >= 0, "deadline", o.deadline, ">= 0 s");
  check(o.start_steps >= 1 && o.start_steps <= 1000, "start_steps", o.start_steps, "1 to 1000");
  return o;
}

/// Threads pay from some size on; below it all is done by the caller's.
std::shared_ptr<ThreadPool> pool_for(const Ocp& ocp, const NewtonRiccatiOptions& options) {
  const bool pays = static_cast<int>(ocp.agent_bodies().size()) >= NewtonRiccatiOptions::shared_from;
  return thread_pool_if(pays, options.pool);
}

/// Numbers of c that are needed at a time.
Rows room_for_c(const Layout& layout, const ThreadPool& pool, bool has_swarms) {
  if (has_swarms) return {1, layout.c_length};
  int longest = 0;
  for (const Layout::Part& part : layout.groups)
    longest = std::max(longest, padded(layout.stages * part.nc() * layout.width));
  return {pool.threads(), longest};
}

}  // namespace

KernelUse NewtonUpdate::kernels() const {
  KernelUse use = groups_.kernels();
  const auto add = [&](const std::string& name, const Program& program) {
    use.add(name, options_.kernels == KernelChoice::compiled_if_there &&
                      find_formula(program, native_width) != nullptr);
  };
  for (const BodyPotential& p : potentials_) {
    add(p.potential.names[0], p.potential.derivatives);
    for (std::size_t i = 0; i < p.potential.others.size(); ++i)
      add(p.potential.names[i + 1], p.potential.others[i]);
  }
  for (const SwarmPotential& s : swarms_) add(s.name, s.derivatives);
  return use;
}

NewtonUpdate::NewtonUpdate(Ocp ocp, const NewtonRiccatiOptions& options)
    : ocp_(std::move(ocp)),
      options_(checked(options)),
      potentials_(
          trace_potentials(ocp_, [](const Program& p) { return find_formula(p, native_width) != nullptr; })),
      swarms_(trace_swarms(ocp_, [](const Program& p) { return find_formula(p, native_width) != nullptr; })),
      influence_(influence_graph(potentials_, static_cast<int>(ocp_.agent_bodies().size()), swarms_)),
      groups_(ocp_, potentials_, options_.kernels, influence_.order),
      couplings_(
          make_couplings(potentials_, groups_.layout(), ocp_.team().bodies(), options_.kernels, swarms_)),
      pool_(pool_for(ocp_, options_)),
      schedule_(static_cast<int>(groups_.layout().groups.size()), couplings_->coupled_groups(), 5,
                pool_->threads()),
      krylov_(groups_.layout(), influence_, *couplings_, pool_->threads(), options_.max_krylov,
              options_.krylov_stop),
      descent_(potentials_, groups_.layout(), influence_),
      u_vectors_(13, groups_.layout().u_length),
      s_vectors_(2, groups_.layout().s_length),
      c_(room_for_c(groups_.layout(), *pool_, !swarms_.empty())),
      u_(u_vectors_[0]),
      du_(u_vectors_[1]),
      active_(u_vectors_[2]),
      H_u_(u_vectors_[3]),
      low_(u_vectors_[4]),
      high_(u_vectors_[5]),
      plan_(u_vectors_[6]),
      u_start_(u_vectors_[7]),
      u_next_(u_vectors_[8]),
      plan_before_(u_vectors_[9]),
      H_before_(u_vectors_[10]),
      per_scale_(u_vectors_[11]),
      scale_2_(u_vectors_[12]),
      s_(s_vectors_[0]),
      ds_(s_vectors_[1]),
      x_now_(at(ocp_.nx())),
      limits_(at(2 * ocp_.nu())),
      u_out_(at(ocp_.nu())),
      raw_u_(at(ocp_.nu())),
      x_out_(1, ocp_.nx() * (ocp_.horizon().N + 1)) {
  damped_.resize(groups_.layout().groups.size());
  proposals_.resize(groups_.layout().groups.size());
  held_.resize(groups_.layout().groups.size());
  before_.reserve(u_out_.size());
  added_.reserve(u_out_.size());
  for (const BodyId body : ocp_.agent_bodies()) x_at_.push_back(ocp_.team().state_offset(body));
  for (const Agent& agent : ocp_.team().agents())
    heading_limits_.emplace_back(agent.model, agent.Q, agent.Q_f);
  turned_.resize(heading_limits_.size());
  for (const Agent& agent : ocp_.team().agents()) limits_move_ |= agent.limits.times().size() > 1;
  std::fill_n(per_scale_, groups_.layout().u_length, 1.0);
  std::fill_n(scale_2_, groups_.layout().u_length, 1.0);
  for (int a = 0; a < static_cast<int>(ocp_.agent_bodies().size()); ++a) {
    const std::vector<double> scales = input_scales(ocp_.team().agents()[at(a)]);
    const Layout::View u = groups_.layout().u(a);
    for (int k = 0; k < ocp_.horizon().N; ++k) {
      for (int i = 0; i < groups_.layout().part(a).nu; ++i) {
        per_scale_[u(k, i)] = 1.0 / scales[at(i)];
        scale_2_[u(k, i)] = scales[at(i)] * scales[at(i)];
      }
    }
  }
  predictions_.resize(at(ocp_.team().bodies()));
  for (int b = 0; b < ocp_.team().bodies(); ++b) {
    if (!ocp_.team().is_agent(BodyId{b})) predictions_[at(b)].sights.reserve(at(ocp_.horizon().N + 1));
  }
}

Deadline NewtonUpdate::deadline() const noexcept {
  constexpr double longest = 1e6;  // [s], as good as none
  const std::chrono::duration<double> given(std::min(options_.deadline, longest));
  return {begin_ + std::chrono::duration_cast<Clock::duration>(given), options_.deadline > 0};
}

bool NewtonUpdate::late() const noexcept { return deadline().passed(); }

bool NewtonUpdate::accept(std::span<const double> states) noexcept {
  if (static_cast<int>(states.size()) != ocp_.nx()) return false;
  std::copy(states.begin(), states.end(), x_now_.begin());
  const Team& team = ocp_.team();
  for (int b = 0; b < team.bodies(); ++b) {
    if (!team.model(BodyId{b}).normalise(&x_now_[at(team.state_offset(BodyId{b}))])) return false;
  }
  if (!started_) groups_.rest_at(x_now_.data(), x_at_);
  for (int a = 0; a < static_cast<int>(ocp_.agent_bodies().size()); ++a) {
    Group& group = groups_.group_of(a);
    const int lane = groups_.layout().place(a).lane;
    const double* const x = &x_now_[at(team.state_offset(ocp_.agent_bodies()[at(a)]))];
    const int own = group.sizes().nx - group.sizes().before;
    for (int i = 0; i < own; ++i) group.x(0, i, lane) = x[i];
    const std::size_t input = at(team.input_offset(ocp_.agent_bodies()[at(a)]));
    for (int i = 0; i < group.sizes().before; ++i) {
      const std::size_t at_u = input + at(i);
      group.x(0, own + i, lane) = before_.empty() ? u_out_[at_u] : before_[at_u] - added_[at_u];
    }
  }
  return true;
}

/// References, limits, and what is known of bodies that are not controlled, along the horizon.
void NewtonUpdate::set_time(double time) noexcept {
  time_ = time;
  const Team& team = ocp_.team();
  const int N = ocp_.horizon().N;
  const double h = ocp_.horizon().h();
  groups_.each(*pool_, [&](int g, int) noexcept { write_reference_inputs(g, time); });
  for (int a = 0; a < static_cast<int>(ocp_.agent_bodies().size()); ++a) {
    if (started_ && !limits_move_) break;
    const Agent& agent = team.agents()[at(a)];
    const int nu = groups_.layout().part(a).nu;
    const Layout::View u = groups_.layout().u(a);
    const std::size_t input = at(team.input_offset(ocp_.agent_bodies()[at(a)]));
    const bool constant = agent.limits.times().size() <= 1 && agent.rate_max.empty();
    for (int k = 0; k < N; ++k) {
      if (k == 0 || !constant) find_limits(agent, input, time, k * h);
      for (int i = 0; i < nu; ++i) {
        low_[u(k, i)] = limits_[at(i)];
        high_[u(k, i)] = limits_[at(nu + i)];
      }
    }
  }
  for (int k = 0; k < N; ++k) couplings_->set_time(k, time + k * h);
  couplings_->set_weights(time);
  for (int b = 0; b < team.bodies(); ++b) {
    if (team.is_agent(BodyId{b})) continue;
    Sight<double> sight = team.model(BodyId{b}).sight(&x_now_[at(team.state_offset(BodyId{b}))], nullptr);
    if (const Prediction& prediction = predictions_[at(b)]; prediction.holds(time, sight.p)) {
      for (int k = 0; k < N; ++k) couplings_->set_body(b, k, prediction.at(time, k));
      continue;
    }
    for (int k = 0; k < N; ++k) {
      couplings_->set_body(b, k, sight);
      sight.p = sight.p + h * sight.v;
    }
  }
  if (!limits_move_ || !started_) return;
  detach_plan();
  // A limit that moved takes its inputs along, or lets them go.
  for (int i = 0; i < groups_.layout().u_length; ++i) {
    u_[i] = clamp(u_[i], low_[i], high_[i]);
    active_[i] = u_[i] == low_[i] || u_[i] == high_[i] ? active_[i] : 0.0;
  }
}

/// What the robots of a group are to follow, from the headings that they have.
void NewtonUpdate::write_reference_inputs(int g, double time) noexcept {
  const std::ptrdiff_t lanes = groups_.layout().width;
  const int stages = ocp_.horizon().N + 1;
  bool constant = true;
  for (const int a : groups_.members(g)) {
    const Agent& agent = ocp_.team().agents()[at(a)];
    constant &= agent.x_ref.is_constant();
    const HeadingErrorLimit& limit = heading_limits_[at(a)];
    const bool stays = started_ && agent.x_ref.is_constant() && turned_[at(a)] == 0;
    if (stays && !limit.applies()) continue;
    Group& group = groups_.group_of(a);
    const int lane = groups_.layout().place(a).lane;
    const double* const x = &group.x(0, 0, lane);
    double* const x_ref = &group.x_ref(0, 0, lane);
    if (stays && !limit.exceeded(x, x_ref, lanes)) continue;
    const std::ptrdiff_t stage = group.sizes().nx * lanes;
    agent.x_ref.along(time, ocp_.horizon().h(), stages, agent.model, x_ref, stage, lanes);
    turned_[at(a)] = limit(x, lanes, x_ref, stages, stage, lanes) ? 1 : 0;
  }
  groups_.hold_reference(g, constant);
}

/// Into limits_: those of a robot's inputs, u_min before u_max, so long after an update; its inputs begin at `input`.
void NewtonUpdate::find_limits(const Agent& agent, std::size_t input, double time, double ahead) noexcept {
  const std::size_t nu = agent.R.size();
  const std::span<double> low{limits_.data(), nu}, high{limits_.data() + nu, nu};
  agent.limits.at(time + ahead, low, high);
  if (before_.empty()) return;
  for (std::size_t i = 0; i < nu; ++i) {
    if (!agent.rate_max.empty()) {
      const double reach = agent.rate_max[i] * (ocp_.horizon().dt + ahead), u = before_[input + i];
      const double slow_low = clamp(u - reach, low[i], high[i]),
                   slow_high = clamp(u + reach, low[i], high[i]);
      low[i] = slow_low, high[i] = slow_high;
    }
    low[i] -= added_[input + i], high[i] -= added_[input + i];
  }
}

void NewtonUpdate::start() noexcept {
  detach_plan();
  for (int i = 0; i < groups_.layout().u_length; ++i) {
    u_[i] = clamp(has_plan_ ? u_[i] : 0.0, low_[i], high_[i]);
    active_[i] = 0.0;
  }
  all_free_ = true;
  has_plan_ = globalising_ = false;
  watched_ = infinity;
  taken_ = wait_ = 0;
  pause_ = 1;
  foreseen_ = false;
  krylov_.forget();
}

void NewtonUpdate::restart() noexcept {
  started_ = has_plan_ = false;
  detach_plan();
  std::fill_n(plan_, groups_.layout().u_length, 0.0);
  states_ = States::none;
  for (Prediction& prediction : predictions_) prediction.sights.clear();
  plan_time_ = 0.0;
}

void NewtonUpdate::write_inputs() noexcept {
  for (int a = 0; a < static_cast<int>(ocp_.agent_bodies().size()); ++a) {
    const Layout::View u = groups_.layout().u(a);
    const std::size_t to = at(ocp_.team().input_offset(ocp_.agent_bodies()[at(a)]));
    for (int i = 0; i < groups_.layout().part(a).nu; ++i) {
      u_out_[to + at(i)] = u_[u(0, i)];
      raw_u_[to + at(i)] = u_next_[u(0, i)] + du_[u(0, i)];
    }
  }
}

std::span<const double> NewtonUpdate::predicted_states() noexcept {
  if (states_ == States::none) return {};
  if (states_ == States::rolled_out) write_states();
  states_ = States::written;
  return {x_out_[0], at(ocp_.nx()) * at(ocp_.horizon().N + 1)};
}

/// The trajectory of the last roll-out.
void NewtonUpdate::write_states() noexcept {
  const Team& team = ocp_.team();
  const int N = ocp_.horizon().N;
  groups_.each(*pool_, [&](int g, int) noexcept { groups_.copy_states(g, x_out_[0], ocp_.nx(), x_at_); });
  for (int b = 0; b < team.bodies(); ++b) {
    if (team.is_agent(BodyId{b})) continue;
    const std::size_t from = at(team.state_offset(BodyId{b}));
    const Prediction& prediction = predictions_[at(b)];
    const bool is_predicted = prediction.holds(time_, {x_now_[from], x_now_[from + 1], x_now_[from + 2]});
    for (int k = 0; k <= N; ++k) {
      double* const to = x_out_[0] + from + at(k * ocp_.nx());
      const std::size_t nx = at(team.model(BodyId{b}).nx());
      if (is_predicted && k > 0) {
        write_body(prediction.at(time_, k), {to, nx});
        continue;
      }
      std::copy_n(&x_now_[from], nx, to);
      for (std::size_t i = 0; i < 3; ++i) to[i] += k * ocp_.horizon().h() * to[3 + i];
    }
  }
}

/// The input that the last good plan has for this time; before there is one, zero within the limits.
Solution NewtonUpdate::fall_back(double time, Status status) noexcept {
  const Team& team = ocp_.team();
  started_ = false;
  planned(time, raw_u_);
  for (int a = 0; a < static_cast<int>(ocp_.agent_bodies().size()); ++a) {
    const int nu = groups_.layout().part(a).nu;
    const std::size_t to = at(team.input_offset(ocp_.agent_bodies()[at(a)]));
    find_limits(team.agents()[at(a)], to, std::isfinite(time) ? time : plan_time_, 0.0);
    for (int i = 0; i < nu; ++i) {
      u_out_[to + at(i)] = clamp(raw_u_[to + at(i)], limits_[at(i)], limits_[at(nu + i)]);
    }
  }
  return {.u = u_out_,
          .raw_u = raw_u_,
          .x = {},
          .status = status,
          .elapsed = std::chrono::duration<double>(Clock::now() - begin_).count()};
}

Solution NewtonUpdate::solve(double time, std::span<const double> states) noexcept {
  begin_ = Clock::now();
  const FlushSubnormals guard;
  states_ = States::none;
  if (!std::isfinite(time) || !accept(states)) return fall_back(time, Status::invalid_state);
  set_time(time);
  const bool anew = !started_ && !has_plan_;
  const int steps =
      anew ? std::max(options_.max_newton_steps, options_.start_steps) : options_.max_newton_steps;
  if (!started_) start();
  started_ = true;
  extrapolate_plan();

  Step step;
  int iterations = 0;
  for (int i = 0; i < steps; ++i) {
    step = newton_step();
    iterations += step.iterations;
    if (!step.finite || !step.in_time || step.residual <= options_.tolerance) break;
  }
  if (!step.finite) return fall_back(time, Status::not_finite);
  write_inputs();
  states_ = States::rolled_out;
  remember(step);
  const Status status = !step.in_time                         ? Status::deadline
                        : step.residual <= options_.tolerance ? Status::converged
                        : steps == 1 && step.whole            ? Status::stepped
                                                              : Status::iteration_limit;
  return {.u = u_out_,
          .raw_u = raw_u_,
          .x = *this,
          .status = status,
          .residual = step.residual,
          .iterations = iterations,
          .neighbours = couplings_->neighbours(),
          .elapsed = std::chrono::duration<double>(Clock::now() - begin_).count()};
}

double NewtonUpdate::kkt(double time, std::span<const double> states) noexcept {
  const FlushSubnormals guard;
  states_ = States::none;
  if (!std::isfinite(time) || !accept(states)) return infinity;
  set_time(time);
  if (!started_) {
    const bool planned = has_plan_;  // for the next update too
    start();
    has_plan_ = planned;
  }
  groups_.roll_out(u_, s_, *pool_);
  couplings_->find_neighbours(s_);
  std::swap(H_u_, u_start_);  // the next update goes on from the one of the last
  differentiate();
  const double residual = examine().residual;
  const bool finite = slope_is_finite();
  std::swap(H_u_, u_start_);
  return finite ? residual : infinity;
}

}  // namespace sightline
