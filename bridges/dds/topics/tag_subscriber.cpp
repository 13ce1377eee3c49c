#include "bridges/dds/topics/tag_subscriber.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "bridges/dds/fleet_findings.hpp"  // clocks_apart
#include "bridges/dds/topics/tag_frames.hpp"
#include "sightline/base.hpp"
#include "sightline/base/now.hpp"
#include "sightline/sensors.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using SeenTag = geometry_msgs_msg_dds__TransformStamped_;
using SeenTags = tf2_msgs_msg_dds__TFMessage_;

constexpr double unit_within = 0.01;          // tolerance of a quaternion's length
constexpr std::int64_t pictures_needed = 10;  // before a camera is judged

std::span<const SeenTag> tags_of_message(const void* message) {
  const auto& all = *static_cast<const SeenTags*>(message);
  return {all.transforms._buffer, all.transforms._length};
}

/// tf2 treats "/camera" as "camera".
std::string_view bare(const char* frame) {
  const std::string_view name = text_in(frame);
  return name.starts_with('/') ? name.substr(1) : name;
}

bool is_a_pose(const SeenTag& tag) {
  const auto& [p, q] = tag.transform;
  const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return std::isfinite(p.x + p.y + p.z) && std::abs(length - 1) < unit_within;
}

/// Vertical axis in S, from the robot's tilt.
Vec3<double> up_in_S(const WatchedCamera& camera) noexcept {
  const Rotation B = rotation(camera.own->last().motion.q);
  const bool level = camera.camera.mount.frame == MountFrame::level || camera.own->last().stamp == 0;
  return sensor_pose(camera.camera.mount, {{}, level ? Rotation{} : B}).R.to_B({0, 0, 1});
}

/// Tags of one body in one image.
struct FoundBody {
  std::array<FoundTag, Tags::faces_max> tags;
  std::size_t count = 0;
};

/// Image positions of a tag's corners; false if the camera does not see one.
bool find_corners(const Camera& camera, const Tags& tags, int face, const SeenTag& seen, FoundTag& found) {
  const auto& [p, q] = seen.transform;
  const RigidPose tag = from_optical({p.x, p.y, p.z}, normalised({q.w, q.x, q.y, q.z}));
  const double half = 0.5 * tags.size;
  const std::array<Vec3<double>, 4> corners = {
      {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}}};
  const double widest = camera.widest();
  found.face = face;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3<double> corner = tag.p + tag.R.to_G(corners[i]);
    if (!camera.sees(corner, widest)) return false;
    found.corners[i] = camera.project(corner);
  }
  return true;
}

/// Pose from all tags of a body, with its covariance.
bool pose_of_body(const WatchedCamera& eye, const Tags& tags, const FoundBody& body, Detection& to) noexcept {
  const Camera& camera = eye.camera.camera;
  const auto found = std::span(body.tags).first(body.count);
  const std::optional<TagPose> estimate = pose_of(camera, tags, found, up_in_S(eye));
  if (!estimate || !(estimate->rms <= TagSubscriber::misfit_most)) return false;
  PoseInformation information(camera, tags, estimate->pose);
  for (const FoundTag& tag : found) {
    const double depth = camera.depth(estimate->pose.p + estimate->pose.R.to_G(tags.centre(tag.face)));
    const double cosine = std::max(0.3, cos_incidence(tags, tag.face, estimate->pose));
    information.add(tag.face, corner_sigma(camera.pixels(tags.size, depth), cosine, camera.noise, 0.0));
  }
  const std::optional<Mat<6, 6>> covariance = information.covariance();
  if (!covariance) return false;
  to.set_covariance(*covariance);
  to.p = estimate->pose.p;
  to.q = quaternion(estimate->pose.R);
  to.tags = static_cast<int>(body.count);
  return true;
}

}  // namespace

TagSubscriber::TagSubscriber(const Scenario& scenario, const std::vector<WatchedCamera>& cameras,
                             dds_entity_t participant)
    : vision_(scenario.vision), ring_(room, Seen{}) {
  for (const WatchedCamera& camera : cameras) eyes_.emplace_back(camera);
  taken_.reserve(most);
  reader_ = std::make_unique<RawReader>(
      participant, tf2_msgs_msg_dds__TFMessage__desc, "/tf", Quality{.depth = 100}, std::nullopt,
      Writers::all, [this](const void* message, const Arrival& arrival) { on_transforms(message, arrival); });
}

void TagSubscriber::on_transforms(const void* message, const Arrival& arrival) noexcept {
  const auto tags = tags_of_message(message);
  const Nanoseconds real_ahead = realtime_now() - monotonic_now();
  for (Eye& eye : eyes_) {
    const auto first = std::find_if(tags.begin(), tags.end(), [&](const SeenTag& tag) {
      return eye.of.camera.frame == bare(tag.header.frame_id);
    });
    if (first == tags.end()) continue;
    ++eye.pictures;
    if (eye.writer == 0) eye.writer = arrival.writer;
    if (eye.writer != arrival.writer) {
      ++eye.foreign;
      continue;
    }
    const Nanoseconds sent = of_ros(first->header.stamp.sec, first->header.stamp.nanosec);
    eye.arrivals.note(sent, arrival.monotonic);
    const Nanoseconds stamp = sent - real_ahead, age = arrival.monotonic - stamp;
    if (age < -to_nanoseconds(ahead_most))
      ++eye.ahead;
    else if (age > to_nanoseconds(age_most))
      ++eye.old;
    else if (!is_new(eye, sent))
      ++eye.repeated;
    else
      look(eye, message, std::min(stamp, arrival.monotonic), arrival.monotonic);
  }
}

bool TagSubscriber::is_new(Eye& eye, Nanoseconds stamp) const noexcept {
  if (std::find(eye.stamps.begin(), eye.stamps.end(), stamp) != eye.stamps.end()) return false;
  eye.stamps[eye.next++ % eye.stamps.size()] = stamp;
  return true;
}

void TagSubscriber::look(Eye& eye, const void* message, Nanoseconds stamp, Nanoseconds arrived) noexcept {
  const auto is_ours = [&](const SeenTag& tag) { return eye.of.camera.frame == bare(tag.header.frame_id); };
  for (const SeenTag& tag : tags_of_message(message)) {
    if (!is_ours(tag)) continue;
    const bool known =
        std::any_of(vision_.tag_frames.begin(), vision_.tag_frames.end(), [&](const auto& frames) {
          return std::find(frames.begin(), frames.end(), bare(tag.child_frame_id)) != frames.end();
        });
    if (!known) ++eye.other_tags;
    if (known && !is_a_pose(tag)) ++eye.garbled;
  }
  for (std::size_t i = 0; i < vision_.tags.size(); ++i) {
    const auto& [body, tags] = vision_.tags[i];
    FoundBody found;
    if (body == eye.of.camera.observer) continue;
    for (const SeenTag& tag : tags_of_message(message)) {
      if (!is_ours(tag) || !is_a_pose(tag)) continue;
      const auto& frames = vision_.tag_frames[i];
      const auto face = std::find(frames.begin(), frames.end(), bare(tag.child_frame_id)) - frames.begin();
      const bool again = std::any_of(found.tags.begin(), found.tags.begin() + found.count,
                                     [&](const FoundTag& one) { return one.face == face; });
      if (face == std::ssize(frames) || again) continue;
      if (find_corners(eye.of.camera.camera, tags, static_cast<int>(face), tag, found.tags[found.count]))
        ++found.count;
      else
        ++eye.garbled;
    }
    if (found.count == 0) continue;
    Seen seen{.stamp = stamp, .arrived = arrived};
    seen.detection.observer = eye.of.camera.observer;
    seen.detection.target = body;
    if (!pose_of_body(eye.of, tags, found, seen.detection)) {
      ++eye.misfits;
      continue;
    }
    if (Seen* const place = ring_.claim()) {
      *place = seen;
      ring_.publish();
    } else {
      ++eye.lost;
    }
  }
}

std::span<const Detection> TagSubscriber::take(Nanoseconds origin) noexcept {
  taken_.clear();
  for (; taken_.size() < most && ring_.front() != nullptr; ring_.pop()) {
    const Seen& seen = *ring_.front();
    taken_.push_back(seen.detection);
    taken_.back().stamp = to_seconds(seen.stamp - origin);
    taken_.back().arrival = to_seconds(seen.arrived - origin);
  }
  return taken_;
}

void TagSubscriber::forget() noexcept {
  while (ring_.front() != nullptr) ring_.pop();
}

const TagSubscriber::Eye* TagSubscriber::eye_of(BodyId robot) const {
  const auto found = std::find_if(eyes_.begin(), eyes_.end(),
                                  [&](const Eye& eye) { return eye.of.camera.observer == robot; });
  return found != eyes_.end() ? &*found : nullptr;
}

void TagSubscriber::examine(BodyId robot, const Surroundings& around, FindingList& to) const {
  const Eye* const eye = eye_of(robot);
  if (eye == nullptr) return;
  const RobotCamera& camera = eye->of.camera;
  if (reader_->counts().received == 0 && around.writers_of(reader_->topic()).empty())
    to.add(Aspect::camera, Light::red, "/tf: it has no publisher, expected the tags that its camera finds");
  if (eye->foreign > 0)
    to.add(Aspect::writers, Light::red, "/tf: {} pictures of {} of a second writer", eye->foreign.load(),
           camera.frame);
  const Nanoseconds now = monotonic_now();
  const ArrivalFigures f = eye->arrivals.figures(now, realtime_now() - now);
  const double longest = camera.camera.latency[1];
  if (eye->ahead > 0)
    to.add(Aspect::camera, Light::red,
           "{} pictures are ahead of our clock by up to {:.3f} s: have one of chrony or PTP set both",
           eye->ahead.load(), -f.delay_least);
  if (eye->old > 0)
    to.add(Aspect::camera, Light::red, "{} pictures are more than {} s old: its clock is not ours, or late",
           eye->old.load(), age_most);
  if (f.count == 0) {
    to.add(Aspect::camera, Light::unknown,
           "no tag was found yet from {}: in the air it turns until it sees one", camera.frame);
    return;
  }
  if (f.count < pictures_needed) return;
  const bool rare = f.rate < 0.5 * camera.camera.rate;
  const bool late = f.delay_median > longest + clocks_apart;
  to.add(Aspect::camera,
         eye->ahead + eye->old > 0 ? Light::red
         : rare || late            ? Light::unknown
                                   : Light::green,
         "{:.0f} pictures with tags a second, {:.0f} ms after the exposure; camera.rate = {:g} Hz, "
         "camera.latency = [{:g}, {:g}] s",
         f.rate, 1e3 * f.delay_median, camera.camera.rate, camera.camera.latency[0], longest);
}

std::string TagSubscriber::counts(BodyId robot) const {
  const Eye* const eye = eye_of(robot);
  if (eye == nullptr) return {};
  return fmt::format(
      "{} pictures with tags, {} tags not finite or no poses, {} of no body, {} pictures of the future, "
      "{} too old, {} repeated, {} of a second writer, {} bodies that did not fit, {} lost",
      eye->pictures.load(), eye->garbled.load(), eye->other_tags.load(), eye->ahead.load(), eye->old.load(),
      eye->repeated.load(), eye->foreign.load(), eye->misfits.load(), eye->lost.load());
}

}  // namespace sightline::dds
