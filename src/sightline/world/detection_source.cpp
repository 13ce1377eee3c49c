#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/sensors.hpp"
#include "sightline/world.hpp"

namespace sightline {

RigidPose camera_pose(const RobotCamera& camera, const Rotation& turned, const RigidPose& body) {
  RigidPose S = sensor_pose(camera.mount, body);
  S.R = compose(S.R, turned);
  return S;
}

int stream_of(const CameraOptions& options, std::size_t camera) {
  constexpr int bodies_most = 4096;
  const auto begin = options.cameras.begin();
  const BodyId observer = options.cameras[camera].observer;
  const auto earlier = std::count_if(begin, begin + static_cast<std::ptrdiff_t>(camera),
                                     [&](const RobotCamera& one) { return one.observer == observer; });
  return observer.index + bodies_most * static_cast<int>(earlier);
}

std::vector<Rotation> drawn_misalignments(const CameraOptions& options) {
  std::vector<Rotation> all;
  for (std::size_t i = 0; i < options.cameras.size(); ++i) {
    const Vec3<double> axis = RandomStream(options.seed, StreamId::mounting, stream_of(options, i)).normals();
    const double size = norm(axis);
    all.push_back(size > 0 ? turn_by((options.cameras[i].camera.misalignment / size) * axis) : Rotation{});
  }
  return all;
}

Vec2<double> smear_of(const CameraOptions& options, const Exposure& exposure, const Rotation& turned,
                      BodyId body) {
  const RobotCamera& one = options.cameras[exposure.camera];
  if (!(exposure.since > 0)) return {};
  const ExposedBody &eye = exposure.bodies[at(one.observer)], &seen = exposure.bodies[at(body)];
  const Vec3<double> now = seen_from(camera_pose(one, turned, eye.now), seen.now).p,
                     before = seen_from(camera_pose(one, turned, eye.before), seen.before).p;
  if (!(one.camera.depth(now) > 0.05 && one.camera.depth(before) > 0.05)) return {};
  const Vec2<double> a = one.camera.project(before), b = one.camera.project(now);
  const double part = one.camera.exposure / exposure.since;
  return {part * (b.x - a.x), part * (b.y - a.y)};
}

}  // namespace sightline
