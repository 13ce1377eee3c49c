#include "sightline/world/telemetry_world.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base/index.hpp"
#include "sightline/base/refuse.hpp"
#include "sightline/base/same_time.hpp"
#include "sightline/world/sighting.hpp"

namespace sightline {
namespace {

constexpr std::uint64_t stream_of_messages = 0x7261646961ULL;

}  // namespace

void Radio::check() const {
  check_parameters(*this);
  if (latency[0] > latency[1])
    refuse("latency = [{}, {}], expected the shortest first", latency[0], latency[1]);
}

TelemetryWorld::TelemetryWorld(std::unique_ptr<World> world, const TelemetryOptions& options)
    : world_(std::move(world)), radio_(options.radio), applied_(size(world_->team().nu())) {
  const Team& all = world_->team();
  const MeasuredMost most = world_->measured_max();
  if (most.motions > 0 || most.broadcasts > 0)
    refuse("the world gives telemetry of its own, expected one without");
  radio_.check();
  const auto check_body = [&](BodyId body) {
    if (body.index < 0 || body.index >= all.bodies())
      refuse("telemetry of body {}, expected one of the team's {}", body.index, all.bodies());
  };
  for (const MovingRobot& one : options.robots) {
    check_body(one.robot);
    robots_.push_back({one.robot, MotionSensor(one.errors, options.seed, one.robot.index)});
  }
  for (const BodyId body : options.broadcasters) {
    check_body(body);
    senders_.push_back(
        {.body = body,
         .chance = RandomStream(options.seed ^ stream_of_messages, Chance::motion, body.index)});
  }
  motions_.reserve(robots_.size());
  // Messages on their way, and one more for each end of the drawn range.
  const auto under_way = static_cast<std::size_t>(std::ceil(radio_.latency[1] * radio_.rate)) + 2;
  waiting_.resize(under_way * senders_.size());
  arrived_.reserve(waiting_.size());
}

MeasuredMost TelemetryWorld::measured_max() const noexcept {
  MeasuredMost most = world_->measured_max();
  most.motions = robots_.size();
  most.broadcasts = waiting_.size();
  return most;
}

void TelemetryWorld::set_presence(std::span<const Presence> presence) noexcept {
  world_->set_presence(presence);
  const auto is_there = [&](BodyId body) {
    return at(body) >= presence.size() || presence[at(body)] != Presence::absent;
  };
  for (Robot& robot : robots_) {
    const bool was = std::exchange(robot.there, is_there(robot.body));
    if (was == robot.there) continue;
    robot.moves = false;  // one that comes again is elsewhere
    robot.sensor.forget();
  }
  for (Sender& sender : senders_) {
    const bool was = std::exchange(sender.there, is_there(sender.body));
    if (was == sender.there) continue;
    const auto of_it = [&](const Message& message) { return message.what.body == sender.body; };
    const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_);
    waiting_count_ =
        static_cast<std::size_t>(std::remove_if(waiting_.begin(), end, of_it) - waiting_.begin());
  }
}

Measured TelemetryWorld::measure(double t) noexcept {
  Measured now = world_->measure(t);
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

Sight<double> TelemetryWorld::sight_of(BodyId body, std::span<const double> x) const noexcept {
  const Team& all = team();
  return all.model(body).sight(&x[size(all.state_offset(body))], applied_.data() + all.input_offset(body));
}

/// Tells how a robot moved since the last time.
void TelemetryWorld::move(Robot& robot, double t, const Measured& now) noexcept {
  if (!robot.there) return;
  const Sight<double> sight = sight_of(robot.body, now.truth);
  const auto place = at(robot.body);
  const bool told = place < now.attitudes.size() && now.attitudes[place] != no_attitude;
  const Mat<3, 3> R = matrix(rotation(told ? now.attitudes[place] : leaning(sight.d, sight.lean)));
  if (robot.moves && t > last_)
    motions_.push_back({robot.body, robot.sensor.measure(t, t - last_, robot.p, robot.R, sight.p, R)});
  robot.p = sight.p;
  robot.R = R;
  robot.moves = true;
}

/// Sends what a body knows of its pose, when that is due and new.
void TelemetryWorld::send(Sender& sender, double t, const Measured& now) noexcept {
  if (!sender.there || t < static_cast<double>(sender.next) / radio_.rate - same_time) return;
  const double stamp = now.stamps[at(sender.body)];
  if (!(stamp <= t) || !(stamp > sender.last.value_or(-std::numeric_limits<double>::infinity()))) return;
  // Of messages that missed periods left out, none comes later.
  sender.next = static_cast<std::int64_t>(std::floor((t + same_time) * radio_.rate)) + 1;
  sender.last = stamp;
  RandomStream& chance = sender.chance;
  const double latency = radio_.latency[0] + (radio_.latency[1] - radio_.latency[0]) * chance.uniform();
  const bool lost = chance.uniform() <= radio_.dropout;
  const Sight<double> sight = sight_of(sender.body, now.measured);
  BroadcastPose pose{.stamp = stamp};
  pose.p = sight.p + radio_.position_sigma * chance.normals();
  pose.v = sight.v + radio_.velocity_sigma * chance.normals();
  pose.psi = wrap(atan2(sight.d.y, sight.d.x) + radio_.heading_sigma * chance.normal());
  pose.P = identity<4>(square(radio_.position_sigma));
  pose.P(3, 3) = square(radio_.heading_sigma);
  if (lost || waiting_count_ == waiting_.size()) return;
  waiting_[waiting_count_++] = {t + latency, {sender.body, pose}};
}

/// Takes what arrives by t from what waits.
void TelemetryWorld::deliver(double t) noexcept {
  arrived_.clear();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < waiting_count_; ++i) {
    if (waiting_[i].arrival <= t + same_time)
      arrived_.push_back(waiting_[i].what);
    else
      waiting_[kept++] = waiting_[i];
  }
  waiting_count_ = kept;
}

bool TelemetryWorld::apply(double t, std::span<const double> believed, std::span<const double> u,
                           double period, std::int64_t periods) noexcept {
  std::copy(u.begin(), u.end(), applied_.begin());
  return world_->apply(t, believed, u, period, periods);
}

}  // namespace sightline
