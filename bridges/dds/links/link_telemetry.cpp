#include "bridges/dds/links/link_telemetry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/scenario/read_estimate.hpp"

namespace sightline::dds {
namespace {

double heading_angle(const Motion& motion) noexcept {
  const Vec2<double> d = heading(rotation(motion.q));
  return std::atan2(d.y, d.x);
}

Vec2<double> turned_by(double angle, const Vec2<double>& d) noexcept {
  return rotate<double>({std::cos(angle), std::sin(angle)}, d);
}

}  // namespace

LinkOrigin carried_frame(const Motion& odometry, double age, const Motion& estimated) {
  LinkOrigin frame;
  frame.heading = heading_angle(estimated) - heading_angle(odometry) - age * odometry.r;
  frame.p = estimated.p - in_G(frame, odometry).p;
  return frame;
}

Command in_local(const LinkOrigin& frame, const Command& command) {
  Command local = command;
  const auto place = [&](const Vec3<double>& p) { return in_local(frame, Motion{.p = p}).p; };
  const auto way = [&](const Vec3<double>& v) { return in_local(frame, Motion{.v = v}).v; };
  local.v_end = way(command.v_end);
  local.d = turned_by(-frame.heading, command.d);
  const TrajectoryPoint& lead = command.lead;
  local.lead.p = place(lead.p), local.lead.v = way(lead.v), local.lead.a = way(lead.a);
  local.lead.j = way(lead.j);
  local.lead.d = turned_by(-frame.heading, lead.d);
  return local;
}

bool uses_attitude_filter(const Scenario& scenario, BodyId robot) {
  const LocalizedRobot* const localized = localized_robot(scenario, robot);
  return localized != nullptr && localized->filter.filter == FilterKind::attitude;
}

LinkTelemetry::LinkTelemetry(const Scenario& scenario, const std::vector<LinkEnd*>& ends,
                             dds_entity_t participant)
    : team_(scenario.team), radio_(scenario.radio), rest_(size(team_.nu())) {
  std::vector<WatchedCamera> cameras;
  const auto& links = fleet_of(scenario).links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const BodyId robot = links[i].robot;
    if (!links[i].poses.estimated()) continue;
    PoseSubscriber& odometry = ends[i]->subscriber();
    InertialSamples* const inertial = ends[i]->inertial();
    if (inertial == nullptr && uses_attitude_filter(scenario, robot))
      throw std::invalid_argument(fmt::format(
          "agent.{}.estimate.filter = attitude, for which a link of kind {} has no accelerations, "
          "expected \"heading\", a link of kind px4, or one of kind crazyswarm2 with imu",
          team_.name(robot), links[i].kind_name()));
    robots_.push_back({robot, &odometry, inertial});
    if (const RobotCamera* const camera = scenario.vision.camera_of(robot))
      cameras.push_back({*camera, &odometry});
  }
  if (robots_.empty()) return;
  for (const BodyId body : telemetry_options(scenario).broadcasters) emitters_.push_back({body});
  motions_.reserve(motions_most * robots_.size());
  broadcasts_.reserve(emitters_.size());
  tags_ = std::make_unique<TagSubscriber>(scenario, cameras, participant);
}

MeasuredMost LinkTelemetry::most() const noexcept {
  return {tags_ ? TagSubscriber::most : 0, motions_.capacity(), broadcasts_.capacity()};
}

void LinkTelemetry::begin() noexcept {
  for (Robot& robot : robots_) {
    for (SeenMotion seen; robot.odometry->next(seen);) (void)robot.samples.take(seen, 0);
    if (robot.inertial != nullptr) robot.inertial->forget();
  }
  if (tags_) tags_->forget();
}

void LinkTelemetry::measure(Nanoseconds origin, Measured& now) noexcept {
  if (empty()) return;
  motions_.clear();
  for (Robot& robot : robots_) {
    SeenMotion seen;
    for (std::size_t i = 0; i < motions_most && robot.odometry->next(seen); ++i) {
      std::optional<MotionSample> sample = robot.samples.take(seen, origin);
      if (!sample || (robot.inertial != nullptr && !robot.inertial->fill(seen.sampled, *sample))) continue;
      motions_.push_back({robot.body, *sample});
    }
  }
  broadcasts_.clear();
  for (TelemetryEmitter& emitter : emitters_) {
    const double stamp = now.stamps[at(emitter.body)];
    if (!std::isfinite(stamp) || (emitter.reported && stamp <= emitter.last)) continue;
    emitter.reported = true, emitter.last = stamp;
    const Sight<double> sight = team_.model(emitter.body)
                                    .sight(&now.measured[size(team_.state_offset(emitter.body))],
                                           rest_.data() + team_.input_offset(emitter.body));
    BroadcastPose pose{.stamp = stamp, .p = sight.p, .v = sight.v, .psi = std::atan2(sight.d.y, sight.d.x)};
    pose.P = identity<4>(square(radio_.position_sigma));
    pose.P(3, 3) = square(radio_.heading_sigma);
    broadcasts_.push_back({emitter.body, pose});
  }
  now.motions = motions_;
  now.broadcasts = broadcasts_;
  now.detections = tags_->take(origin);
}

}  // namespace sightline::dds
