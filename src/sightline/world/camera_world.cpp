#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/world/sighting.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

/// Gives a detection of a further camera in the frame S of the robot's first one.
void give_in_first(Detection& found, const RobotCamera& first, const RobotCamera& of) noexcept {
  const RigidPose S = seen_from(sensor_pose(first.mount, {}), sensor_pose(of.mount, {}));
  found.p = S.p + S.R.to_G(found.p);
  if (found.is_oriented()) found.q = quaternion(compose(S.R, rotation(found.q)));
  Mat<6, 6> R;
  set_block(R, 0, 0, matrix(S.R));
  set_block(R, 3, 3, matrix(S.R));
  found.set_covariance(R * found.covariance_matrix() * transposed(R));
}

}  // namespace

CameraWorld::CameraWorld(std::unique_ptr<World> world, CameraOptions options,
                         std::unique_ptr<DetectionSource> source)
    : SensingWorld(std::move(world)), options_(std::move(options)), source_(std::move(source)) {
  const Team& all = team();
  if (SensingWorld::measured_max().detections > 0)
    throw_invalid("the world gives detections of its own, expected one without");
  const auto check_body = [&](BodyId body) {
    if (body.index < 0 || body.index >= all.bodies())
      throw_invalid("a camera, tags or a hull of body {}, expected one of the team's {}", body.index,
                    all.bodies());
  };
  std::size_t room = 0;
  for (const RobotCamera& one : options_.cameras) {
    one.camera.check();
    check_body(one.observer);
    // Pictures in transit, plus one for each end of the latency range.
    room += (static_cast<std::size_t>(std::ceil(one.camera.latency[1] * one.camera.rate)) + 2) *
            options_.tags.size();
    shutters_.push_back(
        {0, RandomStream(options_.seed, StreamId::latency, stream_of(options_, shutters_.size()))});
  }
  for (const BodyTags& one : options_.tags) one.tags.check(), check_body(one.body);
  for (const BodyHull& one : options_.hulls) check_parameters(one.hull), check_body(one.body);
  bodies_.resize(size(all.bodies()));
  found_.resize(options_.tags.size());
  detections_ = UnderWay<Detection>(room);
}

void CameraWorld::set_presence(std::span<const Presence> presence) noexcept {
  SensingWorld::set_presence(presence);
  for (std::size_t i = 0; i < std::min(presence.size(), bodies_.size()); ++i) {
    const bool there = presence[i] != Presence::absent, was = std::exchange(bodies_[i].there, there);
    if (was == there) continue;
    const BodyId body{static_cast<int>(i)};
    detections_.drop_if([&](const Detection& d) { return d.observer == body || d.target == body; });
  }
}

Measured CameraWorld::measure(double t) noexcept {
  Measured now = SensingWorld::measure(t);
  if (now.truth.empty()) return now;
  place_bodies(now);
  for (std::size_t i = 0; i < shutters_.size(); ++i) {
    const double rate = options_.cameras[i].camera.rate;
    if (t < static_cast<double>(shutters_[i].next) / rate - same_time) continue;
    take_picture(i, t);
    // Pictures due in missed periods are skipped, not taken later.
    shutters_[i].next = static_cast<std::int64_t>(std::floor((t + same_time) * rate)) + 1;
  }
  last_ = t;
  now.detections = detections_.take(t);
  return now;
}

void CameraWorld::place_bodies(const Measured& now) noexcept {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const BodyId body{static_cast<int>(i)};
    const Sight<double> sight = sight_of(body, now.truth);
    bodies_[i].before = bodies_[i].now;
    bodies_[i].now = {sight.p, rotation(attitude_of(body, sight, now))};
  }
}

void CameraWorld::take_picture(std::size_t camera, double t) noexcept {
  const RobotCamera& of = options_.cameras[camera];
  const RobotCamera* const first = options_.camera_of(of.observer);
  RandomStream& chance = shutters_[camera].chance;
  const double latency =
      of.camera.latency[0] + (of.camera.latency[1] - of.camera.latency[0]) * chance.uniform();
  const bool lost = chance.uniform() <= of.camera.dropout;
  const std::size_t count = source_->find({camera, t, last_ ? t - *last_ : 0.0, bodies_}, found_);
  for (std::size_t i = 0; i < count && !lost; ++i) {
    found_[i].stamp = t;
    found_[i].arrival = t + latency;
    if (of.camera.output == CameraOutput::position) found_[i].forget_attitude();
    if (&of != first) give_in_first(found_[i], *first, of);
    detections_.send(found_[i]);
  }
}

}  // namespace sightline
