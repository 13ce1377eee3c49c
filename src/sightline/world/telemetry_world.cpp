#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/world/sighting.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

constexpr std::uint64_t stream_of_messages = 0x7261646961ULL;

}  // namespace

void Radio::check() const {
  check_parameters(*this);
  if (latency[0] > latency[1])
    throw_invalid("latency = [{}, {}], expected the shortest first", latency[0], latency[1]);
}

TelemetryWorld::TelemetryWorld(std::unique_ptr<World> world, const TelemetryOptions& options)
    : SensingWorld(std::move(world)), radio_(options.radio) {
  const Team& all = team();
  const MeasuredMost most = SensingWorld::measured_max();
  if (most.motions > 0 || most.broadcasts > 0)
    throw_invalid("the world gives telemetry of its own, expected one without");
  radio_.check();
  const auto check_body = [&](BodyId body) {
    if (body.index < 0 || body.index >= all.bodies())
      throw_invalid("telemetry of body {}, expected one of the team's {}", body.index, all.bodies());
  };
  for (const MovingRobot& one : options.robots) {
    check_body(one.robot);
    robots_.push_back({one.robot, MotionSensor(one.errors, options.seed, one.robot.index)});
  }
  for (const BodyId body : options.broadcasters) {
    check_body(body);
    senders_.push_back(
        {.body = body,
         .chance = RandomStream(options.seed ^ stream_of_messages, StreamId::motion, body.index),
         .errors = GaussMarkov<7>(radio_.correlation_time)});
  }
  motions_.reserve(robots_.size());
  // Messages in transit, plus one for each end of the latency range.
  const auto under_way = static_cast<std::size_t>(std::ceil(radio_.latency[1] * radio_.rate)) + 2;
  messages_ = UnderWay<Message>(under_way * senders_.size());
  arrived_.reserve(messages_.capacity());
}

MeasuredMost TelemetryWorld::measured_max() const noexcept {
  MeasuredMost most = SensingWorld::measured_max();
  most.motions = robots_.size();
  most.broadcasts = messages_.capacity();
  return most;
}

void TelemetryWorld::set_presence(std::span<const Presence> presence) noexcept {
  SensingWorld::set_presence(presence);
  const auto is_there = [&](BodyId body) {
    return at(body) >= presence.size() || presence[at(body)] != Presence::absent;
  };
  for (Robot& robot : robots_) {
    const bool was = std::exchange(robot.there, is_there(robot.body));
    if (was == robot.there) continue;
    robot.moves = false;  // a robot that joins again starts elsewhere
    robot.sensor.forget();
  }
  for (Sender& sender : senders_) {
    const bool was = std::exchange(sender.there, is_there(sender.body));
    if (was != sender.there)
      messages_.drop_if([&](const Message& message) { return message.what.body == sender.body; });
  }
}

Measured TelemetryWorld::measure(double t) noexcept {
  Measured now = SensingWorld::measure(t);
  motions_.clear();
  if (!now.truth.empty())
    for (Robot& robot : robots_) move(robot, t, now);
  last_ = t;
  for (Sender& sender : senders_) send(sender, t, now);
  deliver(t);
  now.motions = motions_;
  now.broadcasts = arrived_;
  return now;
}

/// Samples a robot's motion since the previous call.
void TelemetryWorld::move(Robot& robot, double t, const Measured& now) noexcept {
  if (!robot.there) return;
  const Sight<double> sight = sight_of(robot.body, now.truth);
  const Mat<3, 3> R = matrix(rotation(attitude_of(robot.body, sight, now)));
  if (robot.moves && t > last_)
    motions_.push_back({robot.body, robot.sensor.measure(t, t - last_, robot.p, robot.R, sight.p, R)});
  robot.p = sight.p;
  robot.R = R;
  robot.moves = true;
}

/// Broadcasts the measured pose of a body, if a message is due and the measurement is new.
void TelemetryWorld::send(Sender& sender, double t, const Measured& now) noexcept {
  if (!sender.there || t < static_cast<double>(sender.next) / radio_.rate - same_time) return;
  const double stamp = now.stamps[at(sender.body)];
  if (!(stamp <= t) || !(stamp > sender.last.value_or(-infinity))) return;
  // Messages due in missed periods are skipped, not sent later.
  sender.next = static_cast<std::int64_t>(std::floor((t + same_time) * radio_.rate)) + 1;
  sender.last = stamp;
  RandomStream& chance = sender.chance;
  const double latency = radio_.latency[0] + (radio_.latency[1] - radio_.latency[0]) * chance.uniform();
  const bool lost = chance.uniform() <= radio_.dropout;
  const Sight<double> sight = sight_of(sender.body, now.measured);
  Column<7> w;
  for (int i = 0; i < 7; ++i) w(i, 0) = chance.normal();
  const Column<7>& error = sender.errors.at(stamp, w);
  BroadcastPose pose{.stamp = stamp};
  pose.p = sight.p + radio_.position_sigma * vec3(error);
  pose.v = sight.v + radio_.velocity_sigma * vec3(error, 3);
  pose.psi = wrap(atan2(sight.d.y, sight.d.x) + radio_.heading_sigma * error(6, 0));
  pose.P = identity<4>(square(radio_.position_sigma));
  pose.P(3, 3) = square(radio_.heading_sigma);
  if (!lost) messages_.send({t + latency, {sender.body, pose}});
}

void TelemetryWorld::deliver(double t) noexcept {
  arrived_.clear();
  for (const Message& message : messages_.take(t)) arrived_.push_back(message.what);
}

}  // namespace sightline
