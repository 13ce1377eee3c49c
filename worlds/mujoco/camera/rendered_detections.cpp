#include "worlds/mujoco/camera/rendered_detections.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "sightline/base.hpp"
#include "sightline/sensors.hpp"

namespace sightline::mujoco {

RenderedDetections::RenderedDetections(const Team& team, const CameraOptions& options,
                                       const std::optional<ModelFile>& surroundings)
    : options_(options),
      turned_(drawn_misalignments(options)),
      numbers_(number_tags(options)),
      synthetic_(team, options),
      scene_(team, options, surroundings, finder_) {
  for (std::size_t i = 0; i < options_.cameras.size(); ++i) {
    const Camera& camera = options_.cameras[i].camera;
    pictures_.emplace_back(camera.width, camera.height);
    chance_.emplace_back(options_.seed, StreamId::picture, stream_of(options_, i));
  }
}

bool RenderedDetections::take(const Exposure& exposure, const RigidPose& eye) noexcept {
  const Camera& camera = options_.cameras[exposure.camera].camera;
  const std::span<const std::uint8_t> rgb = scene_.render(exposure, eye);
  if (rgb.empty()) return false;
  // The motion blur is that of the nearest body ahead of the camera.
  double nearest = std::numeric_limits<double>::infinity();
  Vec2<double> way{};
  for (const BodyTags& one : options_.tags) {
    const ExposedBody& body = exposure.bodies[at(one.body)];
    const double depth = eye.R.to_B(body.now.p - eye.p).x;
    if (!body.there || one.body == options_.cameras[exposure.camera].observer ||
        !(depth > 0 && depth < nearest))
      continue;
    nearest = depth;
    way = smear_of(options_, exposure, turned_[exposure.camera], one.body);
  }
  Picture& picture = pictures_[exposure.camera];
  picture.take(rgb);
  picture.blur(camera.blur);
  picture.smear(way);
  picture.add_noise(camera.noise, chance_[exposure.camera]);
  return true;
}

std::size_t RenderedDetections::find(const Exposure& exposure, std::span<Detection> found) noexcept {
  const RobotCamera& of = options_.cameras[exposure.camera];
  if (!of.render) return synthetic_.find(exposure, found);
  const ExposedBody& own = exposure.bodies[at(of.observer)];
  if (!own.there) return 0;
  constexpr double given_within = 0.012;  // error of the observer's attitude [rad]
  const Vec3<double> error = given_within * chance_[exposure.camera].normals();
  const RigidPose reported = sensor_pose(of.mount, {own.now.p, compose(turn_by(error), own.now.R)});
  if (!take(exposure, camera_pose(of, turned_[exposure.camera], own.now))) return 0;
  seen_ = &finder_.find(pictures_[exposure.camera]);
  std::size_t count = 0;
  for (std::size_t i = 0; i < numbers_.size() && count < found.size(); ++i) {
    if (detect(exposure, i, reported.R.to_B({0, 0, 1}), found[count])) ++count;
  }
  return count;
}

bool RenderedDetections::detect(const Exposure& exposure, std::size_t number, const Vec3<double>& up,
                                Detection& found) const noexcept {
  constexpr double misfit_max = 3.0;  // rejects corners of other objects [px]
  const RobotCamera& of = options_.cameras[exposure.camera];
  const auto& [body, tags] = options_.tags[number];
  std::array<FoundTag, Tags::faces_max> all;
  std::size_t count = 0;
  for (const TagInPicture& one : *seen_) {
    const int face = one.id - numbers_[number].first;
    if (face < 0 || face >= numbers_[number].count || count == all.size()) continue;
    all[count++] = {face, one.corners};
  }
  const auto tags_found = std::span(all).first(count);
  const std::optional<TagPose> said = pose_of(of.camera, tags, tags_found, up);
  if (!said || said->rms > misfit_max || body == of.observer) return false;
  const Vec2<double> way = smear_of(options_, exposure, turned_[exposure.camera], body);
  PoseInformation information(of.camera, tags, said->pose);
  for (const FoundTag& tag : tags_found) {
    const double depth = of.camera.depth(said->pose.p + said->pose.R.to_G(tags.centre(tag.face)));
    const double cosine = std::max(0.3, cos_incidence(tags, tag.face, said->pose));
    information.add(tag.face, corner_sigma(of.camera.pixels(tags.size, depth), cosine, of.camera.noise,
                                           norm(way.x, way.y)));
  }
  const std::optional<Mat<6, 6>> covariance = information.covariance();
  if (!covariance) return false;
  found.set_covariance(*covariance);
  found.observer = of.observer;
  found.target = body;
  found.p = said->pose.p;
  found.q = quaternion(said->pose.R);
  found.tags = static_cast<int>(count);
  return true;
}

}  // namespace sightline::mujoco
