#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/base.hpp"
#include "sightline/sensors.hpp"

namespace sightline {

/// All random numbers for one body in one picture.
struct SyntheticDetections::Draws {
  std::array<double, Tags::faces_max> faces{};
  Column<6> errors{};
  std::array<double, 3> place{};
  double mirror, outlier, kind, flip, angle, side;

  Draws(RandomStream& stream, GaussMarkov<6>& process, double t) noexcept {
    for (double& u : faces) u = stream.uniform();
    Column<6> w;
    for (int i = 0; i < 6; ++i) w(i, 0) = stream.normal();
    errors = process.at(t, w);
    for (double& u : place) u = stream.uniform();
    for (double* const u : {&mirror, &outlier, &kind, &flip, &angle, &side}) *u = stream.uniform();
  }
};

SyntheticDetections::SyntheticDetections(const Team& team, const CameraOptions& options)
    : options_(options), turned_(drawn_misalignments(options)) {
  for (std::size_t i = 0; i < options_.cameras.size(); ++i) {
    for (const BodyTags& tags : options_.tags) {
      streams_.emplace_back(options_.seed, StreamId::sighting,
                            stream_of(options_, i) * team.bodies() + tags.body.index);
      errors_.emplace_back(options_.cameras[i].camera.correlation_time);
    }
  }
}

double SyntheticDetections::probability(double n, double cosine, double smear) {
  if (cosine < cos(incidence_max)) return 0.0;
  const double n_0 = half_found + 9.4 * std::clamp(smear - 1, 0.0, 1.0);
  return 0.99 / (1 + exp((n_0 - n * readable(cosine)) / 0.7));
}

double SyntheticDetections::readable(double cosine) { return sqrt(cosine * sqrt(cosine * sqrt(cosine))); }

double SyntheticDetections::mirror_share(double n, double cosine) {
  constexpr double ahead = 0.35;  // [rad]
  if (cosine < cos(ahead) || n > 22) return 0.0;
  return n < 16 ? 0.35 : 0.2;
}

std::size_t SyntheticDetections::find(const Exposure& exposure, std::span<Detection> found) noexcept {
  std::size_t count = 0;
  for (std::size_t i = 0; i < options_.tags.size() && count < found.size(); ++i) {
    if (detect(exposure, i, found[count])) ++count;
  }
  return count;
}

bool SyntheticDetections::hidden(const Exposure& exposure, BodyId observer, BodyId target,
                                 const Vec3<double>& eye, const Vec3<double>& point) const noexcept {
  return std::any_of(options_.hulls.begin(), options_.hulls.end(), [&](const BodyHull& one) {
    const ExposedBody& body = exposure.bodies[at(one.body)];
    return one.body != observer && one.body != target && body.there && one.hull.hides(body.now.p, eye, point);
  });
}

bool SyntheticDetections::detect(const Exposure& exposure, std::size_t number, Detection& found) noexcept {
  const RobotCamera& of = options_.cameras[exposure.camera];
  const auto& [body, tags] = options_.tags[number];
  const Camera& camera = of.camera;
  const std::size_t pair = exposure.camera * options_.tags.size() + number;
  const Draws draws(streams_[pair], errors_[pair], exposure.time);
  const ExposedBody &own = exposure.bodies[at(of.observer)], &target = exposure.bodies[at(body)];
  if (body == of.observer || !own.there || !target.there) return false;

  const Rotation& turned = turned_[exposure.camera];
  const RigidPose S = camera_pose(of, turned, own.now), pose = seen_from(S, target.now);
  const Vec2<double> way = smear_of(options_, exposure, turned, body);
  const double smear = norm(way.x, way.y);

  // Each tag is found independently.
  PoseInformation information(camera, tags, pose);
  int seen = 0, face_seen = 0;
  double n_seen = 0.0, cos_seen = 0.0;
  const double widest = camera.widest();
  const auto in_picture = [&](const Vec3<double>& p) {
    if (!camera.sees(p, widest)) return false;
    const Vec2<double> q = camera.project(p);
    return std::abs(q.x) < 0.5 * camera.width - 1 && std::abs(q.y) < 0.5 * camera.height - 1;
  };
  for (int face = 0; face < tags.faces; ++face) {
    const Vec3<double> centre = pose.p + pose.R.to_G(tags.centre(face));
    if (!camera.sees(centre, widest)) continue;
    const double cosine = cos_incidence(tags, face, pose);
    const double n = camera.pixels(tags.size, camera.depth(centre));
    if (draws.faces[size(face)] > probability(n, cosine, smear)) continue;
    bool whole = !hidden(exposure, of.observer, body, S.p, S.p + S.R.to_G(centre));
    for (const Vec3<double>& corner : tags.corners(face, Tags::border)) {
      const Vec3<double> p = pose.p + pose.R.to_G(corner);
      whole = whole && in_picture(p) && !hidden(exposure, of.observer, body, S.p, S.p + S.R.to_G(p));
    }
    if (!whole) continue;
    information.add(face, corner_sigma(n, cosine, camera.noise, smear));
    ++seen, face_seen = face, n_seen = n, cos_seen = cosine;
  }
  const std::optional<Mat<6, 6>> covariance = information.covariance();
  if (seen == 0 || !covariance) return false;

  // Reported pose: the true pose with the errors.
  const Column<6> e = Cholesky<6>(*covariance).L * draws.errors;
  RigidPose reported = pose;
  if (seen == 1 && draws.mirror <= mirror_share(n_seen, cos_seen)) {
    // A detector takes the more upright of both solutions, by an attitude known to about 0.01 rad.
    constexpr double as_upright = 0.03;  // [rad]
    const RigidPose image = mirrored(tags, face_seen, pose);
    const Vec3<double> up = S.R.to_B({0, 0, 1});
    const auto tilt = [&](const RigidPose& one) { return atan2(norm(cross(one.R.z, up)), dot(one.R.z, up)); };
    if (tilt(image) <= tilt(pose) + as_upright) reported = image;
  }
  reported.p = reported.p + vec3(e);
  reported.R = compose(turn_by(vec3(e, 3)), reported.R);
  if (draws.outlier <= camera.outliers) {
    if (draws.kind <= 0.5) {
      const double depth = 0.5 + 3 * draws.place[0], f = camera.focal();
      reported.p = {depth, depth * (draws.place[1] - 0.5) * camera.width / f,
                    depth * (draws.place[2] - 0.5) * camera.height / f};
      reported.R = compose(reported.R, turn_by({0, 0, 2 * std::numbers::pi * draws.angle}));
    } else {
      reported.p = (1.1 + 0.4 * draws.place[0]) * reported.p;
    }
  } else if (draws.flip <= camera.flips) {
    reported.R = compose(reported.R, turn_by({0, 0, (draws.side <= 0.5 ? 1 : -1) * (0.35 + draws.angle)}));
  }
  found.observer = of.observer;
  found.target = body;
  found.p = reported.p;
  found.q = quaternion(reported.R);
  found.set_covariance(*covariance);
  found.tags = seen;
  return true;
}

}  // namespace sightline
