#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/loop.hpp"
#include "sightline/run/controller.hpp"

namespace sightline {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr int converging_steps = 30;

const Script& checked(const Script& script, const ActiveTeam& active_team) {
  const std::vector<ScriptFault> faults = faults_of(script, active_team);
  if (faults.empty()) return script;
  const std::string& name = script.events[faults[0].event].name;
  throw std::invalid_argument(fmt::format("event {}{}: {}", faults[0].event,
                                          name.empty() ? "" : fmt::format(" \"{}\"", name),
                                          faults[0].sentence));
}

Phase phase_of(std::unique_ptr<Solver> solver, const ActiveTeam& active_team) {
  Phase phase{.solver = std::move(solver), .controller = {}, .membership = active_team.membership()};
  phase.planner = &team_planner_of(*phase.solver, "a team that changes in flight");
  phase.controller.emplace(active_team.all(), *phase.solver, 0);
  for (int i = 0; i < active_team.all().bodies(); ++i) {
    const BodyId body{i};
    const Presence presence = active_team.presence(body);
    if (!active_team.all().is_agent(body) || presence == Presence::steered || presence == Presence::absent)
      continue;
    phase.uncontrolled.emplace_back(active_team.all(), body, presence == Presence::land,
                                    phase.solver->ocp().horizon().dt);
    phase.uncontrolled.back().limits = active_team.agent(AgentId{body}).limits;
  }
  return phase;
}

/// What an action changes something of: robots and other bodies, and a term by its name.
struct Changed {
  std::array<int, 2> bodies = {-1, -1};
  std::string_view term{};
};

Changed changed_by(const Action& action) noexcept {
  return std::visit(
      [](const auto& it) {
        Changed changed;
        if constexpr (requires { it.body; }) changed.bodies[0] = it.body.index;
        if constexpr (requires { it.agent; }) changed.bodies[0] = it.agent.index;
        if constexpr (requires { it.observer; }) changed.bodies[0] = it.observer.index;
        if constexpr (requires { it.target; }) changed.bodies[1] = it.target.index;
        if constexpr (requires { it.name; }) changed.term = it.name;
        if constexpr (requires { it.coupling; }) changed.term = it.coupling.name;
        if constexpr (requires { it.constraint; }) changed.term = it.constraint.name;
        return changed;
      },
      action);
}

bool change_the_same(const TeamEvent& a, const TeamEvent& b) noexcept {
  return std::any_of(a.actions.begin(), a.actions.end(), [&](const Action& one) {
    const Changed of_one = changed_by(one);
    return std::any_of(b.actions.begin(), b.actions.end(), [&](const Action& other) {
      const Changed of_other = changed_by(other);
      const auto is_shared = [&](int body) {
        return body >= 0 && (body == of_other.bodies[0] || body == of_other.bodies[1]);
      };
      return (!of_one.term.empty() && of_one.term == of_other.term) || is_shared(of_one.bodies[0]) ||
             is_shared(of_one.bodies[1]);
    });
  });
}

void nap() noexcept {
  constexpr timespec how_long = {0, 100'000};  // 0.1 ms
  ::nanosleep(&how_long, nullptr);
}

}  // namespace

TeamSwitcher::TeamSwitcher(ActiveTeam start, const Script& script, MakeSolver make,
                           std::shared_ptr<TunedScript> tuned)
    : world_(start.all()),
      script_(checked(script, start)),
      monitor_(script_, world_),
      make_(std::move(make)),
      tuned_(std::move(tuned)),
      present_(std::make_unique<Phase>()),
      settles_at_(never),
      ignored_(script_.events.size(), 0),
      active_team_(std::move(start)),
      next_(std::make_unique<Phase>()),
      next_settles_at_(never) {
  *present_ = phase_of(make_(active_team_.team(0.0)), active_team_);
  const Horizon& horizon = present_->solver->ocp().horizon();
  period_ = horizon.dt;
  request_.x.resize(size(world_.nx()));
  request_.u.resize(size(world_.nu()));
  request_.plan.resize(size(horizon.N) * size(world_.nu()));
  request_.events.reserve(script_.events.size() + 1);
  refused_.reserve(script_.events.size() + 1);
  awaited_.reserve(script_.events.size());
  reported_.reserve(4 * (script_.events.size() + 1) + 4 + world_.agents().size());
  thread_.start_or_throw([this]() noexcept { work(); });
}

TeamSwitcher::~TeamSwitcher() {
  stop_.store(true, std::memory_order_release);
  thread_.join();
}

template <class Act>
void TeamSwitcher::each_added(const TeamEvent& event, const Act& act) const noexcept {
  for (const Action& action : event.actions) {
    const auto* const add = std::get_if<AddBody>(&action);
    if (add == nullptr || !world_.is_agent(add->body)) continue;
    const Presence now = present_->membership.presence[at(add->body)];
    if (now == Presence::absent || now == Presence::land) act(add->body);
  }
}

void TeamSwitcher::emit(double t, EventKind kind, std::size_t event) noexcept {
  if (reported_.size() < reported_.capacity()) reported_.push_back({t, kind, 0, static_cast<double>(event)});
}

bool TeamSwitcher::swap(double t, const ValidStates& x, std::span<const double> u, bool wait) noexcept {
  if (!pending_) return false;
  while (wait && !is_ready()) nap();
  if (!is_ready()) return false;
  pending_ = false;
  for (const std::size_t event : request_.events) {
    report_of(t, event);
  }
  if (!next_->solver) return false;
  if (const double late = t - request_.t - period_; late > same_time) {
    emit(t, EventKind::team_late, static_cast<std::size_t>(std::llround(late / period_)));
  }
  next_->controller->status = present_->controller->status;
  std::swap(*present_, *next_);
  settles_at_ = next_settles_at_;
  // Brings the solver's memory into this core's cache outside of the update.
  present_->controller->gather(world_, x, u);
  (void)present_->solver->kkt(t, present_->controller->states);
  return true;
}

/// Reports the outcome of a requested event; for an ignored event that repeats, only once.
void TeamSwitcher::report_of(double t, std::size_t event) noexcept {
  const bool refused = std::find(refused_.begin(), refused_.end(), event) != refused_.end();
  if (refused && event >= script_.events.size()) {
    tuned_->ignore(event - script_.events.size());
  } else if (refused) {
    return ignore(t, event);
  }
  emit(t, refused ? EventKind::event_ignored : EventKind::event_in_force, event);
}

/// Reports an ignored event of the script, once. The robots that it adds do not wait for it.
void TeamSwitcher::ignore(double t, std::size_t event) noexcept {
  if (flown_in_ != nullptr) each_added(script_.events[event], [this](BodyId r) { flown_in_->call_off(r); });
  if (std::exchange(ignored_[event], 1) == 0) emit(t, EventKind::event_ignored, event);
}

/// Requests the take-off of all robots that an event adds, and returns the worst answer.
Joining TeamSwitcher::joining(double t, const TeamEvent& event) noexcept {
  Joining worst = Joining::at_once;
  if (flown_in_ == nullptr) return worst;
  each_added(event, [&](BodyId robot) { worst = std::max(worst, flown_in_->prepare(robot)); });
  if (worst == Joining::at_once || worst == Joining::waits) return worst;
  const EventKind kind = worst == Joining::ready ? EventKind::robot_ready : EventKind::robot_refused;
  each_added(event, [&](BodyId robot) {
    if (flown_in_->prepare(robot) == worst) emit(t, kind, at(robot));
  });
  return worst;
}

/// Whether an event waits for an earlier one, of the first so many that wait or of those requested
/// now, because both change something of one robot or term. Without it they would act in another
/// order than in a world where robots join at once.
bool TeamSwitcher::waits_for_another(const TeamEvent& event, std::size_t waiting) const noexcept {
  if (flown_in_ == nullptr || !flown_in_->absent_robots_stay()) return false;
  const auto same = [&](std::size_t other) {
    const TeamEvent* const earlier = flown_event(script_, tuned_.get(), other);
    return earlier != nullptr && change_the_same(event, *earlier);
  };
  return std::any_of(awaited_.begin(), awaited_.begin() + static_cast<std::ptrdiff_t>(waiting), same) ||
         std::any_of(request_.events.begin(), request_.events.end(), same);
}

/// Requests the events whose robots can join, and ignores those with a robot that cannot.
void TeamSwitcher::request_awaited(double t) noexcept {
  request_.events.clear();
  std::size_t waiting = 0;
  for (const std::size_t event : awaited_) {
    const TeamEvent& what = script_.events[event];
    const Joining answer = waits_for_another(what, waiting) ? Joining::waits : joining(t, what);
    if (answer == Joining::waits) {
      awaited_[waiting++] = event;
    } else if (answer == Joining::refused) {
      ignore(t, event);
    } else {
      request_.events.push_back(event);
    }
  }
  awaited_.resize(waiting);
}

/// Whether the next tuned event occurs now. It has a period of its own, so that two changes of one
/// object never coincide, and it does not overtake an event that waits.
bool TeamSwitcher::takes_tuned(double t) noexcept {
  if (tuned_ == nullptr || taken_ == tuned_->size()) return false;
  if (waits_for_another(tuned_->event(taken_), awaited_.size())) return false;
  tuned_->occur(taken_++, t);
  return true;
}

void TeamSwitcher::look(double t, const ValidStates& states, std::span<const double> u,
                        std::span<const double> ages) noexcept {
  if (pending_) return;
  const std::span<const double> x = states;
  const std::span<const std::size_t> triggered =
      monitor_.look({.t = t, .x = x, .u = u, .ages = ages, .presence = present_->membership.presence});
  for (const std::size_t event : triggered) {
    emit(t, EventKind::event_occurred, event);
    if (std::find(awaited_.begin(), awaited_.end(), event) == awaited_.end()) awaited_.push_back(event);
  }
  request_awaited(t);
  const bool settles = t + period_ >= settles_at_ - same_time;
  const bool tuned = request_.events.empty() && takes_tuned(t);
  if (request_.events.empty() && !settles && !tuned) return;
  if (settles) settles_at_ = never;
  request_.settles = settles;
  request_.t = t;
  if (tuned) {
    emit(t, EventKind::event_occurred, number_of_tuned(taken_ - 1));
    request_.events.push_back(number_of_tuned(taken_ - 1));
  }
  std::copy(x.begin(), x.end(), request_.x.begin());
  std::copy(u.begin(), u.end(), request_.u.begin());
  const std::size_t nu = size(present_->solver->ocp().nu());
  for (int k = 0; k < present_->solver->ocp().horizon().N; ++k) {
    present_->planner->plan(k, std::span(request_.plan).subspan(size(k) * nu, nu));
  }
  pending_ = true;
  hand_.store(Hand::thread, std::memory_order_release);
}

void TeamSwitcher::work() noexcept {
  while (!stop_.load(std::memory_order_acquire)) {
    if (hand_.load(std::memory_order_acquire) == Hand::control) {
      nap();
      continue;
    }
    prepare();
    hand_.store(Hand::control, std::memory_order_release);
  }
}

void TeamSwitcher::prepare() noexcept {
  *next_ = {};  // frees the previous solver
  refused_.clear();
  // Without memory, or if no solver takes the team, the team stays as before the event.
  const auto can_be = [&](std::span<const std::size_t> events) {
    try {
      make_next(events);
      return true;
    } catch (...) {
      return false;
    }
  };
  const std::span<const std::size_t> events = request_.events;
  if (can_be(events)) return;
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (events.size() == 1 || !can_be(events.subspan(i, 1))) refused_.push_back(events[i]);
  }
  if (request_.settles && !next_->solver) (void)can_be({});  // the ramps end without the events
}

/// Makes the team that these events lead to, without rejected events. If it throws, nothing has
/// changed.
void TeamSwitcher::make_next(std::span<const std::size_t> events) {
  const double t = request_.t + period_;
  ActiveTeam active_team = active_team_;
  std::vector<std::size_t> refused;
  bool changes = request_.settles;
  for (const std::size_t event : events) {
    ActiveTeam trial = active_team;
    const TeamEvent& what = *flown_event(script_, tuned_.get(), event);
    const bool accepted = std::all_of(what.actions.begin(), what.actions.end(), [&](const Action& action) {
      return trial.apply(action, t, ramp_of(what)).empty();
    });
    if (!accepted) {
      refused.push_back(event);
      continue;
    }
    active_team = std::move(trial);
    changes = changes || !what.actions.empty();
  }
  if (changes) {
    Phase next = phase_of(make_(active_team.team(t)), active_team);
    give_plan(*next.planner);
    predict(next);
    for (int i = 0; i < converging_steps; ++i) {
      const Status status = next.solver->solve(t, next.controller->states).status;
      if (status != Status::stepped && status != Status::iteration_limit) break;
    }
    *next_ = std::move(next);
  }
  active_team_ = std::move(active_team);
  const double settled = active_team_.at_rest_from(t);
  next_settles_at_ = settled > t ? settled : never;
  refused_.insert(refused_.end(), refused.begin(), refused.end());
}

/// Robots of both teams continue their plan; others start at u*.
void TeamSwitcher::give_plan(TeamPlanner& planner) const {
  const Team& team = planner.ocp().team();
  std::vector<double> u_ref(size(team.nu()));
  for (const BodyId body : planner.ocp().agent_bodies()) {
    const std::vector<double>& of_agent = team.agent(body).u_ref;
    std::copy(of_agent.begin(), of_agent.end(), u_ref.begin() + team.input_offset(body));
  }
  for (int k = 0; k < planner.ocp().horizon().N; ++k) planner.set_plan(k, u_ref);
  const Ocp& before = present_->solver->ocp();
  planner.take_over(before.team(),
                    std::span(request_.plan).first(size(before.horizon().N) * size(before.nu())));
}

/// Gives the next solver the states one period after the request.
void TeamSwitcher::predict(Phase& next) const {
  std::vector<double> x = request_.x;
  for (int i = 0; i < world_.bodies(); ++i) {
    const BodyId body{i};
    if (next.membership.presence[size(i)] == Presence::absent) continue;
    const std::size_t from = size(world_.state_offset(body));
    if (present_->membership.presence[size(i)] == Presence::absent && !start_.empty()) {
      std::copy_n(&start_[from], world_.model(body).nx(), &x[from]);
      continue;
    }
    const double* const u = world_.is_agent(body) ? &request_.u[size(world_.input_offset(body))] : nullptr;
    world_.model(body).step(&x[from], u, period_);
    (void)world_.model(body).normalise(&x[from]);
  }
  ValidStates predicted(world_, request_.x);
  (void)predicted.take(x, std::vector<double>(size(world_.bodies()), request_.t));
  next.controller->gather(world_, predicted, request_.u);
}

}  // namespace sightline
