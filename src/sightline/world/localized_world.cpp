#include "sightline/world/localized_world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sightline/base/index.hpp"
#include "sightline/base/refuse.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/world/sighting.hpp"

namespace sightline {
namespace {

constexpr double never = -std::numeric_limits<double>::infinity();
constexpr double draw_time = 0.08;  // in which velocities follow those of the filter [s]
constexpr std::uint64_t stream_of_messages = 0x7261646961ULL;

const LocalizationOptions& checked_localization(const LocalizationOptions& o) {
  const auto above_zero_only = [](double v, const char* key, const char* unit) {
    if (!(v > 0 && std::isfinite(v))) refuse("estimate.{} = {}, expected > 0 {}", key, v, unit);
  };
  o.broadcast.check();
  above_zero_only(o.broadcast_sigma, "broadcast_sigma", "m");
  above_zero_only(o.broadcast_heading_sigma, "broadcast_heading_sigma", "rad");
  above_zero_only(o.sigma_hold, "sigma_hold", "m");
  return o;
}

LocalizationGraph graph_of(const Team& team, const LocalizationOptions& options) {
  std::vector<Localized> robots;
  for (int i = 0; i < team.bodies(); ++i) robots.push_back({std::string(team.name(BodyId{i})), true, {}});
  for (const LocalizedRobot& robot : options.robots) {
    if (robot.robot.index < 0 || robot.robot.index >= team.bodies())
      refuse("a robot that is localized has the number {}, expected one of {} bodies", robot.robot.index,
             team.bodies());
    Localized& of = robots[size(robot.robot.index)];
    if (!of.is_anchor) refuse("\"{}\" is localized twice, expected once", of.name);
    of.is_anchor = false;
    for (const BodyId other : robot.watches) of.watches.push_back(other.index);
  }
  return LocalizationGraph(std::move(robots), options.cycles);
}

/// The filter that a robot needs among those it watches.
FilterOptions filter_of(const LocalizedRobot& robot, const LocalizationGraph& graph) {
  FilterOptions filter = robot.filter;
  for (const BodyId other : robot.watches) {
    if (graph.tier(other.index) == 0) continue;
    if (filter.filter == FilterKind::attitude)
      refuse(
          "\"{}\" watches \"{}\", which is localized itself, with the filter \"attitude\", expected "
          "\"heading\"",
          graph.robot(robot.robot.index).name, graph.robot(other.index).name);
    filter.filter = FilterKind::chain;
  }
  return filter;
}

}  // namespace

LocalizedWorld::LocalizedWorld(std::unique_ptr<World> world, LocalizationOptions options)
    : world_(std::move(world)),
      options_(checked_localization(options)),
      graph_(graph_of(world_->team(), options_)),
      robot_of_(size(world_->team().bodies()), -1),
      told_stamps_(robot_of_.size(), never),
      radio_(options_.seed ^ stream_of_messages, Chance::motion, 0),
      presence_(robot_of_.size(), Presence::steered),
      measured_(world_->start().begin(), world_->start().end()),
      stamps_(robot_of_.size(), never),
      applied_(size(world_->team().nu())),
      estimates_(options_.robots.size()) {
  const Team& team = world_->team();
  BroadcastOptions lasting = options_.broadcast;
  lasting.sighting_rate = 1e-3;  // an error that lasts is no other one with each message
  for (int i = 0; i < team.bodies(); ++i)
    tracks_.emplace_back(graph_.tier(i) == 0 ? options_.broadcast : lasting);
  for (const LocalizedRobot& what : options_.robots) {
    const Model& model = team.model(what.robot);
    const StateRoles roles = roles_of(model);
    if (!roles.has_position() || !roles.has_heading())
      refuse("\"{}\" cannot be localized by view: its model \"{}\" has no {} among its states",
             team.name(what.robot), model.name(), roles.has_position() ? "heading" : "position");
    Robot robot{.what = what,
                .x = size(team.state_offset(what.robot)),
                .u = size(team.input_offset(what.robot)),
                .nx = size(model.nx()),
                .filter = make_pose_filter(filter_of(what, graph_), what.mount),
                .motion = MotionSensor(what.errors, options_.seed, what.robot.index),
                .good = never};
    robot.predicted.resize(robot.nx);
    std::vector<double> x(robot.nx), u(size(model.nu()));
    model.at_rest({{}, {1.0, 0.0}}, x.data());
    const Vec3<double> still = model.sight(x.data(), u.data()).v;
    for (const int v : roles.velocities) {
      std::vector<double> moving = x;
      moving[size(v)] += 1.0;
      robot.velocities.push_back(size(v));
      robot.velocity_axes.push_back(model.sight(moving.data(), u.data()).v - still);
    }
    robot_of_[size(what.robot.index)] = static_cast<int>(robots_.size());
    robots_.push_back(std::move(robot));
  }
  for (const int body : graph_.order())
    if (robot_of_[size(body)] >= 0) order_.push_back(size(robot_of_[size(body)]));
}

void LocalizedWorld::set_presence(std::span<const Presence> presence) noexcept {
  for (std::size_t i = 0; i < std::min(presence.size(), presence_.size()); ++i) {
    const Presence was = std::exchange(presence_[i], presence[i]);
    if ((was == Presence::absent) == (presence[i] == Presence::absent)) continue;
    // One that comes again is elsewhere.
    tracks_[i].forget();
    if (robot_of_[i] < 0) continue;
    Robot& robot = robots_[size(robot_of_[i])];
    robot.filter->forget();
    robot.good = never;
    estimates_[size(robot_of_[i])] = {};
  }
  world_->set_presence(presence);
}

Measured LocalizedWorld::measure(double t) noexcept {
  Measured now = world_->measure(t);
  std::copy(now.measured.begin(), now.measured.end(), measured_.begin());
  std::copy(now.stamps.begin(), now.stamps.end(), stamps_.begin());
  if (!now.truth.empty()) {
    for (Robot& robot : robots_) move(robot, t, now);
    last_ = t;
    began_ = true;
  }
  hear(t, now);
  for (const std::size_t i : order_) {
    for (const Detection& detection : now.detections)
      if (detection.observer == robots_[i].what.robot) look(robots_[i], detection);
    believe(i, t);
  }
  now.measured = measured_;
  now.stamps = stamps_;
  return now;
}

/// Tells a robot's filter how it moved since the last time.
void LocalizedWorld::move(Robot& robot, double t, const Measured& now) noexcept {
  const Sight<double> sight = team().model(robot.what.robot).sight(&now.truth[robot.x], &applied_[robot.u]);
  const Mat<3, 3> R = attitude_of(robot.what.robot, now);
  if (began_ && t > last_) {
    const MotionSample u = robot.motion.measure(t, t - last_, robot.p, robot.R, sight.p, R);
    robot.told[robot.told_count++ % robot.told.size()] = u;
    robot.filter->advance(u);
  }
  robot.p = sight.p;
  robot.R = R;
}

Mat<3, 3> LocalizedWorld::attitude_of(BodyId body, const Measured& now) const noexcept {
  const auto place = size(body.index);
  if (place < now.attitudes.size() && now.attitudes[place] != no_attitude)
    return matrix(rotation(now.attitudes[place]));
  const Sight<double> sight = team().model(body).sight(&now.truth[size(team().state_offset(body))],
                                                       applied_.data() + team().input_offset(body));
  return matrix(rotation(leaning(sight.d, sight.lean)));
}

/// Bodies that know their poses tell them.
void LocalizedWorld::hear(double t, const Measured& now) noexcept {
  for (int i = 0; i < team().bodies(); ++i) {
    const auto place = size(i);
    if (robot_of_[place] >= 0 || presence_[place] == Presence::absent) continue;
    const double stamp = now.stamps[place];
    if (!(stamp > told_stamps_[place]) || stamp > t) continue;
    const BodyId body{i};
    const Sight<double> sight = team().model(body).sight(&now.measured[size(team().state_offset(body))],
                                                         applied_.data() + team().input_offset(body));
    BroadcastPose message{.stamp = stamp};
    message.p = sight.p + options_.broadcast_sigma * radio_.normals();
    message.v = sight.v + options_.broadcast.velocity_sigma * radio_.normals();
    message.psi = wrap(atan2(sight.d.y, sight.d.x) + options_.broadcast_heading_sigma * radio_.normal());
    message.P = identity<4>(square(options_.broadcast_sigma));
    message.P(3, 3) = square(options_.broadcast_heading_sigma);
    told_stamps_[place] = stamp;
    tracks_[place].take(message);
  }
}

/// A detection has arrived.
void LocalizedWorld::look(Robot& robot, const Detection& detection) noexcept {
  const std::vector<BodyId>& watches = robot.what.watches;
  if (std::find(watches.begin(), watches.end(), detection.target) == watches.end() || robot.told_count == 0)
    return;
  const auto pose = tracks_[size(detection.target.index)].at(detection.stamp);
  if (!pose) return;
  // Of the samples that are remembered, the one of the exposure.
  const std::size_t oldest = robot.told_count - std::min(robot.told_count, robot.told.size());
  std::size_t sample = robot.told_count - 1;
  while (sample > oldest && robot.told[sample % robot.told.size()].t > detection.stamp) --sample;
  const Vec2<double> roll_pitch = tilt_at(robot.told[sample % robot.told.size()], detection.stamp);
  Measurement z = sighting_of(detection, robot.what.mount, roll_pitch);
  z.p_other = pose->p, z.psi_other = pose->psi, z.P_other = pose->P;
  z.other_error = graph_.error_of(robot.what.robot.index, detection.target.index);
  robot.filter->take(z);
}

/// What the robot takes its state to be at t.
void LocalizedWorld::believe(std::size_t i, double t) noexcept {
  Robot& robot = robots_[i];
  const auto place = size(robot.what.robot.index);
  const bool knew = estimates_[i].known;
  PoseEstimate& estimate = estimates_[i] = robot.filter->estimate();
  if (presence_[place] == Presence::absent) return;
  if (!estimate.known) {
    stamps_[place] = robot.good = never;
    return;
  }
  const SinCos<double> h = sincos(estimate.psi);
  const auto x = std::span(measured_).subspan(robot.x, robot.nx);
  team().model(robot.what.robot).at_rest({estimate.p, {h.cos, h.sin}}, x.data());
  const Vec3<double> v_V = turn_z(-estimate.psi) * estimate.v;
  const double draw = knew ? 1 - exp(-(t - robot.good) / draw_time) : 1.0;
  for (std::size_t k = 0; k < robot.velocities.size(); ++k) {
    const double told = dot(robot.velocity_axes[k], v_V),
                 model = knew ? robot.predicted[robot.velocities[k]] : told;
    x[robot.velocities[k]] = model + std::clamp(draw, 0.0, 1.0) * (told - model);
  }
  if (estimate.position_sigma() <= options_.sigma_hold) robot.good = t;
  stamps_[place] = robot.good;
  if (robot.good == t)
    tracks_[place].take({.stamp = t,
                         .p = estimate.p,
                         .v = estimate.v,
                         .psi = estimate.psi,
                         .yaw_rate = estimate.yaw_rate,
                         .P = estimate.P});
}

bool LocalizedWorld::apply(double t, std::span<const double> believed, std::span<const double> u,
                           double period, std::int64_t periods) noexcept {
  std::copy(u.begin(), u.end(), applied_.begin());
  for (Robot& robot : robots_) {
    std::copy_n(measured_.begin() + static_cast<std::ptrdiff_t>(robot.x), robot.nx, robot.predicted.begin());
    for (std::int64_t k = 0; k < periods; ++k)
      team().model(robot.what.robot).step(robot.predicted.data(), &applied_[robot.u], period);
  }
  return world_->apply(t, believed, u, period, periods);
}

}  // namespace sightline
