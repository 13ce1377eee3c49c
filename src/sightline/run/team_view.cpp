#include "sightline/run/team_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr double nearly = 1e-6;        // [m], [s], [m/s] by which a bound may be missed
constexpr double settling_time = 0.5;  // after the robot moved otherwise than the bounds allow [s]

/// Greatest way from an estimate to a measurement, if the target keeps its bounds.
ViewBounds::Known followed_within(ViewBounds bounds, double dt) {
  bounds.age = bounds.spread = 0.0;
  ViewBounds::Known followed = bounds.known(dt);
  followed.radius += bounds.error, followed.height += bounds.error;
  return followed;
}

}  // namespace

void validate_views(const Team& team, const GuardOptions& options) {
  for (const CertifiedView& view : options.views) {
    if (view.filter == nullptr)
      throw_invalid("a certified view of \"{}\" without a filter, expected one", team.name(view.observer));
    const auto same = [&](const CertifiedView& other) {
      return other.observer == view.observer && other.target == view.target;
    };
    if (std::count_if(options.views.begin(), options.views.end(), same) > 1)
      throw_invalid("a second certified view of \"{}\" by \"{}\", expected one", team.name(view.target),
                    team.name(view.observer));
  }
}

SlowDownOptions slow_down_options(const CertifiedView& view, double period) {
  return {.speed = view.bounds.speed,
          .unrequested = view.unrequested,
          .climb = view.bounds.climb,
          .slowing = view.slowing,
          .delay = view.request_delay,
          .period = period};
}

TeamView::TeamView(const Team& team, const GuardOptions& options) : team_(team), options_(options) {
  for (int i = 0; i < team_.bodies(); ++i)
    no_inputs_.resize(std::max(no_inputs_.size(), size(team_.model(BodyId{i}).nu()) + 1));
  for (const CertifiedView& view : options_.views) {
    const Agent& agent = team_.agent(view.observer);
    const std::size_t nu = size(agent.model.nu());
    const std::size_t robot = team_.agent_index(view.observer);
    const bool is_first = !has_view_in_force(robot);
    const ViewTask& task = view.filter->certificate().task;
    observers_.push_back({.view = &view,
                          .is_observed = is_first,
                          .is_in_force = is_first,
                          .robot = robot,
                          .x = size(team_.state_offset(view.observer)),
                          .u = size(team_.input_offset(view.observer)),
                          .nx = size(agent.model.nx()),
                          .nu = nu,
                          .u_min = std::vector<double>(nu),
                          .u_max = std::vector<double>(nu),
                          .next = std::vector<double>(nu),
                          .limits = &agent.limits,
                          .estimate = SlowEstimate(task.bounds, options_.period),
                          .own = SlowState(agent.model, task),
                          .most_lag = view_prediction(task.bounds, options_.period).lag,
                          .known = task.bounds.known(options_.period),
                          .followed = followed_within(task.bounds, options_.period)});
    if (!task.odometry.is_used()) continue;
    observers_.back().odometry.emplace(agent.model, task);
    observers_.back().most_lag = task.odometry.velocity_error(view.bounds, options_.period) +
                                 task.odometry.velocity + view.bounds.wind * task.odometry.delay;
  }
  for (Observer& of : observers_) {
    if (!of.view->is_on_request()) continue;
    const auto [u_min, u_max] = tightest_limits(team_, of.view->target, options_.limits_to_come);
    of.slow_down.emplace(team_.model(of.view->target), u_min, u_max,
                         slow_down_options(*of.view, options_.period));
  }
  records_.resize(team_.agents().size());
  changes_.reserve(2 * observers_.size());
}

void TeamView::follow(const Membership& now) noexcept {
  for (Observer& of : observers_) {
    of.limits = &now.limits[of.robot];
    const std::vector<BodyId>& observed = now.observed[of.robot];
    of.is_observed = std::find(observed.begin(), observed.end(), of.view->target) != observed.end();
  }
}

bool TeamView::has_view_in_force(std::size_t robot) const noexcept {
  return std::any_of(observers_.begin(), observers_.end(),
                     [&](const Observer& of) { return of.robot == robot && of.is_in_force; });
}

/// Ends views and begins others, by what the robots observe.
void TeamView::choose_views() noexcept {
  for (Observer& of : observers_) {
    if (!of.is_in_force || of.is_observed) continue;
    bool is_awaited = false, is_taken = false, goes_on = false;
    for (const Observer& other : observers_) {
      if (!other.is_observed) continue;
      goes_on |= other.robot == of.robot;
      if (other.view->target != of.view->target) continue;
      is_awaited = true;
      is_taken |= other.is_in_force && other.was_certified;
    }
    if (of.was_certified && is_awaited && !is_taken) continue;
    of.is_in_force = false;
    if (of.was_certified && (is_taken || !goes_on))
      changes_.push_back(
          {of.view->observer, is_taken ? EventKind::view_handed_over : EventKind::view_uncertified});
  }
  for (Observer& of : observers_) {
    if (of.is_in_force || !of.is_observed || has_view_in_force(of.robot)) continue;
    of.is_in_force = true;
    of.is_known = of.is_judged = of.was_certified = false;
  }
}

/// Moves the point that the filter follows towards a target that may be faster than the bound until
/// it slows down: as far as the state stays in the set, and at least by the bound, which keeps it there.
void TeamView::approach(Observer& of, const Vec3<double>& p) const noexcept {
  const Vec3<double> from = of.target.p;
  const auto on_way = [&](double part) {
    return Vec3<double>{from.x + part * (p.x - from.x), from.y + part * (p.y - from.y), p.z};
  };
  const auto keeps_set = [&](double part) {
    const ViewReserves reserves = of.view->filter->reserves(of.own.state(), {on_way(part), {}});
    return *std::min_element(reserves.begin(), reserves.end()) >= 0;
  };
  const double way = norm(p.x - from.x, p.y - from.y), step = of.known.speed * options_.period;
  double sure = way > step ? step / way : 1.0, out = 1.0;
  if (sure < 1 && keeps_set(1.0)) sure = 1.0;
  constexpr int halvings = 8;
  for (int k = 0; k < halvings && sure < 1; ++k) {
    const double middle = 0.5 * (sure + out);
    (keeps_set(middle) ? sure : out) = middle;
  }
  of.target.p = sure < 1 ? on_way(sure) : p;
}

/// Follows the robot's own state, where the command takes effect.
/// @return the target's position, as measured, in the frame of that state
Vec3<double> TeamView::follow_own(const TeamSituation& now, Observer& of, bool follows,
                                  const Sight<double>& seen) const noexcept {
  const BodyId robot = of.view->observer;
  const std::span<const double> later = now.x.subspan(of.x, of.nx);
  if (!of.odometry) {
    const double delay = options_.command_delays.empty() ? 0.0 : options_.command_delays[at(robot)];
    if (follows)
      of.own.follow(of.next, later, now.ages[at(robot)] + delay > nearly);
    else
      of.own.begin(later);
    return seen.p;
  }
  const PoseEstimate& pose = poses_[at(robot)];
  if (follows)
    of.odometry->follow(pose);
  else
    of.odometry->begin(pose);
  const std::span<const double> own = of.odometry->carry(pose, now.estimated.subspan(of.x, of.nx), later);
  if (follows)
    of.own.follow(of.next, own, true);
  else
    of.own.begin(own);
  const Vec3<double> slow = team_.model(robot).sight(of.own.state().data(), no_inputs_.data()).p;
  return of.odometry->place(seen.p, {slow.x, slow.y});
}

/// Whether three standard deviations of what the view uses are within their bounds.
bool TeamView::is_sure(const TeamSituation& now, const Observer& of,
                       const Vec3<double>& target) const noexcept {
  const BodyId robot = of.view->observer;
  const double sigma = now.sigmas[at(of.view->target)], most = of.view->bounds.error;
  if (!of.odometry) return 3 * norm(now.sigmas[at(robot)], sigma) <= most;
  const PoseEstimate& pose = poses_[at(robot)];
  const ViewOdometry& limits = of.odometry->limits();
  const double of_heading = norm(pose.v.x, pose.v.y) * pose.heading_sigma();
  return 3 * norm(relative_sigma(pose, target), sigma) <= most &&
         3 * (pose.velocity_sigma + of_heading) <= limits.velocity && 3 * pose.yaw_rate_sigma <= limits.turn;
}

/// Takes the position of the target, and finds what is not as the certificate assumes.
void TeamView::see(double t, const TeamSituation& now, Observer& of) const noexcept {
  const BodyId robot = of.view->observer, target = of.view->target;
  const double own_age = now.ages[at(robot)], age = now.ages[at(target)];
  of.missed = ViewReserve::age;
  const bool was_known =
      std::exchange(of.is_known, now.presence[at(robot)] == Presence::steered &&
                                     now.levels[at(robot)] <= FallbackLevel::predicted &&
                                     now.is_there(target) && std::isfinite(own_age) && std::isfinite(age) &&
                                     (!of.odometry || (!poses_.empty() && poses_[at(robot)].known)));
  if (!of.is_known) return;
  const bool is_agent = team_.is_agent(target);
  const std::span<const double> states = is_agent ? now.x : now.estimated;
  const Sight<double> seen =
      team_.model(target).sight(&states[size(team_.state_offset(target))], no_inputs_.data());
  const ViewTarget before = of.target;
  const double elapsed = t - std::exchange(of.seen_at, t);
  const bool follows = was_known && elapsed < 1.5 * options_.period;
  const Vec3<double> measured = follow_own(now, of, follows, seen);
  if (!follows) of.estimate = SlowEstimate(of.view->filter->certificate().task.bounds, options_.period);
  const bool lags = of.slow_down && follows && of.was_certified;
  of.target = {lags ? before.p : of.estimate.follow(measured), {seen.v.x, seen.v.y}};

  const ViewBounds& bounds = of.view->bounds;
  const double delay = options_.command_delays.empty() ? 0.0 : options_.command_delays[at(robot)];
  if (lags) approach(of, seen.p);
  const Vec3<double>& ahead = of.ahead = measured - of.target.p;
  const bool is_present = own_age <= nearly || options_.supervisor.has_value();
  const bool is_late = !is_present || std::max(own_age, is_agent ? 0.0 : age) + delay > bounds.age + nearly ||
                       age > bounds.age + nearly;
  const bool sure = is_sure(now, of, seen.p);
  // What is wrong in such a period may last in the frame O, which begins anew.
  if (of.odometry && (is_late || !sure)) of.seen_at = -infinity;
  if (is_late && (sure || !of.odometry)) return;
  of.missed = ViewReserve::error;
  if (!sure) return;
  of.missed = ViewReserve::motion;
  if ((of.odometry ? of.own.velocity_lag() : of.own.lag()) > of.most_lag + nearly) {
    of.left_at = t;
    if (of.odometry)
      of.seen_at = -infinity;  // begins anew
    else
      of.own.begin(now.x.subspan(of.x, of.nx));
  }
  if (t - of.left_at < settling_time) return;
  // A target that is faster than it may be without requests gains more than `request_gain`.
  if (of.slow_down && !lags &&
      norm(seen.v.x, seen.v.y) > of.view->unrequested + bounds.wind * options_.period + nearly) {
    of.missed = ViewReserve::speed;
    return;
  }
  of.missed = ViewReserve::command;
  if (!follows) return;
  const Vec3<double> moved = of.target.p - before.p;
  bool keeps = std::abs(moved.z) <= of.known.climb * elapsed + nearly;
  if (of.slow_down)
    keeps = keeps && norm(ahead.x, ahead.y) <= of.view->request_gain + nearly;
  else
    keeps = keeps && norm(ahead.x, ahead.y) <= of.followed.radius + nearly &&
            std::abs(ahead.z) <= of.followed.height + nearly &&
            norm(moved.x, moved.y) <= of.known.speed * elapsed + nearly;
  if (bounds.is_velocity_measured()) {
    const Vec2<double>&v = of.target.v, &w = before.v;
    keeps = keeps && norm(v.x, v.y) <= bounds.speed + nearly &&
            norm(v.x - w.x, v.y - w.y) <= bounds.acceleration * elapsed + nearly;
  }
  if (!keeps) of.missed = ViewReserve::speed;
}

/// Requests the target to slow down while it is ahead of the point that the filter follows, and lets it.
void TeamView::slow_down(const TeamSituation& now, Observer& of, std::span<double> u) noexcept {
  const AgentId target{of.view->target};
  const Model& model = team_.model(target);
  // A target that brakes or lands on its own is judged, and goes on as it does.
  const bool obeys = now.presence[at(of.view->target)] == Presence::steered &&
                     now.levels[at(of.view->target)] < FallbackLevel::land;
  const bool is_ahead = norm(of.ahead.x, of.ahead.y) > 0;
  const std::span<double> command = u.subspan(size(team_.input_offset(target)), size(model.nu()));
  std::array<double, ViewFilter::most_inputs> unused{};
  std::copy(command.begin(), command.end(), unused.begin());
  records_[of.robot].requests = is_ahead && obeys;
  of.slow_down->filter(is_ahead, now.x.subspan(size(team_.state_offset(target)), size(model.nx())),
                       obeys ? command : std::span<double>(unused).first(command.size()));
}

/// Whether a command (nu) of a robot keeps the bounds of all that request it to slow down.
bool TeamView::keeps_requests(std::size_t robot, std::span<const double> u) const noexcept {
  return std::all_of(observers_.begin(), observers_.end(), [&](const Observer& of) {
    return !of.is_in_force || !of.is_known || !of.slow_down ||
           team_.agent_index(AgentId{of.view->target}) != robot || of.slow_down->keeps(u);
  });
}

void TeamView::keep_views(double t, const TeamSituation& now, std::span<double> u) noexcept {
  changes_.clear();
  choose_views();
  std::fill(records_.begin(), records_.end(), ViewRecord{});
  for (Observer& of : observers_) {
    if (!of.is_in_force) continue;
    records_[of.robot].target = of.view->target;
    see(t, now, of);
    if (of.is_known && of.slow_down) slow_down(now, of, u);
  }
  // A set needs no more than what its robot may do on request.
  for (Observer& of : observers_) {
    if (!of.is_in_force || !of.is_known) continue;
    ViewRecord& record = records_[of.robot];
    now.limit(*of.limits, t, of.u, of.u_min, of.u_max);
    const std::span<double> applied = u.subspan(of.u, of.nu);
    std::copy(applied.begin(), applied.end(), of.next.begin());
    // An estimate that is too uncertain may mislead; the search for the target goes on.
    if (of.odometry && of.missed == ViewReserve::error) continue;
    const ViewFilterResult result =
        of.view->filter->filter(of.own.state(), of.target, of.u_min, of.u_max, of.next);
    if (result.reserve < -nearly &&
        (of.view->outside == OutsideView::solver || !keeps_requests(of.robot, of.next)))
      continue;
    record.active = result.active;
    std::copy(of.next.begin(), of.next.end(), applied.begin());
  }
}

void TeamView::judge(std::span<const double> u) noexcept {
  for (Observer& of : observers_) {
    if (!of.is_in_force) continue;
    ViewRecord& record = records_[of.robot];
    std::copy_n(u.begin() + static_cast<std::ptrdiff_t>(of.u), of.nu, of.next.begin());
    if (of.is_known && of.slow_down && of.missed == ViewReserve::command) {
      const AgentId target{of.view->target};
      const std::size_t nu = size(team_.model(target).nu());
      if (!of.slow_down->keeps(u.subspan(size(team_.input_offset(target)), nu)))
        of.missed = ViewReserve::speed;
    }
    record.least = of.missed;
    if (of.is_known) {
      const ViewFilterResult result =
          of.view->filter->judge(of.own.state(), of.target, u.subspan(of.u, of.nu));
      record.reserve = result.reserve;
      record.certified = result.certified && of.missed == ViewReserve::command;
      if (of.missed == ViewReserve::command && (result.certified || result.reserve < 0))
        record.least = result.least;
    }
    if (of.is_judged && of.was_certified == record.certified) continue;
    of.is_judged = true, of.was_certified = record.certified;
    changes_.push_back(
        {of.view->observer, record.certified ? EventKind::view_certified : EventKind::view_uncertified});
  }
}

}  // namespace sightline
