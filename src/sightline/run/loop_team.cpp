// The parts of the loop that change its team.
#include <algorithm>

#include "sightline/base/index.hpp"
#include "sightline/base/same_time.hpp"
#include "sightline/run/loop.hpp"

namespace sightline {

/// Sends signals, and applies a change that was requested a period ago. @return whether the team
/// has changed
bool Loop::change_team(std::int64_t k, double t) noexcept {
  TeamSwitcher& team_switcher = *options_.team_switcher;
  for (; signalled_ < options_.signals.size() && options_.signals[signalled_].at <= t + same_time;
       ++signalled_) {
    (void)team_switcher.signal(options_.signals[signalled_].name);
  }
  const TeamDue due = clock_.team_due(k);
  if (due == TeamDue::not_yet || !team_switcher.swap(t, *estimate_, u_, due == TeamDue::now)) return false;
  std::copy(presence_.begin(), presence_.end(), presence_before_.begin());
  follow_team();
  return true;
}

/// Takes presence, surroundings and limits from the team switcher.
void Loop::follow_team() noexcept {
  const Membership& now = options_.team_switcher->present().membership;
  std::copy(now.presence.begin(), now.presence.end(), presence_.begin());
  gate_.set_limits(now.limits);
  world_.set_presence(presence_);
  world_.surround(now.around);
  if (options_.localizer != nullptr) options_.localizer->set_presence(presence_);
}

/// Updates plan times, compensation and guard for a new team, once the world is measured.
/// @param x  states for the distance check: true, or else measured (nx)
/// @param known  states that the guard takes for the bodies that join (nx)
void Loop::follow_guard(double t, std::span<const double> x, std::span<const double> known) noexcept {
  const Team& team = world_.team();
  for (int i = 0; i < team.bodies(); ++i) {
    const bool was_there = presence_before_[size(i)] != Presence::absent;
    const bool is_there = presence_[size(i)] != Presence::absent;
    if (!is_there) gate_.rest(BodyId{i}, t, u_);
    if (was_there || !is_there) continue;
    planned_at_[size(i)] = t;
    if (options_.compensation != nullptr) options_.compensation->forget(BodyId{i});
    on_join(BodyId{i}, t, x);
  }
  if (options_.guard != nullptr)
    options_.guard->follow(options_.team_switcher->present().membership, t, known);
}

/// Reports a body that joins closer to another than its minimum distance.
void Loop::on_join(BodyId body, double t, std::span<const double> x) noexcept {
  const Team& team = world_.team();
  const auto place = [&](BodyId of) {
    const double* const u = team.is_agent(of) ? &u_[size(team.input_offset(of))] : nullptr;
    return team.model(of).sight(&x[size(team.state_offset(of))], u).p;
  };
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId other{i};
    if (other == body || presence_[size(i)] == Presence::absent) continue;
    if (!team.is_agent(body) && !team.is_agent(other)) continue;
    const std::size_t decides = size(std::max(body.index, other.index));
    const double d = decides < options_.d_hard.size() ? options_.d_hard[decides] : LoopOptions::at_one_place;
    if (norm(place(body) - place(other)) >= d) continue;
    emit({t, EventKind::added_too_near, 0, static_cast<double>(body.index)});
    return;
  }
}

}  // namespace sightline
