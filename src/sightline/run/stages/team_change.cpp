#include "sightline/run/stages/team_change.hpp"

#include <algorithm>

#include "sightline/base.hpp"
#include "sightline/loop.hpp"
#include "sightline/run/controller.hpp"

namespace sightline::stages {

TeamChange::TeamChange(World& world, const Controllers& controllers, const Clock& clock,
                       const LoopOptions& options, Period& p)
    : world_(world), clock_(clock), options_(options), before_(p.presence), ages_(before_.size()) {
  if (options.team_switcher == nullptr) return;
  if (controllers.size() != 1 || &controllers[0].get() != options.team_switcher->present().solver.get()) {
    throw_invalid(
        "a team that changes has {} controllers, expected the present solver of its TeamSwitcher alone",
        controllers.size());
  }
  options.team_switcher->set_start(world.start());
  options.team_switcher->set_world(world);
  follow(p);
  if (options.guard != nullptr)
    options.guard->follow(options.team_switcher->present().membership, 0.0, world.start());
}

void TeamChange::run(Period& p) noexcept {
  TeamSwitcher* const switcher = options_.team_switcher;
  const bool was_pending = switcher != nullptr && switcher->pending();
  changed_ = switcher != nullptr && changes(p);
  p.sample->team_answered = was_pending && !switcher->pending();
}

/// @return whether the team has changed
bool TeamChange::changes(Period& p) noexcept {
  TeamSwitcher& switcher = *options_.team_switcher;
  const std::vector<TimedSignal>& signals = options_.signals;
  for (; signalled_ < signals.size() && signals[signalled_].at <= p.t + same_time; ++signalled_)
    (void)switcher.signal(signals[signalled_].name);
  const TeamDue due = clock_.team_due(p.k);
  if (due == TeamDue::not_yet || !switcher.swap(p.t, *p.estimate, p.u, due == TeamDue::now)) return false;
  std::copy(p.presence.begin(), p.presence.end(), before_.begin());
  follow(p);
  return true;
}

/// Takes presence, surroundings and limits from the team switcher.
void TeamChange::follow(Period& p) noexcept {
  const Membership& now = options_.team_switcher->present().membership;
  std::copy(now.presence.begin(), now.presence.end(), p.presence.begin());
  p.gate.set_limits(now.limits);
  world_.set_presence(p.presence);
  world_.surround(now.around);
  if (options_.localizer != nullptr) options_.localizer->set_presence(p.presence);
}

void TeamChange::join(Period& p) noexcept {
  if (!changed_) return;
  const std::span<const double> truth = p.seen.truth, measured = p.measured;
  const std::span<const double> x = truth.empty() ? measured : truth;
  for (int i = 0; i < static_cast<int>(before_.size()); ++i) {
    const BodyId body{i};
    const bool was_there = before_[size(i)] != Presence::absent;
    const bool is_there = p.presence[size(i)] != Presence::absent;
    if (!is_there) p.gate.rest(body, p.t, p.u);
    if (was_there || !is_there) continue;
    p.planned_at[size(i)] = p.t;
    if (options_.compensation != nullptr) options_.compensation->forget(body);
    on_join(body, x, p);
  }
  if (options_.guard == nullptr) return;
  options_.guard->follow(options_.team_switcher->present().membership, p.t,
                         options_.localizer != nullptr ? measured : x);
}

/// Reports a body that joins closer to another than its minimum distance.
/// @param x  true states, or else measured (nx)
void TeamChange::on_join(BodyId body, std::span<const double> x, Period& p) const noexcept {
  const Team& team = world_.team();
  const auto place = [&](BodyId of) {
    const double* const u = team.is_agent(of) ? &p.u[size(team.input_offset(of))] : nullptr;
    return team.model(of).sight(&x[size(team.state_offset(of))], u).p;
  };
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId other{i};
    if (other == body || p.presence[size(i)] == Presence::absent) continue;
    if (!team.is_agent(body) && !team.is_agent(other)) continue;
    const std::size_t decides = size(std::max(body.index, other.index));
    const double d = decides < options_.d_hard.size() ? options_.d_hard[decides] : LoopOptions::at_one_place;
    if (norm(place(body) - place(other)) >= d) continue;
    p.emit({p.t, EventKind::added_too_near, 0, static_cast<double>(body.index)});
    return;
  }
}

void TeamChange::look(Period& p) noexcept {
  if (options_.team_switcher == nullptr) return;
  std::transform(p.seen.stamps.begin(), p.seen.stamps.end(), ages_.begin(),
                 [&p](double stamp) { return p.t - stamp; });
  // A robot on a link joins where it holds.
  if (world_.absent_robots_stay() && !options_.team_switcher->pending())
    options_.team_switcher->set_start(p.measured);
  options_.team_switcher->look(p.t, *p.estimate, p.u,
                               options_.guard != nullptr ? options_.guard->ages() : std::span(ages_));
  for (const Event& event : options_.team_switcher->events()) p.emit(event);
  options_.team_switcher->clear_events();
}

}  // namespace sightline::stages
