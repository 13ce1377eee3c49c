#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/loop.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/world/sighting.hpp"

namespace sightline {
namespace {

constexpr double draw_time = 0.08;  // time constant with which velocities follow the filter [s]
constexpr std::size_t fits_most = 64;

LocalizationGraph unchecked_graph(const Team& team, const LocalizerOptions& options) {
  std::vector<Localized> robots;
  for (int i = 0; i < team.bodies(); ++i) robots.push_back({std::string(team.name(BodyId{i})), true, {}});
  for (const LocalizedRobot& robot : options.robots) {
    if (robot.robot.index < 0 || robot.robot.index >= team.bodies())
      throw_invalid("a robot that is localized has the number {}, expected one of {} bodies",
                    robot.robot.index, team.bodies());
    Localized& of = robots[at(robot.robot)];
    if (!of.is_anchor) throw_invalid("\"{}\" is localized twice, expected once", of.name);
    of.is_anchor = false;
    for (const BodyId other : robot.observes) of.observes.push_back(other.index);
  }
  return LocalizationGraph(std::move(robots), options.cycles);
}

/// Time behaviour of the error of the target's broadcast pose, for that observer.
OtherError error_of(const LocalizationGraph& graph, const LocalizerOptions& options, int observer,
                    int target) {
  const OtherError error = graph.error_of(observer, target);
  return error == OtherError::fresh && options.broadcast.correlation_time > 0 ? OtherError::lasting : error;
}

/// The filter that a robot needs, given the bodies that it observes.
FilterOptions filter_of(const LocalizedRobot& robot, const LocalizerOptions& options,
                        const LocalizationGraph& graph) {
  FilterOptions filter = robot.filter;
  for (const BodyId other : robot.observes) {
    const bool anchor = graph.tier(other.index) == 0;
    if (error_of(graph, options, robot.robot.index, other.index) == OtherError::fresh) continue;
    const std::string &name = graph.robot(robot.robot.index).name, &of = graph.robot(other.index).name;
    if (filter.filter == FilterKind::attitude)
      throw_invalid("\"{}\" observes \"{}\", {}, with the filter \"attitude\", expected \"heading\"", name,
                    of,
                    anchor ? "whose broadcast errors are correlated in time" : "which is localized itself");
    filter.filter = FilterKind::chain;
    if (!anchor) continue;
    if (robot.observes.size() > 1)
      throw_invalid(
          "\"{}\" observes {} bodies, whose broadcast errors are correlated in time, expected one body", name,
          robot.observes.size());
    filter.other_error_time = options.broadcast.correlation_time;
    filter.other_error_spread = 1.0;
  }
  return filter;
}

std::unique_ptr<PoseFilter> filter_for(const LocalizedRobot& robot, const LocalizerOptions& options,
                                       const LocalizationGraph& graph) {
  return make_pose_filter(filter_of(robot, options, graph), robot.mount,
                          static_cast<int>(robot.observes.size()));
}

/// Broadcast options of a body for the robots that observe it.
BroadcastOptions broadcast_of(BodyId body, const LocalizerOptions& options, const LocalizationGraph& graph) {
  BroadcastOptions broadcast = options.broadcast;
  broadcast.sighting_rate = 1e-3;  // a lasting error is not independent between messages
  if (graph.tier(body.index) > 0 || broadcast.correlation_time > 0) return broadcast;
  for (const LocalizedRobot& robot : options.robots)
    if (graph.uses(robot.robot.index, body.index))
      broadcast.sighting_rate = std::max(broadcast.sighting_rate, robot.camera_rate);
  return broadcast;
}

/// The direction error becomes a position error across the line of sight. It grows with the errors
/// of velocity and yaw rate, as if these had one direction.
ViewUncertainty uncertainty_of(const PoseEstimate& estimate, double bearing_sigma,
                               const Vec3<double>& target) {
  constexpr double most = 2.0;  // [m], [m/s]: the target's position is then unknown
  const double range = norm(target - estimate.p);
  const double growth = sqrt(square(estimate.velocity_sigma) + square(range * estimate.yaw_rate_sigma));
  return {std::min(most, range * bearing_sigma), std::min(most, growth)};  // `most`, also if not finite
}

}  // namespace

void LocalizerOptions::check() const {
  broadcast.check();
  for (const LocalizedRobot& robot : robots)
    if (!(robot.camera_rate > 0 && std::isfinite(robot.camera_rate)))
      throw_invalid("estimate.camera_rate = {}, expected > 0 Hz", robot.camera_rate);
}

LocalizationGraph localization_graph(const Team& team, const LocalizerOptions& options) {
  options.check();
  LocalizationGraph graph = unchecked_graph(team, options);
  for (const LocalizedRobot& robot : options.robots) {
    const Model& model = team.model(robot.robot);
    const StateRoles roles = roles_of(model);
    if (!roles.has_position() || !roles.has_heading())
      throw_invalid("\"{}\" cannot be localized by vision: its model \"{}\" has no {} among its states",
                    team.name(robot.robot), model.name(), roles.has_position() ? "heading" : "position");
    (void)filter_for(robot, options, graph);
  }
  return graph;
}

Localizer::Localizer(const Team& team, std::span<const double> start, const LocalizerOptions& options)
    : team_(team),
      options_(options),
      graph_(localization_graph(team, options)),
      robot_of_(size(team.bodies()), -1),
      presence_(robot_of_.size(), Presence::steered),
      start_(start.begin(), start.end()),
      states_(start_),
      stamps_(robot_of_.size(), -infinity),
      sigma_(robot_of_.size()),
      uncertainties_(robot_of_.size()),
      estimates_(robot_of_.size()) {
  if (start_.size() != size(team.nx()))
    throw_invalid("a start of {} states, expected {}", start_.size(), team.nx());
  for (int i = 0; i < team.bodies(); ++i) tracks_.emplace_back(broadcast_of(BodyId{i}, options_, graph_));
  for (const int body : graph_.order()) {
    const auto found = std::find_if(options_.robots.begin(), options_.robots.end(),
                                    [&](const LocalizedRobot& one) { return one.robot.index == body; });
    if (found == options_.robots.end()) continue;
    robot_of_[at(body)] = static_cast<int>(robots_.size());
    robots_.push_back(made(*found));
    views_.push_back({.robot = found->robot, .target = found->observes.front(), .azimuth = found->mount.yaw});
    sigma_[at(body)] = infinity;
  }
  knows_all_ = robots_.empty();
  fits_.reserve(fits_most * robots_.size());
}

Localizer::Robot Localizer::made(const LocalizedRobot& what) const {
  const Model& model = team_.model(what.robot);
  Robot robot{.what = what,
              .body = at(what.robot),
              .x = size(team_.state_offset(what.robot)),
              .u = size(team_.input_offset(what.robot)),
              .nx = size(model.nx()),
              .filter = filter_for(what, options_, graph_)};
  robot.predicted.resize(robot.nx);
  // The direction in G of each velocity state, at heading 0.
  std::vector<double> x(robot.nx), u(size(model.nu()));
  model.at_rest({{}, {1.0, 0.0}}, x.data());
  const Vec3<double> still = model.sight(x.data(), u.data()).v;
  const StateRoles roles = roles_of(model);
  for (const int tilt : roles.tilt)
    if (tilt >= 0) robot.tilt.push_back(size(tilt));
  if (roles.rate >= 0) robot.rate = size(roles.rate);
  for (const int v : roles.velocities) {
    std::vector<double> moving = x;
    moving[size(v)] += 1.0;
    robot.velocities.push_back(size(v));
    robot.velocity_axes.push_back(model.sight(moving.data(), u.data()).v - still);
  }
  return robot;
}

void Localizer::set_presence(std::span<const Presence> presence) noexcept {
  for (std::size_t i = 0; i < std::min(presence.size(), presence_.size()); ++i) {
    const Presence was = std::exchange(presence_[i], presence[i]);
    if ((was == Presence::absent) == (presence[i] == Presence::absent)) continue;
    tracks_[i].forget();  // a body that rejoins is elsewhere
    if (robot_of_[i] < 0) continue;
    forget(robots_[size(robot_of_[i])]);
    views_[size(robot_of_[i])].sighted = View::never;
  }
}

/// Discards all knowledge of a robot.
void Localizer::forget(Robot& robot) noexcept {
  robot.filter->forget();
  robot.counted = 0;
  stamps_[robot.body] = -infinity;
  sigma_[robot.body] = infinity;
  uncertainties_[robot.body] = {};
  estimates_[robot.body] = {};
  std::copy_n(&start_[robot.x], robot.nx, &states_[robot.x]);
}

Measured Localizer::estimate(double t, const Measured& received) noexcept {
  for (int i = 0; i < team_.bodies(); ++i) {
    if (robot_of_[at(i)] >= 0) continue;
    const std::size_t x = size(team_.state_offset(BodyId{i}));
    std::copy_n(&received.measured[x], size(team_.model(BodyId{i}).nx()), &states_[x]);
    stamps_[at(i)] = received.stamps[at(i)];
  }
  for (const RobotMotion& motion : received.motions) move(motion);
  for (const BodyBroadcast& message : received.broadcasts)
    if (robot_of_[at(message.body)] < 0) tracks_[at(message.body)].take(message.pose);
  fits_.clear();
  bool knows_all = true;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& robot = robots_[i];
    for (const Detection& detection : received.detections)
      if (detection.observer == robot.what.robot) look(robot, views_[i], detection);
    accept_measurement(robot, views_[i], t);
    knows_all = knows_all && (presence_[robot.body] == Presence::absent || estimates_[robot.body].known);
  }
  knows_all_ = knows_all_ || knows_all;
  Measured now = received;
  now.measured = states_;
  now.stamps = stamps_;
  return now;
}

/// Passes a motion sample to the robot's filter.
void Localizer::move(const RobotMotion& motion) noexcept {
  const int place = robot_of_[at(motion.robot)];
  if (place < 0 || !is_usable(motion.motion)) return;
  Robot& robot = robots_[size(place)];
  robot.received[robot.counted++ % robot.received.size()] = motion.motion;
  robot.filter->advance(motion.motion);
  if (const auto compass = compass_of(motion.motion, robot.what.filter)) robot.filter->take(*compass);
}

/// Passes a detection to the robot's filter.
void Localizer::look(Robot& robot, View& view, const Detection& detection) noexcept {
  const int target = detection.target.index;
  if (!graph_.uses(robot.what.robot.index, target) || robot.counted == 0) return;
  const auto pose = tracks_[at(target)].at(detection.stamp);
  if (!pose) return;
  // The stored motion sample at the time of exposure.
  const std::size_t first = robot.counted - std::min(robot.counted, robot.received.size());
  std::size_t sample = robot.counted - 1;
  while (sample > first && robot.received[sample % robot.received.size()].t > detection.stamp) --sample;
  const Vec2<double> roll_pitch = tilt_at(robot.received[sample % robot.received.size()], detection.stamp);
  Measurement z = sighting_of(detection, robot.what.mount, roll_pitch);
  z.p_other = pose->p, z.psi_other = pose->psi, z.P_other = pose->P;
  z.other_error = error_of(graph_, options_, robot.what.robot.index, target);
  const Fit fit = robot.filter->take(z);
  if (fits_.size() < fits_.capacity())
    fits_.push_back({detection.observer, detection.target, detection.stamp, fit});
  if (detection.stamp > view.sighted) view.sighted = detection.stamp, view.target = detection.target;
}

/// Writes a robot's state at t from its filter.
void Localizer::accept_measurement(Robot& robot, View& view, double t) noexcept {
  if (presence_[robot.body] == Presence::absent) return;
  const bool knew = estimates_[robot.body].known;
  const double before = estimates_[robot.body].stamp;
  const PoseEstimate& estimate = estimates_[robot.body] = robot.filter->estimate();
  const auto x = std::span(states_).subspan(robot.x, robot.nx);
  view.localized = estimate.known;
  view.accepted = estimate.known ? estimate.last_accepted : View::never;
  if (!estimate.known) {
    stamps_[robot.body] = -infinity;
    sigma_[robot.body] = infinity;
    // The velocity in V is known without a pose.
    for (std::size_t k = 0; robot.counted > 0 && k < robot.velocities.size(); ++k)
      x[robot.velocities[k]] =
          dot(robot.velocity_axes[k], robot.received[(robot.counted - 1) % robot.received.size()].v_V);
    return;
  }
  const SinCos<double> h = sincos(estimate.psi);
  team_.model(robot.what.robot).at_rest({estimate.p, {h.cos, h.sin}}, x.data());
  const Vec3<double> v_V = turn_z(-estimate.psi) * estimate.v;
  const double draw = knew ? std::clamp(1 - exp(-(estimate.stamp - before) / draw_time), 0.0, 1.0) : 1.0;
  for (std::size_t k = 0; k < robot.velocities.size(); ++k) {
    const double received = dot(robot.velocity_axes[k], v_V),
                 model = knew ? robot.predicted[robot.velocities[k]] : received;
    x[robot.velocities[k]] = model + draw * (received - model);
  }
  if (knew) {
    for (const std::size_t tilt : robot.tilt) x[tilt] = robot.predicted[tilt];
  }
  if (robot.rate) {
    const double model = knew ? robot.predicted[*robot.rate] : estimate.yaw_rate;
    x[*robot.rate] = model + draw * (estimate.yaw_rate - model);
  }
  stamps_[robot.body] = estimate.stamp;
  view.position_sigma = sigma_[robot.body] = estimate.position_sigma();
  if (const auto target = tracks_[at(view.target)].at(t)) {
    view.bearing_sigma = estimate.bearing_sigma(*target);
    uncertainties_[robot.body] = uncertainty_of(estimate, view.bearing_sigma, target->p);
  }
  tracks_[robot.body].take({.stamp = estimate.stamp,
                            .p = estimate.p,
                            .v = estimate.v,
                            .psi = estimate.psi,
                            .yaw_rate = estimate.yaw_rate,
                            .P = estimate.P});
}

void Localizer::start(BodyId robot, const Vec3<double>& p, double psi, const Mat<4, 4>& P) noexcept {
  if (const int place = robot_of_[at(robot)]; place >= 0) robots_[size(place)].filter->start(p, psi, P);
}

void Localizer::apply(std::span<const double> u, double period, std::int64_t periods) noexcept {
  for (Robot& robot : robots_) {
    std::copy_n(&states_[robot.x], robot.nx, robot.predicted.begin());
    for (std::int64_t k = 0; k < periods; ++k)
      team_.model(robot.what.robot).step(robot.predicted.data(), &u[robot.u], period);
  }
}

}  // namespace sightline
