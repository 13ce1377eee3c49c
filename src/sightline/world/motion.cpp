#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/potential.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

/// Vector of the given length in the direction of a; along +x if a is 0.
Vec3<double> along(const Vec3<double>& a, double length) {
  const double size = norm(a);
  return size > 0 ? (length / size) * a : Vec3<double>{length, 0, 0};
}

/// Velocity of a pursuit that stops at the standoff within dt.
Vec3<double> pursue(const Vec3<double>& to_robot, double speed, double standoff, double dt) {
  const double gap = norm(to_robot) - standoff;
  return gap > 0 ? along(to_robot, std::min(speed, gap / dt)) : Vec3<double>{};
}

/// Vector from a body at the origin to the point where it meets, at this speed, a body at q with
/// velocity w. Returns q if they cannot meet.
Vec3<double> meeting_place(const Vec3<double>& q, const Vec3<double>& w, double speed) {
  // |q + w T| = speed T for the least T > 0.
  const double a = square(speed) - dot(w, w), b = dot(q, w), c = dot(q, q);
  const double root = b * b + a * c;
  if (!(root >= 0)) return q;
  const double denominator = std::sqrt(root) - b;  // T = c / (sqrt(b^2 + a c) - b), valid also for a = 0
  return denominator > 0 ? q + (c / denominator) * w : q;
}

/// Uniformly distributed direction.
Vec3<double> any_way(RandomStream& chance, AdversaryMotion::Within within) {
  const SinCos<double> turn = sincos(2 * std::numbers::pi * chance.uniform());
  if (within == AdversaryMotion::Within::plane) return {turn.cos, turn.sin, 0};
  const double z = 2 * chance.uniform() - 1, level = std::sqrt(1 - z * z);
  return {level * turn.cos, level * turn.sin, z};
}

std::vector<Vec3<double>> corners(const PathMotion& path) {
  std::vector<Vec3<double>> points = path.points;
  if (path.end == PathMotion::End::round) points.push_back(points.front());
  return points;
}

AgentId followed_by(const Motion& motion) {
  return std::visit(
      [](const auto& m) {
        if constexpr (requires { m.agent; }) return m.agent;
        return AgentId{};
      },
      motion);
}

}  // namespace

void PathMotion::check() const {
  if (points.size() < 2) throw std::invalid_argument("path.points has fewer than two, expected two or more");
  check_parameters(*this);
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) length += norm(points[i] - points[i - 1]);
  require(length > 0, name, "points", length, "points that are not all the same, a length > 0 m");
}

std::optional<Vec3<double>> start_of(const Motion& motion) {
  if (const auto* path = std::get_if<PathMotion>(&motion)) return path->points.front();
  if (const auto* waypoints = std::get_if<WaypointsMotion>(&motion)) return (*waypoints)(0.0).p;
  if (const auto* circle = std::get_if<CircleMotion>(&motion)) {
    const SinCos<double> a = sincos(circle->phase);
    return circle->centre + circle->radius * Vec3<double>{a.cos, a.sin, 0};
  }
  return {};
}

double top_speed(const Motion& motion) {
  if (const auto* circle = std::get_if<CircleMotion>(&motion))
    return circle->radius * std::fabs(circle->rate);
  return std::visit(
      [](const auto& m) {
        if constexpr (requires { m.speed; }) return m.speed;
        if constexpr (requires { m.top_speed(); }) return m.top_speed();
        return 0.0;
      },
      motion);
}

Motions::Motions(const Team& team, std::vector<BodyMotion> motions, std::uint64_t seed,
                 const std::vector<double>& speed_max) {
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    if (team.is_agent(body)) continue;
    const std::size_t place = carried_.size();
    Carried& one = carried_.emplace_back();
    one.x = static_cast<std::size_t>(team.state_offset(body));
    if (place < speed_max.size() && speed_max[place] > 0) one.speed_max = speed_max[place];
    one.move.body = body;
  }
  for (BodyMotion& one : motions) {
    if (one.body.index < 0 || one.body.index >= team.bodies() || team.is_agent(one.body)) {
      throw std::invalid_argument(
          fmt::format("motion of body {}, expected a target or an obstacle of the team", one.body.index));
    }
    std::visit([](const auto& m) { m.check(); }, one.motion);
    const auto x = static_cast<std::size_t>(team.state_offset(one.body));
    if (std::any_of(movers_.begin(), movers_.end(), [&](const Mover& other) { return other.x == x; })) {
      throw std::invalid_argument(fmt::format("\"{}\" has two motions, expected one", team.name(one.body)));
    }
    const bool follows = std::visit(
        [](const auto& m) {
          return requires { m.agent; };
        },
        one.motion);
    const AgentId agent = followed_by(one.motion);
    if (follows && (agent.index < 0 || agent.index >= team.bodies() || !team.is_agent(agent))) {
      throw std::invalid_argument(fmt::format("the motion of \"{}\" follows body {}, expected a robot",
                                              team.name(one.body), agent.index));
    }
    const BodyId seen = follows ? BodyId{agent} : one.body;
    Mover mover{.motion = std::move(one.motion),
                .x = x,
                .followed = {team.model(seen), static_cast<std::size_t>(team.state_offset(seen)),
                             static_cast<std::size_t>(team.input_offset(seen))},
                .chance = RandomStream(seed, StreamId::motion, one.body.index),
                .lengths = {}};
    if (auto* path = std::get_if<PathMotion>(&mover.motion)) {
      path->points = corners(*path);
      mover.lengths.push_back(0.0);
      for (std::size_t i = 1; i < path->points.size(); ++i) {
        mover.lengths.push_back(mover.lengths.back() + norm(path->points[i] - path->points[i - 1]));
      }
    }
    movers_.push_back(std::move(mover));
  }
}

/// Evaluates the velocity of one body over the step that starts now.
struct Motions::Steer {
  Mover& mover;
  double t, dt;
  Vec3<double> p;        // of the body
  Sight<double> robot;   // the followed robot
  Vec3<double>& placed;  // position, which a motion may set directly

  /// Velocity that reaches q at the end of the step, so that rounding errors do not accumulate.
  Vec3<double> reach(const Vec3<double>& q) const { return (1 / dt) * (q - p); }

  Vec3<double> operator()(const PathMotion& path) const {
    const std::vector<double>& lengths = mover.lengths;
    double s = path.speed * (t + dt);
    if (path.end == PathMotion::End::round) s = std::fmod(s, lengths.back());
    const auto after = std::upper_bound(lengths.begin(), lengths.end(), s);
    if (after == lengths.end()) return reach(path.points.back());
    const auto i = static_cast<std::size_t>(after - lengths.begin());
    const double w = (s - lengths[i - 1]) / (lengths[i] - lengths[i - 1]);
    return reach(path.points[i - 1] + w * (path.points[i] - path.points[i - 1]));
  }

  Vec3<double> operator()(const WaypointsMotion& waypoints) const { return reach(waypoints(t + dt).p); }

  Vec3<double> operator()(const CircleMotion& circle) const {
    const SinCos<double> a =
        sincos(std::remainder(circle.phase + circle.rate * (t + dt), 2 * std::numbers::pi));
    return reach(circle.centre + circle.radius * Vec3<double>{a.cos, a.sin, 0});
  }

  Vec3<double> operator()(const ChaseMotion& chase) const {
    return pursue(robot.p - p, chase.speed, chase.standoff, dt);
  }

  Vec3<double> operator()(const CrossMotion& cross) {
    if (t < cross.at - same_time) return {};
    if (mover.entered) return mover.v;
    mover.entered = true;
    const Vec3<double> aim = meeting_place(robot.p - p, robot.v, cross.speed);
    const double level = norm(aim.x, aim.y);
    const double turn = level > 0 ? std::asin(std::clamp(cross.miss / level, -1.0, 1.0)) : 0.0;
    const Vec2<double> turned = rotate<double>({cos(turn), sin(turn)}, {aim.x, aim.y});
    return mover.v = along({turned.x, turned.y, aim.z}, cross.speed);
  }

  Vec3<double> operator()(const HandMotion& hand) {
    if (t < hand.at - same_time) return {};
    if (!mover.entered) {
      mover.entered = true;
      placed = hand.from;
    }
    return pursue(robot.p - placed, hand.speed, hand.standoff, dt);
  }

  Vec3<double> operator()(const AdversaryMotion& adversary) {
    if (t < mover.next - same_time) return mover.v;
    mover.next = t + adversary.every;
    const bool plane = adversary.within == AdversaryMotion::Within::plane;
    const bool aimed = mover.chance.uniform() <= adversary.aim;
    const double speed =
        mover.chance.uniform() <= 0.5 ? adversary.speed : adversary.speed * mover.chance.uniform();
    Vec3<double> way = aimed ? robot.p - p : any_way(mover.chance, adversary.within);
    if (plane) way.z = 0;
    return mover.v = along(way, speed);
  }
};

void Motions::move(const Surroundings::Move& move, std::span<const double> x) noexcept {
  for (Carried& one : carried_) {
    if (one.move.body != move.body || one.begun == move.begin) continue;
    one.begun = move.begin;
    one.move = move;
    one.from = {x[one.x], x[one.x + 1], x[one.x + 2]};
    one.moves = true;
    constexpr double peak = 1.5;  // maximum over mean speed of blended()
    one.move.duration = std::fmax(move.duration, peak * norm(move.to - one.from) / one.speed_max);
  }
}

void Motions::leave(BodyId body) noexcept {
  for (Carried& one : carried_) one.moves = one.moves && one.move.body != body;
}

void Motions::steer(double t, double dt, std::span<const double> u, std::span<double> x) noexcept {
  for (Mover& mover : movers_) {
    double* const at = &x[mover.x];
    Vec3<double> p = {at[0], at[1], at[2]};
    const double* const input = u.empty() ? nullptr : u.data() + mover.followed.u;
    const Sight<double> robot = mover.followed.model.sight(&x[mover.followed.x], input);
    const Vec3<double> v = std::visit(Steer{mover, t, dt, p, robot, p}, mover.motion);
    at[0] = p.x, at[1] = p.y, at[2] = p.z;
    at[3] = v.x, at[4] = v.y, at[5] = v.z;
  }
  for (const Carried& one : carried_) {
    if (!one.moves) continue;
    double* const at = &x[one.x];
    const double part = blended(t + dt, one.move.begin, one.move.duration);
    const Vec3<double> next = one.from + part * (one.move.to - one.from);
    at[3] = (next.x - at[0]) / dt, at[4] = (next.y - at[1]) / dt, at[5] = (next.z - at[2]) / dt;
  }
}

}  // namespace sightline
