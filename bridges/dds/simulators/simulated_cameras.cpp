#include "bridges/dds/simulators/simulated_cameras.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>
#include <utility>

#include "bridges/dds/simulators/vehicle_simulator.hpp"
#include "bridges/dds/topics/tag_frames.hpp"
#include "sightline/base.hpp"
#include "sightline/base/now.hpp"
#include "sightline/scenario/read_camera.hpp"
#include "sightline/sensors.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

constexpr double kept_for = 11.0;  // memory kept for delayed messages [s]

/// Faces of a body, best visible first.
std::vector<int> faces_by_sight(const Tags& tags, const RigidPose& pose) {
  std::vector<int> faces(size(tags.faces));
  for (int face = 0; face < tags.faces; ++face) faces[size(face)] = face;
  std::stable_sort(faces.begin(), faces.end(),
                   [&](int a, int b) { return cos_incidence(tags, a, pose) > cos_incidence(tags, b, pose); });
  return faces;
}

}  // namespace

/// World with the true states of all bodies.
struct SimulatedCameras::Truth final : World {
  explicit Truth(const Scenario& scenario)
      : team_(scenario.team),
        x(scenario.x0),
        stamps(size(team_.bodies())),
        attitudes(size(team_.bodies()), no_attitude) {}

  const Team& team() const noexcept override { return team_; }
  std::span<const double> start() const noexcept override { return x; }
  void set_presence(std::span<const Presence>) noexcept override {}
  Measured measure(double) noexcept override {
    return {.measured = x, .stamps = stamps, .truth = x, .attitudes = attitudes};
  }
  bool apply(double, std::span<const double>, const sightline::Command&, double,
             std::int64_t) noexcept override {
    return true;
  }

  Team team_;
  std::vector<double> x, stamps;
  std::vector<Quaternion> attitudes;
};

struct SimulatedCameras::Eye {
  /// A message and the memory it points to.
  struct Picture {
    std::deque<std::string> names;
    std::vector<geometry_msgs_msg_dds__TransformStamped_> transforms;
  };
  RobotCamera camera;
  Faults* faults;
  RandomStream chance;
  std::unique_ptr<FaultyWriter> writer;
  std::deque<Picture> sent{};  // memory of messages that may be delayed
  std::optional<std::vector<Detection>> frozen{};
  std::int64_t pictures = 0;
};

SimulatedCameras::SimulatedCameras(dds_entity_t participant, const Scenario& scenario,
                                   const std::vector<Faults*>& faults)
    : vision_(camera_options(scenario)) {
  if (vision_.cameras.empty() || vision_.tags.empty()) return;
  const auto& links = fleet_of(scenario).links;
  for (const Link& link : links) {
    models_.emplace_back(scenario.team.model(link.robot));
    places_.push_back(size(scenario.team.state_offset(link.robot)));
    bodies_.push_back(link.robot.index);
  }
  for (const RobotCamera& camera : vision_.cameras) {
    const auto link = std::find_if(links.begin(), links.end(),
                                   [&](const Link& one) { return one.robot == camera.observer; });
    if (link == links.end()) continue;
    Faults* const its = faults[static_cast<std::size_t>(link - links.begin())];
    eyes_.push_back(std::make_unique<Eye>(
        Eye{camera, its, RandomStream(vision_.seed, StreamId::fault, 1000 + camera.observer.index),
            std::make_unique<FaultyWriter>(participant, tf2_msgs_msg_dds__TFMessage__desc, "/tf",
                                           Quality{.reliable = true, .depth = 100}, *its)}));
  }
  auto truth = std::make_unique<Truth>(scenario);
  truth_ = truth.get();
  cameras_ = std::make_unique<CameraWorld>(std::move(truth), vision_,
                                           std::make_unique<SyntheticDetections>(scenario.team, vision_));
}

SimulatedCameras::~SimulatedCameras() = default;

void SimulatedCameras::step(std::int64_t number, std::span<const Motion> robots,
                            std::span<const double> states) {
  if (!cameras_) return;
  std::copy(states.begin(), states.end(), truth_->x.begin());
  for (std::size_t i = 0; i < robots.size(); ++i) {
    models_[i].write(robots[i], &truth_->x[places_[i]]);
    truth_->attitudes[size(bodies_[i])] = robots[i].q;
  }
  times_[static_cast<std::size_t>(number) % times_.size()] = realtime_now();
  const Measured now = cameras_->measure(static_cast<double>(number) * VehicleSimulator::period);
  // Detections of one image are sent as one message.
  for (const auto& eye : eyes_) {
    std::vector<Detection> found;
    for (const Detection& one : now.detections) {
      if (one.observer != eye->camera.observer) continue;
      if (!found.empty() && found.back().stamp != one.stamp) send(*eye, std::exchange(found, {}));
      found.push_back(one);
    }
    if (!found.empty()) send(*eye, found);
  }
}

void SimulatedCameras::send(Eye& eye, std::span<const Detection> found) {
  if (eye.faults->on(LinkFaultKind::blind)) return;
  const auto exposed = static_cast<std::size_t>(std::llround(found[0].stamp / VehicleSimulator::period));
  const RosTime stamp = to_ros(times_[exposed % times_.size()]);
  if (!eye.faults->on(LinkFaultKind::frozen))
    eye.frozen.reset();
  else if (!eye.frozen)
    eye.frozen.emplace(found.begin(), found.end());
  Eye::Picture& picture = eye.sent.emplace_back();
  if (static_cast<double>(eye.sent.size()) > kept_for * eye.camera.camera.rate + 1) eye.sent.pop_front();
  char* const parent = picture.names.emplace_back(eye.camera.frame).data();
  for (const Detection& one : eye.frozen ? std::span<const Detection>(*eye.frozen) : found) {
    const BodyTags* const tags = vision_.tags_of(one.target);
    const auto& frames = vision_.tag_frames[static_cast<std::size_t>(tags - vision_.tags.data())];
    const RigidPose body = {one.p, rotation(one.q)};
    const std::vector<int> faces = faces_by_sight(tags->tags, body);
    for (std::size_t i = 0; i < std::min(size(one.tags), faces.size()); ++i) {
      const RigidPose on_body = tag_on_body(tags->tags, faces[i]);
      OpticalPose tag = in_optical({body.p + body.R.to_G(on_body.p), compose(body.R, on_body.R)});
      if (eye.faults->on(LinkFaultKind::not_finite) &&
          eye.chance.uniform() <= eye.faults->size(LinkFaultKind::not_finite))
        tag.p.x = std::numeric_limits<double>::quiet_NaN();
      picture.transforms.push_back({{{stamp.sec, stamp.nanosec}, parent},
                                    picture.names.emplace_back(frames[size(faces[i])]).data(),
                                    {{tag.p.x, tag.p.y, tag.p.z}, {tag.q.x, tag.q.y, tag.q.z, tag.q.w}}});
    }
  }
  tf2_msgs_msg_dds__TFMessage_ message{};
  message.transforms._buffer = picture.transforms.data();
  message.transforms._length = message.transforms._maximum =
      static_cast<std::uint32_t>(picture.transforms.size());
  eye.writer->write(&message);
  ++eye.pictures;
}

std::string SimulatedCameras::counts() const {
  std::vector<std::string> words;
  for (const auto& eye : eyes_) words.push_back(fmt::format("{} of {}", eye->pictures, eye->camera.frame));
  return words.empty() ? "" : fmt::format("pictures with tags: {}", fmt::join(words, ", "));
}

}  // namespace sightline::dds
