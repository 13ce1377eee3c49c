#include "sightline/judge/present_team.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/base.hpp"
#include "sightline/potential/protection.hpp"

namespace sightline {
namespace {

/// False for potentials that look through different sensors.
bool share_sensor(const Potential& a, const Potential& b) noexcept {
  return a.mount() == nullptr || b.mount() == nullptr || *a.mount() == *b.mount();
}

}  // namespace

bool is_in_view(const Observation& pair, const Sight<double>& observer, const Sight<double>& target,
                double time) noexcept {
  return pair.potential.violation(observer, target, time) <= 0;
}

bool is_same_view(const Observation& one, const Observation& other) noexcept {
  return one.observer == other.observer && one.target == other.target &&
         share_sensor(one.potential, other.potential);
}

std::vector<Observation> observations(std::span<const Coupling> couplings) {
  std::vector<Observation> found;
  const auto same = [](const Observation& o, BodyId a, BodyId b) { return o.observer == a && o.target == b; };
  for (const Coupling& c : couplings) {
    const BodyId a = c.between.first, b = c.between.second;
    const Potential& potential = c.term.potential;
    if (!observes(potential) || potential.violation({}, {}) == -std::numeric_limits<double>::infinity())
      continue;
    const SensorMount mount = potential.mount() != nullptr ? *potential.mount() : SensorMount{};
    const Observation one = {a,        b,        potential, mount, potential.alpha().value_or(no_value),
                             no_value, no_value, c.third};
    if (std::none_of(found.begin(), found.end(), [&](const Observation& o) { return is_same_view(o, one); }))
      found.push_back(one);
  }
  // Distance limits count in both directions. fmax and fmin ignore NaN.
  for (const Coupling& c : couplings) {
    const BodyId a = c.between.first, b = c.between.second;
    for (Observation& o : found) {
      if (!same(o, a, b) && !same(o, b, a)) continue;
      o.d_min = std::fmax(o.d_min, c.term.potential.d_min().value_or(no_value));
      o.d_max = std::fmin(o.d_max, c.term.potential.d_max().value_or(no_value));
    }
  }
  return found;
}

std::vector<Coupling> all_couplings(const Scenario& scenario) {
  std::vector<Coupling> all = scenario.team.couplings();
  if (scenario.script.empty()) return all;
  const std::vector<Presence> everybody(size(scenario.team.bodies()), Presence::steered);
  ActiveTeam active_team(scenario.team, everybody);
  for (const TeamEvent& event : scenario.script.events) {
    for (const Action& action : event.actions) {
      if (std::holds_alternative<RemoveBody>(action)) continue;
      (void)active_team.apply(action, 0.0, 0.0);
      for (const Coupling& c : active_team.couplings()) {
        const auto same = [&](const Coupling& other) {
          return other.between.first == c.between.first && other.between.second == c.between.second &&
                 other.third == c.third && other.term.potential.name() == c.term.potential.name() &&
                 share_sensor(other.term.potential, c.term.potential);
        };
        if (std::none_of(all.begin(), all.end(), same)) all.push_back(c);
      }
    }
  }
  return all;
}

std::vector<bool> leaning_bodies(const Scenario& scenario) {
  std::vector<bool> leans;
  for (int i = 0; i < scenario.team.bodies(); ++i)
    leans.push_back(vehicle_of(scenario, BodyId{i}) != nullptr);
  for (const Observation& o : observations(all_couplings(scenario))) {
    if (o.mount.frame == MountFrame::body) leans[size(o.observer.index)] = true;
  }
  return leans;
}

PresentTeam::PresentTeam(const Scenario& scenario)
    : script_(scenario.script), tuned_(scenario.tuned), active_team_(scenario.team, scenario.presence) {
  compose(0.0);
}

void PresentTeam::compose(double t) {
  team_ = active_team_.team(t);
  const double settled = active_team_.at_rest_from(t);
  settles_at_ = settled > t ? settled : std::numeric_limits<double>::infinity();
  world_.clear();
  for (int i = 0; i < team_.bodies(); ++i) world_.push_back(active_team_.all().find(team_.name(BodyId{i})));
  x_.resize(size(team_.nx()));
  u_.resize(size(team_.nu()));
}

bool PresentTeam::follow(const Sample& sample) {
  bool changed = false;
  for (int i = 0; i < sample.event_count; ++i) {
    const Event& event = sample.events[size(i)];
    if (event.kind != EventKind::event_in_force) continue;
    const TeamEvent* const what = flown_event(script_, tuned_.get(), static_cast<std::size_t>(event.value));
    if (what == nullptr) continue;
    for (const Action& action : what->actions) (void)active_team_.apply(action, event.time, ramp_of(*what));
    changed = true;
  }
  if (changed || sample.time >= settles_at_ - same_time) compose(sample.time);
  return changed;
}

std::vector<Coupling> PresentTeam::couplings() const {
  std::vector<Coupling> list;
  const auto is_there = [&](BodyId body) { return active_team_.presence(body) != Presence::absent; };
  for (const Coupling& c : active_team_.couplings()) {
    const bool felt = std::any_of(c.felt_by.begin(), c.felt_by.end(), [&](AgentId agent) {
      return active_team_.presence(agent) == Presence::steered;
    });
    const bool has_third = !c.has_third() || is_there(c.third);
    if (c.ramp.to > 0 && felt && has_third && is_there(c.between.first) && is_there(c.between.second))
      list.push_back(c);
  }
  return list;
}

std::vector<Constraint> PresentTeam::constraints() const {
  std::vector<Constraint> list;
  for (const Constraint& c : active_team_.constraints()) {
    if (c.ramp.to > 0 && active_team_.presence(c.agent) == Presence::steered) list.push_back(c);
  }
  return list;
}

std::vector<BodyId> PresentTeam::observers() const {
  std::vector<BodyId> list;
  for (const Coupling& c : active_team_.couplings()) {
    const BodyId robot = c.between.first;
    if (!(c.ramp.to > 0) || active_team_.presence(robot) != Presence::steered || !observes(c.term.potential))
      continue;
    if (std::find(list.begin(), list.end(), robot) == list.end()) list.push_back(robot);
  }
  return list;
}

const Agent* PresentTeam::agent(BodyId robot) const {
  const auto found = std::find(world_.begin(), world_.end(), robot);
  if (found == world_.end()) return nullptr;
  const BodyId body{static_cast<int>(found - world_.begin())};
  return team_.is_agent(body) ? &team_.agent(body) : nullptr;
}

double PresentTeam::cost(const Sample& sample) {
  const Team& all = active_team_.all();
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i}, in_world = world_[size(i)];
    const double* const x = &sample.x[size(all.state_offset(in_world))];
    const double* const u = sample.u.data() + all.input_offset(in_world);
    double* const to = &x_[size(team_.state_offset(body))];
    if (team_.is_agent(body) == all.is_agent(in_world)) {
      std::copy_n(x, team_.model(body).nx(), to);
      std::copy_n(u, team_.model(body).nu(), u_.begin() + team_.input_offset(body));
    } else {
      write_body(all.model(in_world).sight(x, u), {to, size(team_.model(body).nx())});
    }
  }
  return stage_cost(team_, sample.time, x_, u_);
}

}  // namespace sightline
