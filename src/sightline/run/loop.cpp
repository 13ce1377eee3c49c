#include "sightline/run/loop.hpp"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sightline/base/index.hpp"
#include "sightline/base/same_time.hpp"
#include "sightline/base/throw_invalid.hpp"

namespace sightline {
namespace {

/// The horizon that defines the stages of the predicted paths.
const Horizon& longest_horizon(const Controllers& controllers) {
  const auto fewer = [](const Solver& a, const Solver& b) {
    return a.ocp().horizon().N < b.ocp().horizon().N;
  };
  return std::max_element(controllers.begin(), controllers.end(), fewer)->get().ocp().horizon();
}

const LoopOptions& checked(const LoopOptions& o, const Controllers& controllers) {
  if (!(o.period >= 1e-4)) throw_invalid("loop.period = {}, expected >= 1e-4 s", o.period);
  if (!(o.duration > 0 && o.duration / o.period <= 1e9)) {
    throw_invalid("loop.duration = {}, expected > 0 s and at most 1e9 periods", o.duration);
  }
  if (!(o.path_interval >= 0)) throw_invalid("loop.path_interval = {}, expected >= 0 s", o.path_interval);
  if (controllers.empty()) throw_invalid("the loop has no controller, expected at least one");
  return o;
}

/// Presence if all bodies of a team are present.
std::vector<Presence> everybody(const Team& team) {
  std::vector<Presence> presence;
  for (int i = 0; i < team.bodies(); ++i) {
    presence.push_back(team.is_agent(BodyId{i}) ? Presence::steered : Presence::hold);
  }
  return presence;
}

}  // namespace

Sample sized_sample(const World& world, const Controllers& controllers, const TeamSwitcher* team_switcher) {
  Sample sample = sized_sample(world.team(), controllers, team_switcher);
  const MeasuredMost most = world.measured_max();
  sample.detections.resize(most.detections);
  sample.motions.resize(most.motions);
  sample.broadcasts.resize(most.broadcasts);
  sample.fits.resize(most.motions > 0 ? most.detections : 0);
  sample.estimates.resize(most.motions > 0 ? size(world.team().bodies()) : 0);
  return sample;
}

Sample sized_sample(const Team& team, const Controllers& controllers, const TeamSwitcher* team_switcher) {
  const std::size_t nx = size(team.nx()), nu = size(team.nu());
  const Horizon horizon = controllers.empty() ? Horizon{} : longest_horizon(controllers);
  Sample sample;
  sample.x.resize(nx);
  sample.measured.resize(nx);
  sample.attitudes.resize(size(team.bodies()), no_attitude);
  sample.stamps.resize(size(team.bodies()));
  sample.u.resize(nu);
  sample.raw_u.resize(nu);
  sample.solvers.resize(controllers.size());
  sample.barriers.resize(team.agents().size());
  sample.presence = everybody(team);
  sample.levels.resize(sample.presence.size());
  sample.path.resize(size(horizon.N + 1) * nx);
  sample.path_step = horizon.h();
  sample.events.resize(16 + 4 * sample.presence.size() +
                       (team_switcher != nullptr ? team_switcher->events_max() : 0));
  return sample;
}

Loop::Loop(World& world, const Controllers& controllers, Clock& clock, Sink<Sample>& sink,
           const LoopOptions& options)
    : world_(world),
      clock_(clock),
      sink_(sink),
      options_(checked(options, controllers)),
      presence_(everybody(world.team())),
      presence_before_(presence_),
      measured_(world.team(), world.start()),
      met_(measured_),
      estimate_(&measured_),
      lead_(options.compensation != nullptr ? options.compensation->lead() : 0.0),
      gate_(world.team(), options_.period),
      u_(size(world.team().nu())),
      none_(u_.size()),
      u_min_(u_.size()),
      u_max_(u_.size()),
      planned_at_(size(world.team().bodies())),
      plan_ages_(planned_at_.size()),
      ages_(planned_at_.size()),
      plan_(u_.size()),
      spare_(sized_sample(world, controllers, options.team_switcher)) {
  solvers_use_applied_ = options_.compensation != nullptr;
  for (const Agent& agent : world.team().agents())
    solvers_use_applied_ |= !agent.rate_max.empty() || !agent.R_rate.empty();
  for (const LatePlan& late : options_.late_plans) late.check();
  std::stable_sort(options_.signals.begin(), options_.signals.end(),
                   [](const TimedSignal& a, const TimedSignal& b) { return a.at < b.at; });
  for (Solver& solver : controllers) {
    const double dt = solver.ocp().horizon().dt;
    if (std::abs(dt - options_.period) > 1e-9) {
      throw_invalid("controller {}: horizon.period = {}, expected the loop's {}", controllers_.size(), dt,
                    options_.period);
    }
    controllers_.emplace_back(world.team(), solver, controllers_.size());
  }
  if (options_.team_switcher != nullptr) {
    if (controllers.size() != 1 || &controllers[0].get() != options_.team_switcher->present().solver.get()) {
      throw_invalid(
          "a team that changes has {} controllers, expected the present solver of its TeamSwitcher alone",
          controllers.size());
    }
    options_.team_switcher->set_start(world.start());
    follow_team();
    follow_guard(0.0, world.start(), world.start());
  }
  if (options_.guard != nullptr && controllers.size() == 1)
    options_.guard->set_connectivity(controllers[0].get().connectivity());
  check_steered();
  const Sample* item = sink.claim();
  const bool has_room = item == nullptr || item->path_u.empty() ||  // or room for each stage
                        item->path_u.size() * item->x.size() == item->path.size() * item->u.size();
  if (item == nullptr || !has_room || item->attitudes.size() != spare_.attitudes.size() ||
      item->x.size() != spare_.x.size() || item->path.size() != spare_.path.size() ||
      item->solvers.size() != spare_.solvers.size() || item->barriers.size() != spare_.barriers.size() ||
      item->levels.size() != spare_.levels.size() || item->detections.size() != spare_.detections.size() ||
      item->motions.size() != spare_.motions.size() || item->broadcasts.size() != spare_.broadcasts.size() ||
      item->fits.size() != spare_.fits.size() || item->estimates.size() != spare_.estimates.size() ||
      item->events.size() < spare_.events.size()) {
    throw_invalid(
        "the sink's samples are not of this loop's size, expected room in it for copies of sized_sample()");
  }
  events_.reserve(64 + 2 * u_.size() + 2 * controllers_.size() + spare_.events.size());

  // Until the first good command, robots hold their u*, within their limits.
  for (int i = 0; i < world.team().bodies(); ++i) gate_.rest(BodyId{i}, 0.0, u_);
  (void)gate_.pass(u_, {});
}

void Loop::check_steered() const {
  const Team& world = world_.team();
  std::vector<int> steered_by(size(world.bodies()), -1);
  for (std::size_t c = 0; c < controllers_.size(); ++c) {
    for (const Controller::Member& m : controllers_[c].members) {
      if (m.limits == nullptr) continue;
      int& other = steered_by[size(m.body.index)];
      if (other >= 0) {
        throw_invalid("\"{}\" is steered by controllers {} and {}, expected one", world.name(m.body), other,
                      c);
      }
      other = static_cast<int>(c);
    }
  }
  for (int i = 0; i < world.bodies(); ++i) {
    if (presence_[size(i)] == Presence::steered && steered_by[size(i)] < 0) {
      throw_invalid("\"{}\" is steered by no controller, expected one whose team has it",
                    world.name(BodyId{i}));
    }
  }
}

LoopOutcome Loop::run() noexcept {
  const std::int64_t periods = std::llround(options_.duration / options_.period);
  const std::int64_t path_every =
      options_.path_interval > 0
          ? std::max<std::int64_t>(1, std::llround(options_.path_interval / options_.period))
          : 0;
  clock_.start(options_.period);
  std::int64_t next_path = path_every > 0 ? 0 : periods, reported = 0;
  double t = 0.0;
  for (std::int64_t next = 0;; ++next) {
    const std::int64_t k = std::min(clock_.wait(next), periods);
    t = static_cast<double>(k) * options_.period;
    if (k > next) {
      outcome_.missed += k - next;
      emit({t, EventKind::missed_period, 0, static_cast<double>(k - next)});
      outcome_.finite = apply(static_cast<double>(next) * options_.period, k - next) && outcome_.finite;
      next = k;
    }
    outcome_.stopped =
        k < periods && options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed);
    if (k == periods || outcome_.stopped || !outcome_.finite) break;

    Sample* const slot = claim_slot();
    Sample& sample = slot != nullptr ? *slot : spare_;
    sample.of = Sample::Of::update;
    sample.has_path = k >= next_path;
    if (sample.has_path) next_path = (k / path_every + 1) * path_every;
    const bool changes = options_.team_switcher != nullptr && options_.team_switcher->pending();
    const bool changed = options_.team_switcher != nullptr && change_team(k, t);
    sample.team_answered = changes && !options_.team_switcher->pending();
    const Measured seen = localize(t, world_.measure(t), sample);
    (void)measured_.take(seen.measured, seen.stamps);
    const std::span<const double> x = seen.truth.empty() ? seen.measured : seen.truth;
    if (changed) {
      const std::span<const double> valid =
          seen.truth.empty() ? std::span<const double>(measured_) : seen.truth;
      follow_guard(t, valid, options_.localizer != nullptr ? measured_ : valid);
    }
    sample.truth_known = !seen.truth.empty();
    std::copy(x.begin(), x.end(), sample.x.begin());
    std::copy(seen.attitudes.begin(), seen.attitudes.end(), sample.attitudes.begin());
    std::copy(presence_.begin(), presence_.end(), sample.presence.begin());
    update(t, seen, sample);
    ++outcome_.updates;

    if (slot != nullptr) {
      if (outcome_.dropped > reported) {
        reported = outcome_.dropped;
        emit({t, EventKind::samples_dropped, 0, static_cast<double>(reported)});
      }
      move_events(sample);
      sink_.publish();
    } else {
      ++outcome_.dropped;
      sink_.drop(sample);
    }
    outcome_.finite = apply(t, 1);
  }
  if (outcome_.updates > 0) show_end(t);
  sink_.close();
  return outcome_;
}

/// Claims room for the next sample; nullptr if the sink has none. In simulated time it waits for
/// room, but neither for an abandoned sink nor after a stop request. The flight does not depend on
/// the recorder.
Sample* Loop::claim_slot() noexcept {
  constexpr timespec nap = {0, 100'000};
  // Counted in sleeps, so that a suspended process does not count its pause as a wait for the log.
  const auto naps_max = static_cast<std::int64_t>(options_.log_patience / 1e-4);
  Sample* slot = sink_.claim();
  for (std::int64_t naps = 0; slot == nullptr && clock_.waits_for_log() && !log_is_stuck_; ++naps) {
    if (options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed)) break;
    log_is_stuck_ = naps >= naps_max || sink_.is_abandoned();
    ::nanosleep(&nap, nullptr);
    slot = sink_.claim();
  }
  if (slot != nullptr) log_is_stuck_ = false;
  return slot;
}

void Loop::update(double t, const Measured& seen, Sample& sample) noexcept {
  sample.time = t;
  if (outcome_.updates == 0) std::fill(planned_at_.begin(), planned_at_.end(), t);
  const bool localizes = options_.localizer != nullptr;
  if (options_.guard != nullptr) {
    estimate_ = &options_.guard->accept_measurement(
        t, seen.measured, seen.stamps, localizes ? options_.localizer->sigma() : std::span<const double>{});
    if (localizes) options_.guard->look(t, options_.localizer->views());
  }
  gate_.open(t);
  const ValidStates& met = compensate(t);
  if (sample.has_path) {
    for (std::size_t i = 0; i < sample.path.size(); ++i) sample.path[i] = (*estimate_)[i % estimate_->size()];
    sample.path_time = t + lead_;
    for (std::size_t i = 0; i < sample.path_u.size(); ++i) sample.path_u[i] = gate_.applied()[i % u_.size()];
  }
  std::copy(u_.begin(), u_.end(), sample.raw_u.begin());  // for robots without a controller
  const std::span<Controller> requested = controllers();
  for (std::size_t c = 0; c < requested.size(); ++c) {
    Controller& controller = requested[c];
    const std::int64_t before = allocations();
    const Solution solution = solve(controller, t, met);
    command(static_cast<int>(c), controller, solution, t, sample);
    sample.solvers[c] = {solution.status,        solution.residual,      solution.iterations,
                         1e6 * solution.elapsed, allocations() - before, solution.neighbours.pairs,
                         controller.answered};
    if (outcome_.updates > 0 && solution.status != controller.status) {
      emit({t, EventKind::solver_status, static_cast<int>(c), static_cast<double>(solution.status)});
    }
    controller.status = solution.status;
    const int left_out = solution.neighbours.left_out;
    if (left_out > controller.left_out) {
      emit({t, EventKind::pairs_left_out, static_cast<int>(c), static_cast<double>(left_out)});
    }
    controller.left_out = left_out == 0 ? 0 : std::max(controller.left_out, left_out);
    if (sample.has_path) write_path(controller, solution, sample);
  }
  steer_uncontrolled(t, met, sample);
  if (options_.guard != nullptr)
    guard(t, met, sample);
  else
    gate_.keep_limits_and_rates(u_, added());
  pass_gate(t);
  std::copy(gate_.applied().begin(), gate_.applied().end(), sample.u.begin());
  sample.update_us =
      std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - began_).count();
  if (options_.team_switcher != nullptr) {
    std::transform(seen.stamps.begin(), seen.stamps.end(), ages_.begin(),
                   [t](double stamp) { return t - stamp; });
    options_.team_switcher->look(t, *estimate_, u_,
                                 options_.guard != nullptr ? options_.guard->ages() : std::span(ages_));
    for (const Event& event : options_.team_switcher->events()) emit(event);
    options_.team_switcher->clear_events();
  }
  outcome_.max_allocations = std::max(outcome_.max_allocations, allocations() - allocated_);
}

/// Passes the inputs through the gate, and records the command that is applied from t on.
void Loop::pass_gate(double t) noexcept {
  const Command command =
      gate_.pass(u_, options_.compensation != nullptr ? added() : std::span<const double>{});
  for (const BodyId robot : gate_.replaced()) {
    ++outcome_.refused;
    emit({t, EventKind::input_refused, 0, static_cast<double>(robot.index)});
  }
  if (options_.compensation != nullptr) options_.compensation->record(t, command);
  if (options_.guard != nullptr) options_.guard->record(t, command);
}

/// Computes u* of robots whose u* follows from their references.
void Loop::set_reference_inputs(Controller& controller, double t, const ValidStates& x) noexcept {
  const Team& team = controller.solver->ocp().team();
  for (std::size_t i = 0; i < controller.members.size(); ++i) {
    const Controller::Member& m = controller.members[i];
    if (m.limits == nullptr) continue;
    options_.compensation->write_reference_inputs(m.body, team.agent(BodyId{static_cast<int>(i)}).x_ref,
                                                  t + lead_, std::span<const double>(x).data() + m.world_x,
                                                  std::span(controller.u_ref).subspan(m.ocp_u, m.nu));
  }
}

/// Runs an update. While a late update is in progress, uses the previous plan's inputs for this
/// time.
Solution Loop::solve(Controller& controller, double t, const ValidStates& x) noexcept {
  Solver& solver = *controller.solver;
  Solution solution{.u = controller.plan, .raw_u = controller.plan, .x = {}};
  controller.answered = false;
  if ((options_.guard != nullptr && !options_.guard->knows_all()) ||
      (options_.localizer != nullptr && !options_.localizer->knows_all())) {
    solution.status = Status::invalid_state;
  } else if (!controller.at_work) {
    controller.gather(world_.team(), x, u_);
    if (options_.compensation != nullptr) set_reference_inputs(controller, t, x);
    if (solvers_use_applied_) controller.set_applied({gate_.applied(), added(), added_lean()});
    if (options_.localizer != nullptr) controller.set_view_uncertainty(options_.localizer->uncertainties());
    controller.requested_at = t;
    const auto late = std::find_if(options_.late_plans.begin(), options_.late_plans.end(),
                                   [&](const LatePlan& l) { return l.strikes(t); });
    if (late == options_.late_plans.end()) {
      controller.answered = true;
      return solver.solve(t + lead_, controller.states);
    }
    controller.at_work = true;
    controller.done_at = t + late->delay;
  }
  if (controller.at_work && t >= controller.done_at - same_time) {
    controller.at_work = false;
    controller.answered = true;
    const Solution late = solver.solve(controller.requested_at + lead_, controller.states);
    solver.planned(t + lead_, controller.plan);
    solution.x = late.x;
    solution.status = late.status;
    solution.residual = late.residual;
    solution.iterations = late.iterations;
    solution.elapsed = late.elapsed;
    solution.neighbours = late.neighbours;
  } else if (controller.at_work) {
    solver.planned(t + lead_, controller.plan);
    solution.status = Status::deadline;
  }
  return solution;
}

std::span<Controller> Loop::controllers() noexcept {
  if (options_.team_switcher == nullptr) return controllers_;
  return {&*options_.team_switcher->present().controller, 1};
}

/// Lets robots without a solver brake, and counts their plans as new.
void Loop::steer_uncontrolled(double t, const ValidStates& x, Sample& sample) noexcept {
  if (options_.team_switcher == nullptr) return;
  for (UncontrolledRobot& robot : options_.team_switcher->present().uncontrolled) {
    robot.steer(t, x, added(), u_min_, u_max_, u_);
    std::copy_n(&u_[robot.u], robot.nu, &sample.raw_u[robot.u]);
    planned_at_[size(robot.body.index)] = t;
  }
}

/// Turns the controllers' inputs into the guard's command.
void Loop::guard(double t, const ValidStates& x, Sample& sample) noexcept {
  for (std::size_t i = 0; i < plan_ages_.size(); ++i) plan_ages_[i] = t - planned_at_[i];
  options_.guard->fall_back(t, x, plan_ages_, added(), u_);
  gate_.keep_limits_and_rates(u_, added());
  options_.guard->keep_distances(t, x, added(), u_);
  for (const Event& event : options_.guard->events()) emit(event);
  const auto records = options_.guard->barriers();
  std::copy(records.begin(), records.end(), sample.barriers.begin());
  const auto levels = options_.guard->levels();
  std::copy(levels.begin(), levels.end(), sample.levels.begin());
}

void Loop::command(int index, const Controller& controller, const Solution& solution, double t,
                   Sample& sample) noexcept {
  const std::size_t nu = size(controller.solver->ocp().nu());
  for (const Controller::Member& m : controller.members) {
    if (m.limits == nullptr) continue;
    const std::span<double> held = std::span(u_).subspan(m.world_u, m.nu);
    const auto u_min = std::span(u_min_).first(m.nu), u_max = std::span(u_max_).first(m.nu);
    m.limits->at(t + lead_, u_min, u_max);  // the solver's limits
    for (std::size_t i = 0; i < m.nu; ++i) {
      u_min[i] -= added()[m.world_u + i], u_max[i] -= added()[m.world_u + i];
    }
    bool good = solution.u.size() == nu;
    for (std::size_t i = 0; good && i < m.nu; ++i) {
      const double u = solution.u[m.ocp_u + i];
      good = u >= u_min[i] && u <= u_max[i];  // false for NaN
    }
    for (std::size_t i = 0; i < m.nu; ++i) {
      if (good) held[i] = solution.u[m.ocp_u + i];
      held[i] = std::clamp(held[i], u_min[i], u_max[i]);
      sample.raw_u[m.world_u + i] = solution.raw_u.size() == nu ? solution.raw_u[m.ocp_u + i] : held[i];
    }
    if (good && controller.answered && gives_plan(solution.status))
      planned_at_[size(m.body.index)] = controller.requested_at;
    if (good) continue;
    ++outcome_.refused;
    emit({t, EventKind::input_refused, index, static_cast<double>(m.body.index)});
  }
}

void Loop::write_path(const Controller& controller, const Solution& solution, Sample& sample) noexcept {
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
      for (std::size_t j = 0; j < m.nu; ++j) {
        sample.path_u[i * world_nu + m.world_u + j] = u[m.ocp_u + j] + added()[m.world_u + j];
      }
    }
  }
}

void Loop::emit(const Event& event) noexcept {
  if (events_.size() < events_.capacity()) events_.push_back(event);
}

}  // namespace sightline
