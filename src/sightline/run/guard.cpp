#include <algorithm>
#include <cmath>
#include <memory>

#include "sightline/base.hpp"
#include "sightline/loop.hpp"
#include "sightline/run/team_barrier.hpp"
#include "sightline/run/team_view.hpp"

namespace sightline {
namespace {

GuardOptions completed(const Team& team, GuardOptions options) {
  options.bodies.resize(static_cast<std::size_t>(team.bodies()));
  return options;
}

std::optional<Supervisor> supervisor_of(const Team& team, const GuardOptions& options) {
  if (!options.supervisor) return std::nullopt;
  SupervisorOptions supervisor = *options.supervisor;
  supervisor.command_delays = options.command_delays;
  return std::optional<Supervisor>(std::in_place, team, supervisor);
}

EventKind kind_of(FallbackLevel level) {
  switch (level) {
    case FallbackLevel::valid:
      return EventKind::valid;
    case FallbackLevel::predicted:
      return EventKind::predicted;
    case FallbackLevel::slowed:
      return EventKind::slowed;
    case FallbackLevel::hold:
      return EventKind::hold;
    case FallbackLevel::land:
      return EventKind::land;
    case FallbackLevel::grounded:
      break;
  }
  return EventKind::grounded;
}

EventKind kind_of(MeasurementFault fault) {
  switch (fault) {
    case MeasurementFault::none:  // never in a notice
    case MeasurementFault::not_finite:
      return EventKind::measurement_not_finite;
    case MeasurementFault::heading:
      return EventKind::measurement_heading;
    case MeasurementFault::world:
      return EventKind::measurement_world;
    case MeasurementFault::speed:
      return EventKind::measurement_speed;
    case MeasurementFault::jump:
      return EventKind::measurement_jump;
    case MeasurementFault::frozen:
      return EventKind::measurement_frozen;
    case MeasurementFault::time:
      break;
  }
  return EventKind::measurement_time;
}

EventKind kind_of(const Notice& notice) {
  return std::visit([](auto what) { return kind_of(what); }, notice.what);
}

}  // namespace

void validate(const Team& team, const GuardOptions& options) {
  if (options.supervisor) validate(team, *options.supervisor);
  validate(team, options.searchers, options.search);
  if (options.barrier != BarrierMode::off) validate_barriers(team, options);
  validate_views(team, options);
}

Guard::Guard(const Team& team, const GuardOptions& options)
    : team_(team),
      options_(completed(team, options)),
      stale_(options_.bodies.size()),
      supervisor_(supervisor_of(team, options)),
      search_(team_, options_.searchers, options_.search),
      searches_(options_.searchers.size()),
      estimated_(team, std::vector<double>(static_cast<std::size_t>(team.nx()))),
      seen_(estimated_),
      ages_(options_.bodies.size()),
      stamps_(options_.bodies.size()),
      sigmas_(options_.bodies.size()),
      presence_(options_.bodies.size(), Presence::steered),
      levels_(options_.bodies.size(), FallbackLevel::valid) {
  events_.reserve(4 * options_.bodies.size());
  if (options_.barrier != BarrierMode::off) barrier_ = std::make_unique<TeamBarrier>(team_, options_);
  if (!options_.views.empty()) view_ = std::make_unique<TeamView>(team_, options_);
}

Guard::~Guard() = default;

const ValidStates& Guard::accept_measurement(double t, std::span<const double> measured,
                                             std::span<const double> stamps, std::span<const double> sigma,
                                             std::span<const PoseEstimate> poses) noexcept {
  events_.clear();
  if (view_) view_->accept_poses(poses);
  if (sigma.empty())
    std::fill(sigmas_.begin(), sigmas_.end(), 0.0);
  else
    std::copy(sigma.begin(), sigma.end(), sigmas_.begin());
  if (supervisor_) {
    const std::span<const double> estimate = supervisor_->accept_measurement(t, measured, stamps, sigma);
    for (std::size_t i = 0; i < ages_.size(); ++i) {
      ages_[i] = std::max(0.0, supervisor_->age(BodyId{static_cast<int>(i)}));
      stamps_[i] = t - ages_[i];
    }
    see_absent(t, measured, stamps);
    return estimated_.take(estimate, stamps_);
  }
  (void)estimated_.take(measured, stamps);
  awaits_position_ = false;
  for (std::size_t i = 0; i < ages_.size(); ++i) {
    const bool known = !std::isinf(sigmas_[i]);
    ages_[i] = known ? std::max(0.0, t - estimated_.stamps()[i]) : infinity;
    awaits_position_ |= !known && presence_[i] != Presence::absent;
  }
  see_absent(t, measured, stamps);
  return estimated_;
}

/// Takes the measured states of absent robots that stay in the world.
void Guard::see_absent(double t, std::span<const double> measured, std::span<const double> stamps) noexcept {
  if (!options_.absent_robots_stay) return;
  (void)seen_.take(measured, stamps);
  for (int i = 0; i < team_.bodies(); ++i)
    if (!is_there(BodyId{i})) ages_[at(i)] = std::max(0.0, t - seen_.stamps()[at(i)]);
}

void Guard::follow(const Membership& now, double t, std::span<const double> x) noexcept {
  std::copy(now.presence.begin(), now.presence.end(), presence_.begin());
  if (barrier_) barrier_->set_limits(now.limits);
  if (view_) view_->follow(now);
  if (supervisor_) supervisor_->follow(now, t, x);
  search_.follow(now);
}

void Guard::look(double t, std::span<const View> views) noexcept {
  search_.look(t, views, estimated_);
  for (int i = 0; i < search_.robots(); ++i) {
    const SearchPhase phase = search_.phase(i);
    const bool ends = phase == SearchPhase::none;
    if (phase == SearchPhase::stand || ends != searches_[at(i)]) continue;
    searches_[at(i)] = !ends;
    emit({t, ends ? EventKind::found : EventKind::search, 0, static_cast<double>(search_.robot(i).index)});
  }
}

/// Reports bodies whose messages become stale, and those that are received again.
void Guard::emit_stale(double t) noexcept {
  for (int i = 0; connectivity_ != nullptr && i < team_.bodies(); ++i) {
    const bool stale = is_there(BodyId{i}) && !connectivity_->is_received(BodyId{i});
    if (stale == (stale_[at(i)] != 0)) continue;
    stale_[at(i)] = stale;
    emit({t, stale ? EventKind::stale : EventKind::received, 0, static_cast<double>(i)});
  }
}

void Guard::fall_back(double t, const ValidStates& x, std::span<const double> plan_ages,
                      std::span<const double> added, std::span<double> u) noexcept {
  if (supervisor_) {
    supervisor_->command(t, x, plan_ages, added, u);
    for (const Notice& notice : supervisor_->notices()) {
      emit({t, kind_of(notice), 0, static_cast<double>(notice.body.index)});
    }
    for (int i = 0; i < team_.bodies(); ++i) {
      const BodyId body{i};
      if (team_.is_agent(body)) levels_[at(body)] = supervisor_->level(body);
    }
  }
  search_.command(t, x, levels_, added, u);
  emit_stale(t);
}

void Guard::keep_distances(double t, const ValidStates& x, std::span<const double> added,
                           std::span<double> u) noexcept {
  std::span<const double> absent;
  if (options_.absent_robots_stay) absent = seen_;
  const TeamSituation now = {x, estimated_, absent, ages_, sigmas_, presence_, levels_, added, connectivity_};
  if (view_) view_->keep_views(t, now, u);
  if (barrier_) {
    barrier_->keep_distances(t, now, u);
    for (const BodyId robot : barrier_->conflicts())
      emit({t, EventKind::barrier_conflict, 0, static_cast<double>(robot.index)});
  }
  if (!view_) return;
  view_->judge(u);
  for (const TeamView::Change& change : view_->changes())
    emit({t, change.kind, 0, static_cast<double>(change.robot.index)});
}

std::span<const BarrierRecord> Guard::barriers() const noexcept {
  return barrier_ ? barrier_->records() : std::span<const BarrierRecord>{};
}

std::span<const ViewRecord> Guard::views() const noexcept {
  return view_ ? view_->records() : std::span<const ViewRecord>{};
}

void Guard::record(double t, std::span<const double> u) noexcept {
  if (supervisor_) supervisor_->record(t, u);
}

void Guard::emit(const Event& event) noexcept {
  if (events_.size() < events_.capacity()) events_.push_back(event);
}

}  // namespace sightline
