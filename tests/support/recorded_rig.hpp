/// Recordings of synthetic camera rigs among AprilTags, also as the files of TagSLAM.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "sightline/analysis/localization/rig_filter.hpp"
#include "sightline/world/rigid_motion.hpp"
#include "tests/support/random.hpp"

namespace sightline::test {

struct RecordedRig {
  Distortion lens = Distortion::equidistant;
  int cameras = 2;
  int tags = 6, known = 2;
  bool odometry = true;
  RigNoise noise{.corner_noise = 1.0, .position_walk = 0.02, .rotation_walk = 0.01};
  double seconds = 30.0, rate = 10.0;
  unsigned seed = 1;
};

/// A rig that circles in front of two walls of tags, and what it would record.
class SyntheticRig {
 public:
  explicit SyntheticRig(const RecordedRig& of) : of_(of), random_(of.seed) {
    recording.name = "rig";
    for (int c = 0; c < of.cameras; ++c) {
      Camera camera{.width = 1280, .height = 1024, .focal_length = {600, 610}, .principal_point = {650, 500}};
      camera.distortion = of.lens;
      camera.coefficients = of.lens == Distortion::equidistant
                                ? std::vector<double>{-0.01, 0.01, -0.005, 0.001}
                                : std::vector<double>{-0.1, 0.02, 1e-4, -1e-4};
      const RigidPose mounting = {{0.1 * c, -0.05 * c, 0.02}, turn_by({0.05 * c, -0.3 * c, 0.1})};
      recording.cameras.push_back({fmt::format("cam{}", c), fmt::format("/cam{}/tags", c), camera, mounting});
    }
    for (int k = 0; k < of.tags; ++k) {
      // Of an upright plate before the rig, which looks along y: x right, z of the tag towards it.
      const Rotation upright = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
      const Vec3<double> at = {-2.0 + 4.0 * k / std::max(1, of.tags - 1), 4.0 + 0.5 * (k % 3), 0.4 * (k % 2)};
      const RigidPose place = {at, compose(turn_by({0.1 * (k % 3), 0.0, 0.25 * (k % 2)}), upright)};
      places.push_back(place);
      RigRecording::Tag tag{.id = 10 + k, .size = 0.4, .known = k < of.known};
      if (tag.known) {
        constexpr double s = 0.01, turn = 0.005;
        tag.p_sigma = {s, s, s}, tag.turn_sigma = {turn, turn, turn};
        tag.pose = {place.p + vector(s), compose(place.R, turn_by(vector(turn)))};
      }
      recording.tags.push_back(tag);
    }
    record();
  }

  RigRecording recording{};
  std::vector<RigidPose> places{};  ///< true ones of the tags

 private:
  double normal() { return std::normal_distribution<double>()(random_); }
  Vec3<double> vector(double sigma) { return {sigma * normal(), sigma * normal(), sigma * normal()}; }
  Column<6> twist(double place, double turn) {
    Column<6> w;
    for (int i = 0; i < 6; ++i) w(i, 0) = (i < 3 ? place : turn) * normal();
    return w;
  }

  /// x right, y down, z ahead, along y of G.
  RigidPose pose_at(double t) const {
    const Rotation level = {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}};
    const Vec3<double> p = {1.2 * std::sin(0.4 * t), 0.8 * std::cos(0.3 * t), 0.3 * std::sin(0.5 * t)};
    return {p, compose(turn_by({0.1 * std::sin(0.6 * t), 0.1 * std::cos(0.5 * t), 0.2 * std::sin(0.35 * t)}),
                       level)};
  }

  void record() {
    RigidPose odometry = {{5, 6, 7}, turn_by({0.3, 0.2, 0.1})}, X = pose_at(0.0);
    const double dt = 1 / of_.rate;
    recording.start = 1000.0;
    Column<6> v;
    for (int step = 0; step <= static_cast<int>(of_.seconds * of_.rate); ++step) {
      const double t = recording.start + step * dt;
      if (step > 0 && of_.odometry) {
        const RigidPose next = pose_at(step * dt);
        // The rig truly moves by the odometry and a random walk.
        odometry = odometry * (inverse(X) * next) *
                   exp_of(std::sqrt(dt) * twist(of_.noise.position_walk, of_.noise.rotation_walk));
        X = next;
      } else if (step > 0) {
        // A velocity with the walk that the filter assumes, drawn back towards the path.
        const Column<6> w =
            std::sqrt(dt) * twist(of_.noise.acceleration_walk, of_.noise.turn_acceleration_walk);
        const RigidPose wanted = pose_at(step * dt);
        X = X * exp_of(dt * v + (0.5 * dt) * w);
        v = v + w + dt * (2.0 * log_of(inverse(X) * wanted) - 2.0 * v);
      }
      if (of_.odometry) recording.odometry.push_back({t, odometry});
      recording.reference.push_back({t, X});
      see(t, X);
      recording.end = t;
    }
  }

  void see(double t, const RigidPose& X) {
    for (std::size_t c = 0; c < recording.cameras.size(); ++c)
      for (std::size_t k = 0; k < places.size(); ++k) {
        const RigRecording::RigCamera& camera = recording.cameras[c];
        const auto seen = RigFilter::picture(camera.camera, camera.camera.widest(), recording.tags[k].size,
                                             inverse(X * camera.mounting) * places[k]);
        if (!seen) continue;
        RigRecording::Sighting z{.t = t, .camera = c, .tag = k, .corners = {}};
        bool inside = true;
        for (std::size_t i = 0; i < 4; ++i) {
          const int row = 2 * static_cast<int>(i);
          const Vec2<double> at = {seen->corners(row, 0), seen->corners(row + 1, 0)};
          inside =
              inside && at.x > 0 && at.y > 0 && at.x < camera.camera.width && at.y < camera.camera.height;
          z.corners[i] = {at.x + of_.noise.corner_noise * normal(), at.y + of_.noise.corner_noise * normal()};
        }
        if (inside) recording.sightings.push_back(z);
      }
  }

  RecordedRig of_;
  Random random_;
};

/// Writes the files of TagSLAM that hold a recording.
/// @param prefix  the files are PREFIXtagslam.yaml, ...
inline void write_rig(const RigRecording& recording, const std::string& prefix) {
  const auto vector = [](const char* key, const Vec3<double>& v) {
    return fmt::format("{}: {{x: {:.9f}, y: {:.9f}, z: {:.9f}}}", key, v.x, v.y, v.z);
  };
  const auto pose = [&](const RigidPose& at) {
    return vector("position", at.p) + ", " + vector("rotation", rotation_vector(at.R));
  };
  std::string bodies =
      "default_body: room\nbodies:\n - room:\n     is_static: true\n     default_tag_size: 0.4\n     tags:\n";
  for (const RigRecording::Tag& tag : recording.tags)
    if (tag.known)
      bodies += fmt::format("       - {{id: {}, size: {}, pose: {{{}, {}, {}}}}}\n", tag.id, tag.size,
                            pose(tag.pose), vector("position_noise", tag.p_sigma),
                            vector("rotation_noise", tag.turn_sigma));
  bodies += " - rig:\n     is_static: false\n     odom_topic: /odom\n     T_body_odom: {" + pose({}) + "}\n";
  std::ofstream(prefix + "tagslam.yaml") << bodies;
  std::ofstream cameras(prefix + "cameras.yaml"), mountings(prefix + "camera_poses.yaml");
  for (const RigRecording::RigCamera& one : recording.cameras) {
    cameras << fmt::format(
        "{}:\n  camera_model: pinhole\n  intrinsics: [{}, {}, {}, {}]\n  distortion_model: {}\n"
        "  distortion_coeffs: [{}, {}, {}, {}]\n  resolution: [{}, {}]\n  tagtopic: {}\n  rig_body: rig\n",
        one.name, one.camera.focal_length[0], one.camera.focal_length[1], one.camera.principal_point[0],
        one.camera.principal_point[1],
        one.camera.distortion == Distortion::equidistant ? "equidistant" : "radtan",
        one.camera.coefficients[0], one.camera.coefficients[1], one.camera.coefficients[2],
        one.camera.coefficients[3], one.camera.width, one.camera.height, one.topic);
    mountings << one.name << ":\n  pose: {" << pose(one.mounting) << "}\n";
  }
  const auto row = [](const char* topic, const RigRecording::TimedPose& at) {
    const Quaternion q = quaternion(at.pose.R);
    return fmt::format("odom,{},{:.6f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f}\n", topic, at.t,
                       at.pose.p.x, at.pose.p.y, at.pose.p.z, q.x, q.y, q.z, q.w);
  };
  std::ofstream detections(prefix + "tag_detections.csv"), reference(prefix + "reference.csv");
  for (const RigRecording::Sighting& z : recording.sightings) {
    detections << fmt::format("tag,{},{:.6f},{}", recording.cameras[z.camera].topic, z.t,
                              recording.tags[z.tag].id);
    for (const Vec2<double>& corner : z.corners)
      detections << fmt::format(",{:.4f},{:.4f}", corner.x, corner.y);
    detections << '\n';
  }
  for (const auto& one : recording.odometry) detections << row("/odom", one);
  for (const auto& one : recording.reference) reference << row("/reference", one);
}

}  // namespace sightline::test
