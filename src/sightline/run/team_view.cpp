#include "sightline/run/team_view.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr double nearly = 1e-6;   // [m], [s], [m/s] by which a bound may be missed
constexpr double settling = 0.5;  // after the robot moved otherwise than the bounds allow [s]

/// Greatest way from an estimate to a measurement, if the target keeps its bounds.
ViewBounds::Known followed_within(ViewBounds bounds, double dt) {
  bounds.age = bounds.spread = 0.0;
  ViewBounds::Known followed = bounds.known(dt);
  followed.radius += bounds.error, followed.height += bounds.error;
  return followed;
}

}  // namespace

void validate_views(const Team& team, const GuardOptions& options) {
  std::vector<char> observes(size(team.bodies()));
  for (const CertifiedView& view : options.views) {
    if (view.filter == nullptr)
      throw_invalid("a certified view of \"{}\" without a filter, expected one", team.name(view.observer));
    if (std::exchange(observes[at(view.observer)], 1) != 0)
      throw_invalid("a second certified view of \"{}\", expected one for each observer",
                    team.name(view.observer));
  }
}

TeamView::TeamView(const Team& team, const GuardOptions& options) : team_(team), options_(options) {
  for (int i = 0; i < team_.bodies(); ++i)
    no_inputs_.resize(std::max(no_inputs_.size(), size(team_.model(BodyId{i}).nu()) + 1));
  for (const CertifiedView& view : options_.views) {
    const Agent& agent = team_.agent(view.observer);
    const std::size_t nu = size(agent.model.nu());
    observers_.push_back({.view = &view,
                          .robot = team_.agent_index(view.observer),
                          .x = size(team_.state_offset(view.observer)),
                          .u = size(team_.input_offset(view.observer)),
                          .nx = size(agent.model.nx()),
                          .nu = nu,
                          .u_min = std::vector<double>(nu),
                          .u_max = std::vector<double>(nu),
                          .next = std::vector<double>(nu),
                          .limits = &agent.limits,
                          .estimate = SlowEstimate(view.bounds, options_.period),
                          .own = SlowState(agent.model, view.filter->certificate().task),
                          .most_lag = view_prediction(view.bounds, options_.period).lag,
                          .known = view.bounds.known(options_.period),
                          .followed = followed_within(view.bounds, options_.period)});
  }
  records_.resize(team_.agents().size());
  changes_.reserve(observers_.size());
}

void TeamView::set_limits(std::span<const InputLimits> limits) noexcept {
  for (Observer& of : observers_) of.limits = &limits[of.robot];
}

/// Takes the position of the target, and finds what is not as the certificate assumes.
void TeamView::see(double t, const TeamSituation& now, Observer& of) const noexcept {
  const BodyId robot = of.view->observer, target = of.view->target;
  const double own_age = now.ages[at(robot)], age = now.ages[at(target)];
  of.missed = ViewReserve::age;
  const bool was_known =
      std::exchange(of.is_known, now.presence[at(robot)] == Presence::steered &&
                                     now.levels[at(robot)] <= FallbackLevel::predicted &&
                                     now.is_there(target) && std::isfinite(own_age) && std::isfinite(age));
  if (!of.is_known) return;
  const bool is_agent = team_.is_agent(target);
  const std::span<const double> states = is_agent ? now.x : now.estimated;
  const Sight<double> seen =
      team_.model(target).sight(&states[size(team_.state_offset(target))], no_inputs_.data());
  const ViewTarget before = of.target;
  const double elapsed = t - std::exchange(of.seen_at, t);
  const bool follows = was_known && elapsed < 1.5 * options_.period;
  if (!follows) of.estimate = SlowEstimate(of.view->bounds, options_.period);
  of.target = {of.estimate.follow(seen.p), {seen.v.x, seen.v.y}};

  const ViewBounds& bounds = of.view->bounds;
  const double delay = options_.command_delays.empty() ? 0.0 : options_.command_delays[at(robot)];
  const std::span<const double> own = now.x.subspan(of.x, of.nx);
  if (follows)
    of.own.follow(of.next, own, own_age + delay > nearly);
  else
    of.own.begin(own);
  const bool is_present = own_age <= nearly || options_.supervisor.has_value();
  if (!is_present || std::max(own_age, is_agent ? 0.0 : age) + delay > bounds.age + nearly ||
      age > bounds.age + nearly)
    return;
  of.missed = ViewReserve::motion;
  if (of.own.lag() > of.most_lag + nearly) {
    of.own.begin(own);
    of.left_at = t;
  }
  if (t - of.left_at < settling) return;
  of.missed = ViewReserve::error;
  if (3 * norm(now.sigmas[at(robot)], now.sigmas[at(target)]) > bounds.error) return;
  of.missed = ViewReserve::command;
  if (!follows) return;
  const Vec3<double> moved = of.target.p - before.p;
  const Vec3<double> ahead = seen.p - of.target.p;
  bool keeps = norm(ahead.x, ahead.y) <= of.followed.radius + nearly &&
               std::abs(ahead.z) <= of.followed.height + nearly &&
               norm(moved.x, moved.y) <= of.known.speed * elapsed + nearly &&
               std::abs(moved.z) <= of.known.climb * elapsed + nearly;
  if (bounds.is_velocity_measured()) {
    const Vec2<double>&v = of.target.v, &w = before.v;
    keeps = keeps && norm(v.x, v.y) <= bounds.speed + nearly &&
            norm(v.x - w.x, v.y - w.y) <= bounds.acceleration * elapsed + nearly;
  }
  if (!keeps) of.missed = ViewReserve::speed;
}

void TeamView::keep_views(double t, const TeamSituation& now, std::span<double> u) noexcept {
  for (Observer& of : observers_) {
    ViewRecord& record = records_[of.robot];
    record = {};
    see(t, now, of);
    if (!of.is_known) continue;
    now.limit(*of.limits, t, of.u, of.u_min, of.u_max);
    const std::span<double> applied = u.subspan(of.u, of.nu);
    std::copy(applied.begin(), applied.end(), of.next.begin());
    const ViewFilterResult result =
        of.view->filter->filter(of.own.state(), of.target, of.u_min, of.u_max, of.next);
    if (result.reserve < -nearly && of.view->outside == OutsideView::solver) continue;
    record.active = result.active;
    std::copy(of.next.begin(), of.next.end(), applied.begin());
  }
}

void TeamView::judge(std::span<const double> u) noexcept {
  changes_.clear();
  for (Observer& of : observers_) {
    ViewRecord& record = records_[of.robot];
    std::copy_n(u.begin() + static_cast<std::ptrdiff_t>(of.u), of.nu, of.next.begin());
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
    changes_.push_back({of.view->observer, record.certified});
  }
}

}  // namespace sightline
