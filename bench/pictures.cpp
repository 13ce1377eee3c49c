/// Compares rendered pictures of tags with detections drawn from the noise model, at the same
/// places. It reports the detection rate, the pose errors and the consistency of the covariance.
/// Prints a Markdown table for docs/localization.md:  bench_pictures [PICTURES OF EACH PLACE]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <memory>
#include <numbers>
#include <vector>

#include "sightline/model.hpp"
#include "worlds/mujoco/camera/rendered_detections.hpp"

namespace {

using namespace sightline;

constexpr double degree = std::numbers::pi / 180;

/// Results of the pictures at one place.
struct Errors {
  int pictures = 0, seen = 0,
      right = 0;  // taken; with a detection; without the ambiguous solution
  double bias = 0.0, range = 0.0, bearing = 0.0, yaw = 0.0, nees = 0.0;  // sums; range to yaw of squares

  /// @param up  the vertical in S
  void add(const Detection& one, const RigidPose& truth, const Vec3<double>& up, double focal) {
    ++seen;
    const Vec3<double> dp = truth.p - one.p;
    const Quaternion q = quaternion(compose(truth.R, between(rotation(one.q), Rotation{})));
    const Vec3<double> turn = 2.0 * Vec3<double>{q.x, q.y, q.z};
    const double length =
        mahalanobis<6>({{{{dp.x}, {dp.y}, {dp.z}, {turn.x}, {turn.y}, {turn.z}}}}, one.covariance_matrix());
    constexpr double mistaken = 60.0;  // far beyond noise for six numbers: the ambiguous solution of a tag
    if (length > mistaken) return;
    ++right;
    nees += length;
    const double r = norm(truth.p), along = dot(dp, (1 / r) * truth.p);
    bias -= along / r;
    range += square(along / r);
    bearing += 0.5 * (dot(dp, dp) - square(along)) * square(focal / r);
    yaw += square(dot(up, turn));
  }
  double mean(double sum) const { return sum / std::max(1, right); }
  double found() const { return static_cast<double>(seen) / pictures; }
  double other_solution() const { return static_cast<double>(seen - right) / std::max(1, seen); }
  double range_sigma() const { return std::sqrt(std::max(0.0, mean(range) - square(mean(bias)))); }
  double bearing_sigma() const { return std::sqrt(mean(bearing)); }
  double yaw_sigma() const { return std::sqrt(mean(yaw)); }
};

struct CameraView {
  int faces;        // of the body
  double above;     // angle at which the camera points down [deg]
  double turned;    // of the nearest face about the vertical, from facing the camera [deg]
  double distance;  // [m]
  Errors rendered{}, drawn{};
};

/// An observer and a body with this many tags, with both detection sources.
class Stage {
 public:
  explicit Stage(int faces) {
    team_.add(Multirotor{}, {.name = "observer"});
    team_.add(Multirotor{}, {.name = "target"});
    options_.cameras = {{.observer = BodyId{0},
                         .mount = {.pitch = 0, .offset = 0, .frame = MountFrame::body},
                         .render = true}};
    options_.tags = {{BodyId{1}, {.faces = faces}}};
    rendered_ = std::make_unique<mujoco::RenderedDetections>(team_, options_);
    drawn_ = std::make_unique<SyntheticDetections>(team_, options_);
  }

  /// Adds one picture of a place: the body anywhere in the picture, both bodies slightly tilted.
  void look(CameraView& place) {
    const auto uniform = [&](double low, double high) { return low + (high - low) * chance_.uniform(); };
    const Rotation eye = compose(turn_by({0, (place.above + 2 * chance_.normal()) * degree, 0}),
                                 turn_by({3 * chance_.normal() * degree, 0, 0}));
    const Rotation aside =
        compose(turn_by({0, 0, uniform(-0.45, 0.45)}), turn_by({0, uniform(-0.3, 0.3), 0}));
    const Vec3<double> p = {0, 0, 3.2}, other = p + place.distance * eye.to_G(aside.x), back = p - other;
    const int faces = options_.tags[0].tags.faces;
    const double side = chance_.uniform() < 0.5 ? 1 : -1, face = std::floor(faces * uniform(0, 0.999));
    const double heading = std::atan2(back.y, back.x) + side * (place.turned + uniform(-2, 2)) * degree;
    const Rotation body = compose(turn_by({0, 0, heading + face * 2 * std::numbers::pi / faces}),
                                  compose(turn_by({0, 2 * chance_.normal() * degree, 0}),
                                          turn_by({2 * chance_.normal() * degree, 0, 0})));
    bodies_[0].now = bodies_[0].before = {p, eye};
    bodies_[1].now = bodies_[1].before = {other, body};
    const RigidPose S = sensor_pose(options_.cameras[0].mount, bodies_[0].now),
                    truth = seen_from(S, bodies_[1].now);
    const auto judge = [&](DetectionSource& source, Errors& errors) {
      ++errors.pictures;
      if (source.find({0, 0.0, 0.0, bodies_}, found_) == 1)
        errors.add(found_[0], truth, S.R.to_B({0, 0, 1}), options_.cameras[0].camera.focal());
    };
    judge(*rendered_, place.rendered);
    judge(*drawn_, place.drawn);
  }

 private:
  Team team_;
  CameraOptions options_;
  std::unique_ptr<DetectionSource> rendered_, drawn_;
  RandomStream chance_{7, StreamId::run, 0};
  std::vector<ExposedBody> bodies_ = std::vector<ExposedBody>(2);
  std::array<Detection, 1> found_;
};

std::vector<CameraView> camera_views() {
  std::vector<CameraView> all;
  const auto add = [&](int faces, double above, std::initializer_list<double> angles) {
    for (const double turned : angles) {
      for (const double d : {1.0, 1.5, 2.0, 2.5, 3.0}) all.push_back({faces, above, turned, d});
    }
  };
  add(1, 0.0, {0, 15, 30, 45, 55, 65, 72});
  add(4, 0.0, {0, 30, 45});
  add(4, 28.0, {0, 30, 45});
  return all;
}

void print(const CameraView& at) {
  const Errors &r = at.rendered, &d = at.drawn;
  fmt::print(
      "| {} | {:.0f}° | {:.0f}° | {} m | {:.0f}, {:.0f} % | {:+.2f}, {:+.2f} % | {:.2f}, {:.2f} % | "
      "{:.2f}, {:.2f} px | {:.2f}, {:.2f}° | {:.1f}, {:.1f} | {:.0f}, {:.0f} % |\n",
      at.faces, at.above, at.turned, at.distance, 100 * r.found(), 100 * d.found(), 100 * r.mean(r.bias),
      100 * d.mean(d.bias), 100 * r.range_sigma(), 100 * d.range_sigma(), r.bearing_sigma(),
      d.bearing_sigma(), r.yaw_sigma() / degree, d.yaw_sigma() / degree, r.mean(r.nees), d.mean(d.nees),
      100 * r.other_solution(), 100 * d.other_solution());
}

}  // namespace

int main(int argc, char** argv) {
  const int pictures = argc > 1 ? std::atoi(argv[1]) : 100;
  std::vector<CameraView> all = camera_views();
  const auto begin = std::chrono::steady_clock::now();
  for (const int faces : {1, 4}) {
    Stage stage(faces);
    for (CameraView& place : all) {
      if (place.faces != faces) continue;
      for (int k = 0; k < pictures; ++k) stage.look(place);
    }
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fmt::print(
      "| plates | from above | turned | distance | found | bias of range | range | bearing | yaw | NEES | "
      "other solution |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const CameraView& place : all) print(place);
  fmt::print(stderr, "{:.1f} ms a picture of 320 x 240\n",
             1e3 * seconds / (pictures * static_cast<double>(all.size())));
  return 0;
}
