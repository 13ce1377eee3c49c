#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/supervisor.hpp"

namespace sightline {
namespace {

constexpr double brake_time = 0.4;     // time constant of the velocity [s]
constexpr double least_sweep = 0.4;    // to either side [rad]
constexpr double deviations_away = 5;  // from this distance, two deviations to either side are within 0.4 rad
constexpr double turn_memory = 1.0;    // [s]
constexpr double fastest_turn = 10.0;  // [rad/s]
constexpr double heading_gain = 3.0;   // [1/s]
constexpr double turning_part = 0.3;   // least achieved part of the requested turn rate
constexpr double turning_time = 1.0;   // time for this test [s]

double heading_of(const Sight<double>& sight) noexcept { return std::atan2(sight.d.y, sight.d.x); }

double within_pi(double angle) noexcept { return std::remainder(angle, 2 * std::numbers::pi); }

/// Whether the robot follows a requested turn rate, at rest at the origin.
bool can_turn(const Model& model, Brake& brake, std::span<const double> u_min, std::span<const double> u_max,
              double rate) {
  std::vector<double> x(size(model.nx())), u(size(model.nu()));
  model.at_rest({{}, {1.0, 0.0}}, x.data());
  constexpr int steps = 100;
  double turned = 0.0;
  for (int k = 0; k < steps; ++k) {
    brake(x, {}, u_min, u_max, u, rate);
    const double before = heading_of(model.sight(x.data(), u.data()));
    model.step(x.data(), u.data(), turning_time / steps);
    turned += within_pi(heading_of(model.sight(x.data(), u.data())) - before);
  }
  return turned > turning_part * rate * turning_time;
}

}  // namespace

void validate(const Team& team, std::span<const BodyId> robots, const SearchOptions& options) {
  options.check();
  for (const BodyId body : robots) {
    if (body.index < 0 || body.index >= team.bodies() || !team.is_agent(body))
      throw_invalid("a robot that searches has the number {}, expected a robot of the team", body.index);
    const Agent& agent = team.agent(body);
    if (agent.u_ref.size() > Brake::inputs_max)
      throw_invalid("\"{}\" has {} inputs, expected at most {} of a robot that is localized by vision",
                    agent.name, agent.u_ref.size(), Brake::inputs_max);
    Brake brake(agent.model, agent.u_ref, brake_time);
    if (!can_turn(agent.model, brake, agent.limits.u_min().front(), agent.limits.u_max().front(),
                  options.rate))
      throw_invalid(
          "\"{}\" is localized by vision, but its model \"{}\" does not turn where it stands by {} rad/s, "
          "expected one that does: it could not find what it observes",
          agent.name, agent.model.name(), options.rate);
  }
}

Search::Search(const Team& team, std::span<const BodyId> robots, const SearchOptions& options)
    : team_(team), options_(options) {
  validate(team_, robots, options);
  std::size_t longest = 0;
  for (int i = 0; i < team_.bodies(); ++i) longest = std::max(longest, size(team_.model(BodyId{i}).nu()));
  u_rest_.resize(longest);
  for (const BodyId body : robots) {
    const Agent& agent = team_.agent(body);
    robots_.push_back({.body = body,
                       .x = size(team_.state_offset(body)),
                       .u = size(team_.input_offset(body)),
                       .nx = size(agent.model.nx()),
                       .nu = agent.u_ref.size(),
                       .brake = Brake(agent.model, agent.u_ref, brake_time),
                       .limits = &agent.limits,
                       .u_min = agent.limits.u_min().front(),
                       .u_max = agent.limits.u_max().front()});
  }
}

void Search::follow(const Membership& now) noexcept {
  for (Robot& robot : robots_) {
    const bool was = robot.is_there;
    robot.is_there = now.presence[size(robot.body.index)] != Presence::absent;
    robot.limits = &now.limits[team_.agent_index(robot.body)];
    if (was == robot.is_there) continue;
    robot.view = {};
    robot.since = View::never;
    robot.phase = SearchPhase::none;
    robot.contradicted = false;
  }
}

Sight<double> Search::sight(BodyId body, std::span<const double> x) const noexcept {
  return team_.model(body).sight(&x[size(team_.state_offset(body))], u_rest_.data());
}

SearchPhase Search::next(const Robot& robot, double t) const noexcept {
  const View& view = robot.view;
  if (!view.localized || robot.contradicted)
    return t - std::max(view.sighted, robot.since) < in_view ? SearchPhase::stand : SearchPhase::turn;
  if (t - view.accepted <= options_.predict) return SearchPhase::none;
  const bool swept = robot.phase == SearchPhase::sweep || robot.phase == SearchPhase::round;
  return swept && t - robot.begun > options_.turn_after ? SearchPhase::round : SearchPhase::sweep;
}

/// Updates the recent turn within turn_memory; the jump of a restarted filter does not count.
void Search::follow_turn(Robot& robot, double t, double heading) noexcept {
  const double dt = t - std::exchange(robot.time, t);
  const double turn = within_pi(heading - std::exchange(robot.heading, heading));
  if (!(dt >= 0 && dt < turn_memory)) {
    robot.turned = 0.0;
    return;
  }
  robot.turned *= 1 - dt / turn_memory;
  if (std::abs(turn) <= fastest_turn * dt) robot.turned += turn;
}

void Search::look(double t, std::span<const View> views, std::span<const double> x) noexcept {
  for (Robot& robot : robots_) {
    const auto reported =
        std::find_if(views.begin(), views.end(), [&](const View& of) { return of.robot == robot.body; });
    if (!robot.is_there || reported == views.end()) continue;
    if (robot.since == View::never) robot.since = t;
    const View before = std::exchange(robot.view, *reported);
    const View& view = robot.view;
    const Sight<double> own = sight(robot.body, x);
    follow_turn(robot, t, heading_of(own));
    if (view.accepted > before.accepted) robot.distance_seen = norm(own.p - sight(view.target, x).p);
    if (!view.localized || view.accepted > before.accepted)
      robot.contradicted = false;
    else if (view.sighted - view.accepted > contradicted_after)
      robot.contradicted = true;
    const SearchPhase was = std::exchange(robot.phase, next(robot, t));
    if (robot.phase == SearchPhase::sweep && view.bearing_sigma <= options_.sweep_from) robot.begun = t;
    if (robot.phase == was || robot.phase == SearchPhase::round) continue;
    robot.begun = t;
    robot.from = robot.turned > 0 ? -1.0 : 1.0;
    if (robot.phase != SearchPhase::sweep) continue;
    robot.away = own.p - sight(view.target, x).p;
    robot.away = (1 / std::max(norm(robot.away), 1e-3)) * robot.away;
  }
}

/// Turn rate of the search, to the left [rad/s].
double Search::turn_rate(const Robot& robot, double t, const Sight<double>& own,
                         const Vec3<double>& target) const noexcept {
  if (robot.phase == SearchPhase::stand) return 0.0;
  if (robot.phase == SearchPhase::turn || robot.phase == SearchPhase::round)
    return robot.from * options_.rate;
  double wanted = std::atan2(target.y - own.p.y, target.x - own.p.x);
  const double sigma = robot.view.bearing_sigma;
  if (sigma > options_.sweep_from) {
    // Sweeps from one side to the other at the given rate.
    const double most = std::clamp(2 * sigma, least_sweep, std::numbers::pi);
    const double lap = 4 * most / options_.rate, part = std::fmod((t - robot.begun) / lap, 1.0);
    wanted += robot.from * most * (part < 0.25 ? 4 * part : part < 0.75 ? 2 - 4 * part : 4 * part - 4);
  }
  return std::clamp(heading_gain * within_pi(wanted - robot.view.azimuth - heading_of(own)), -options_.rate,
                    options_.rate);
}

void Search::command(double t, std::span<const double> x, std::span<const FallbackLevel> levels,
                     std::span<const double> added, std::span<double> u) noexcept {
  for (Robot& robot : robots_) {
    const FallbackLevel level = levels[size(robot.body.index)];
    if (!robot.is_there || robot.phase == SearchPhase::none || level >= FallbackLevel::land) continue;
    robot.limits->at(t, robot.u_min, robot.u_max);
    for (std::size_t k = 0; k < robot.nu; ++k)
      robot.u_min[k] -= added[robot.u + k], robot.u_max[k] -= added[robot.u + k];
    const Sight<double> own = sight(robot.body, x), target = sight(robot.view.target, x);
    Vec3<double> velocity{};
    const bool sweeps = robot.phase == SearchPhase::sweep || robot.phase == SearchPhase::round;
    if (sweeps && level < FallbackLevel::hold) {
      const double far = std::clamp(deviations_away * robot.view.position_sigma, robot.distance_seen,
                                    robot.distance_seen + options_.back_off);
      const Vec3<double> way = (1 / approach) * (target.p + far * robot.away - own.p);
      const double speed = norm(way);
      velocity = target.v + (speed > fastest ? fastest / speed : 1.0) * way;
    }
    robot.brake(x.subspan(robot.x, robot.nx), velocity, robot.u_min, robot.u_max,
                u.subspan(robot.u, robot.nu), turn_rate(robot, t, own, target.p));
  }
}

}  // namespace sightline
