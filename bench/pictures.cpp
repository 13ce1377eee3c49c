/// Rendered pictures of tags beside the model of their noise: how often tags are found, how far off the pose is, and what the covariance says.
/// Prints a table of Markdown, as docs/localization.md has it:  bench_pictures [PICTURES OF EACH PLACE]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "sightline/model/robots.hpp"
#include "worlds/mujoco/camera/rendered_detections.hpp"

namespace {

using namespace sightline;

constexpr double degree = std::numbers::pi / 180;

/// What came of the pictures at one place.
struct Told {
  int pictures = 0, found = 0, mirrored = 0;
  double range = 0.0, bearing = 0.0, yaw = 0.0, bias = 0.0;  // sums, the first three of squares
  double told_range = 0.0, told_bearing = 0.0, told_yaw = 0.0, nees = 0.0;

  /// @param up  the vertical in S
  void add(const Detection& seen, const RigidPose& truth, const Vec3<double>& up, double focal) {
    ++pictures;
    const Vec3<double> dp = truth.p - seen.p;
    const Quaternion q = quaternion(compose(truth.R, between(rotation(seen.q), Rotation{})));
    const Vec3<double> turn = 2.0 * Vec3<double>{q.x, q.y, q.z};
    const Mat<6, 6> P = seen.covariance_matrix();
    const double length = mahalanobis<6>({{{{dp.x}, {dp.y}, {dp.z}, {turn.x}, {turn.y}, {turn.z}}}}, P);
    constexpr double mistaken = 60.0;  // far beyond chance for six numbers: the other solution of a tag
    if (length > mistaken) {
      ++mirrored;
      return;
    }
    ++found;
    nees += length;
    const double r = norm(truth.p);
    const Vec3<double> l = (1 / r) * truth.p;
    const Mat<3, 3> of_p = block<3, 3>(P, 0, 0), of_turn = block<3, 3>(P, 3, 3);
    const double along = dot(dp, l), variance = dot(l, of_p * l);
    range += square(along / r);
    bias += -along / r;
    told_range += variance / square(r);
    bearing += 0.5 * (dot(dp, dp) - square(along)) * square(focal / r);
    told_bearing += 0.5 * (trace(of_p) - variance) * square(focal / r);
    yaw += square(dot(up, turn));
    told_yaw += dot(up, of_turn * up);
  }
};

}  // namespace

int main(int argc, char** argv) {
  const int pictures = argc > 1 ? std::atoi(argv[1]) : 40;
  Team team;
  team.add(Multirotor{}, {.name = "observer"});
  team.add(Multirotor{}, {.name = "target"});
  CameraOptions options;
  options.cameras = {
      {.observer = BodyId{0}, .mount = {.pitch = 0, .offset = 0, .frame = MountFrame::body}, .render = true}};
  options.tags = {{BodyId{1}, {}}};
  mujoco::RenderedDetections rendered(team, options);
  SyntheticDetections synthetic(team, options);
  const double focal = options.cameras[0].camera.focal();

  RandomStream chance(7, Chance::run, 0);
  const auto uniform = [&](double low, double high) { return low + (high - low) * chance.uniform(); };
  std::vector<ExposedBody> bodies(2);
  std::array<Detection, 1> found;
  double seconds = 0.0;
  int frames = 0;
  fmt::print(
      "| from above | face turned | distance | found, by the model | range, told | bias of range | bearing, "
      "told | yaw, told | "
      "NEES, drawn | other solution, drawn |\n|---|---|---|---|---|---|---|---|---|---|\n");
  for (const double above : {0.0, 28.0}) {
    for (const double turned : {0.0, 30.0, 45.0}) {
      for (const double d : {0.75, 1.0, 1.5, 2.0, 2.5, 3.0}) {
        Told of_pictures, of_model;
        for (int k = 0; k < pictures; ++k) {
          // The camera looks about down by that angle, the body is somewhere in the picture, one face turned by about the other.
          const Rotation eye = compose(turn_by({0, (above + 2 * chance.normal()) * degree, 0}),
                                       turn_by({3 * chance.normal() * degree, 0, 0}));
          const Rotation aside =
              compose(turn_by({0, 0, uniform(-0.45, 0.45)}), turn_by({0, uniform(-0.3, 0.3), 0}));
          const Vec3<double> p = {0, 0, 3.2}, other = p + d * eye.to_G(aside.x), back = p - other;
          const double side = chance.uniform() < 0.5 ? 1 : -1, quarter = std::floor(4 * uniform(0, 0.999));
          const double heading = std::atan2(back.y, back.x) + side * (turned + uniform(-2, 2)) * degree;
          const Rotation body = compose(turn_by({0, 0, heading + quarter * std::numbers::pi / 2}),
                                        compose(turn_by({0, 2 * chance.normal() * degree, 0}),
                                                turn_by({2 * chance.normal() * degree, 0, 0})));
          bodies[0].now = bodies[0].before = {p, eye};
          bodies[1].now = bodies[1].before = {other, body};
          const RigidPose S = sensor_pose(options.cameras[0].mount, bodies[0].now),
                          truth = seen_from(S, bodies[1].now);
          const Vec3<double> up = S.R.to_B({0, 0, 1});
          const auto begin = std::chrono::steady_clock::now();
          const bool seen = rendered.find({0, 0.0, 0.0, bodies}, found) == 1;
          seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
          ++frames;
          if (seen) of_pictures.add(found[0], truth, up, focal);
          if (synthetic.find({0, 0.0, 0.0, bodies}, found) == 1) of_model.add(found[0], truth, up, focal);
        }
        const Told& o = of_pictures;
        const double n = std::max(1, o.found), m = std::max(1, of_model.found);
        const auto root = [n](double sum) { return std::sqrt(sum / n); };
        fmt::print(
            "| {:.0f}° | {:.0f}° | {} m | {:.0f} %, {:.0f} % | {:.2f} %, {:.2f} % | {:+.2f} % | {:.2f}, "
            "{:.2f} px | {:.2f}°, "
            "{:.2f}° | {:.1f}, {:.1f} | {:.0f} %, {:.0f} % |\n",
            above, turned, d, 100.0 * o.pictures / pictures, 100.0 * of_model.pictures / pictures,
            100 * root(o.range), 100 * root(o.told_range), 100 * o.bias / n, root(o.bearing),
            root(o.told_bearing), root(o.yaw) / degree, root(o.told_yaw) / degree, o.nees / n,
            of_model.nees / m, 100.0 * o.mirrored / std::max(1, o.pictures),
            100.0 * of_model.mirrored / std::max(1, of_model.pictures));
      }
    }
  }
  fmt::print(stderr, "{:.1f} ms a picture of 320 x 240\n", 1e3 * seconds / frames);
}
