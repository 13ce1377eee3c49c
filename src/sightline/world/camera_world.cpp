#include "sightline/world/camera_world.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base/index.hpp"
#include "sightline/base/refuse.hpp"
#include "sightline/base/same_time.hpp"

namespace sightline {

CameraWorld::CameraWorld(std::unique_ptr<World> world, CameraOptions options,
                         std::unique_ptr<DetectionSource> source)
    : world_(std::move(world)), options_(std::move(options)), source_(std::move(source)) {
  const Team& all = world_->team();
  if (world_->measured_max().detections > 0)
    refuse("the world gives detections of its own, expected one without");
  const auto check_body = [&](BodyId body) {
    if (body.index < 0 || body.index >= all.bodies())
      refuse("a camera, tags or a hull of body {}, expected one of the team's {}", body.index, all.bodies());
  };
  std::size_t room = 0;
  for (const RobotCamera& one : options_.cameras) {
    one.camera.check();
    check_body(one.observer);
    // Pictures on their way, and one more for each end of the drawn range.
    room += (static_cast<std::size_t>(std::ceil(one.camera.latency[1] * one.camera.rate)) + 2) *
            options_.tags.size();
    shutters_.push_back({0, RandomStream(options_.seed, Chance::latency, one.observer.index)});
  }
  for (const BodyTags& one : options_.tags) one.tags.check(), check_body(one.body);
  for (const BodyHull& one : options_.hulls) check_parameters(one.hull), check_body(one.body);
  bodies_.resize(size(all.bodies()));
  applied_.resize(size(all.nu()));
  found_.resize(options_.tags.size());
  waiting_.resize(room);
  arrived_.resize(room);
}

void CameraWorld::set_presence(std::span<const Presence> presence) noexcept {
  world_->set_presence(presence);
  for (std::size_t i = 0; i < std::min(presence.size(), bodies_.size()); ++i) {
    const bool there = presence[i] != Presence::absent, was = std::exchange(bodies_[i].there, there);
    if (was == there) continue;
    const BodyId body{static_cast<int>(i)};
    const auto of_it = [&](const Detection& d) { return d.observer == body || d.target == body; };
    const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_);
    waiting_count_ =
        static_cast<std::size_t>(std::remove_if(waiting_.begin(), end, of_it) - waiting_.begin());
  }
}

Measured CameraWorld::measure(double t) noexcept {
  Measured now = world_->measure(t);
  if (now.truth.empty()) return now;
  place_bodies(now);
  for (std::size_t i = 0; i < shutters_.size(); ++i) {
    const double rate = options_.cameras[i].camera.rate;
    if (t < static_cast<double>(shutters_[i].next) / rate - same_time) continue;
    take_picture(i, t);
    // Of pictures that missed periods left out, none comes later.
    shutters_[i].next = static_cast<std::int64_t>(std::floor((t + same_time) * rate)) + 1;
  }
  last_ = t;
  now.detections = arrived(t);
  return now;
}

bool CameraWorld::apply(double t, std::span<const double> believed, std::span<const double> u, double period,
                        std::int64_t periods) noexcept {
  std::copy(u.begin(), u.end(), applied_.begin());
  return world_->apply(t, believed, u, period, periods);
}

/// What arrives by t, taken from what waits.
std::span<const Detection> CameraWorld::arrived(double t) noexcept {
  std::size_t count = 0, kept = 0;
  for (std::size_t i = 0; i < waiting_count_; ++i) {
    Detection& to = waiting_[i].arrival <= t + same_time ? arrived_[count++] : waiting_[kept++];
    to = waiting_[i];
  }
  waiting_count_ = kept;
  // Insertion keeps the order of equals and takes no memory.
  for (std::size_t i = 1; i < count; ++i) {
    for (std::size_t k = i; k > 0 && arrived_[k].arrival < arrived_[k - 1].arrival; --k)
      std::swap(arrived_[k], arrived_[k - 1]);
  }
  return std::span(arrived_).first(count);
}

void CameraWorld::place_bodies(const Measured& now) noexcept {
  const Team& all = world_->team();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const BodyId body{static_cast<int>(i)};
    const Sight<double> sight = all.model(body).sight(&now.truth[size(all.state_offset(body))],
                                                      applied_.data() + all.input_offset(body));
    const bool told = i < now.attitudes.size() && now.attitudes[i] != no_attitude;
    bodies_[i].before = bodies_[i].now;
    bodies_[i].now = {sight.p, rotation(told ? now.attitudes[i] : leaning(sight.d, sight.lean))};
  }
}

void CameraWorld::take_picture(std::size_t camera, double t) noexcept {
  const RobotCamera& of = options_.cameras[camera];
  RandomStream& chance = shutters_[camera].chance;
  const double latency =
      of.camera.latency[0] + (of.camera.latency[1] - of.camera.latency[0]) * chance.uniform();
  const bool lost = chance.uniform() <= of.camera.dropout;
  const std::size_t count = source_->find({camera, t, last_ ? t - *last_ : 0.0, bodies_}, found_);
  for (std::size_t i = 0; i < count && !lost && waiting_count_ < waiting_.size(); ++i) {
    found_[i].stamp = t;
    found_[i].arrival = t + latency;
    waiting_[waiting_count_++] = found_[i];
  }
}

}  // namespace sightline
