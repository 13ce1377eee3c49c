#include <algorithm>
#include <cmath>

#include "sightline/sensors.hpp"

namespace sightline {
namespace {

/// Rows of a corner's Jacobian over position and rotation: image coordinates right and down.
/// @param arm  from the body's origin to the corner, in S
Mat<2, 6> rows_of(const Camera& camera, const Vec3<double>& p, const Vec3<double>& arm) noexcept {
  const auto [right, down] = camera.slopes(p);
  // d p = d theta x arm, so a row over theta is arm x row.
  const Vec3<double> of_right = cross(arm, right), of_down = cross(arm, down);
  return {{{{right.x, right.y, right.z, of_right.x, of_right.y, of_right.z},
            {down.x, down.y, down.z, of_down.x, of_down.y, of_down.z}}}};
}

struct Misfit {
  double squares = 0.0;
  bool ahead = true;  // the camera sees all corners
};

Misfit misfit(const Camera& camera, const Tags& tags, std::span<const FoundTag> found, const RigidPose& pose,
              double widest) {
  Misfit sum;
  for (const FoundTag& tag : found) {
    const auto corners = tags.corners(tag.face);
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3<double> p = pose.p + pose.R.to_G(corners[i]);
      if (!camera.sees(p, widest)) return {0.0, false};
      const Vec2<double> at = camera.project(p);
      sum.squares += square(tag.corners[i].x - at.x) + square(tag.corners[i].y - at.y);
    }
  }
  return sum;
}

/// Centre of a face and normal of its plate, both in S.
struct Plate {
  Vec3<double> centre, normal;
};
Plate plate_of(const Tags& tags, int face, const RigidPose& pose) {
  return {pose.p + pose.R.to_G(tags.centre(face)), pose.R.to_G(tags.normal(face))};
}

Vec3<double> unit(const Vec3<double>& a) { return (1 / norm(a)) * a; }

/// Homography from the plate of a tag, (-1, -1) to (1, 1), to the picture: x right, y up.
/// @return false if the four corners are not the image of a square
bool homography(const std::array<Vec2<double>, 4>& q, double (&H)[9]) {
  // Unit square to quadrilateral, corners in order (Heckbert 1989).
  const Vec2<double>&a = q[0], &b = q[1], &c = q[2], &d = q[3];
  const double dx1 = b.x - c.x, dx2 = d.x - c.x, dy1 = b.y - c.y, dy2 = d.y - c.y;
  const double sx = a.x - b.x + c.x - d.x, sy = a.y - b.y + c.y - d.y, det = dx1 * dy2 - dx2 * dy1;
  if (!(std::abs(det) > 1e-9)) return false;
  const double g = (sx * dy2 - dx2 * sy) / det, h = (dx1 * sy - sx * dy1) / det;
  const double u[9] = {b.x - a.x + g * b.x,
                       d.x - a.x + h * d.x,
                       a.x,
                       b.y - a.y + g * b.y,
                       d.y - a.y + h * d.y,
                       a.y,
                       g,
                       h,
                       1.0};
  // s = (1 + x) / 2, t = (1 + y) / 2
  for (int r = 0; r < 3; ++r) {
    H[3 * r] = 0.5 * u[3 * r];
    H[3 * r + 1] = 0.5 * u[3 * r + 1];
    H[3 * r + 2] = u[3 * r + 2] + 0.5 * (u[3 * r] + u[3 * r + 1]);
  }
  return true;
}

/// The corners as a pinhole of focal length f pictures them along the x axis of R, given in S.
struct PinholeView {
  Rotation R{};
  double f = 0.0;
  std::array<Vec2<double>, 4> corners{};
};

/// The picture itself, or one around the mean direction of corners that a lens distorts.
std::optional<PinholeView> pinhole_view(const Camera& camera, const std::array<Vec2<double>, 4>& corners) {
  PinholeView view{.f = camera.focal(), .corners = corners};
  if (camera.is_plain()) return view;
  std::array<Vec3<double>, 4> rays;
  Vec3<double> sum{};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::optional<Vec3<double>> ray = camera.ray(corners[i]);
    if (!ray) return std::nullopt;
    rays[i] = *ray;
    sum = sum + *ray;
  }
  if (!(norm(sum) > 0.4)) return std::nullopt;
  view.R.x = unit(sum);
  const Vec3<double> side = std::abs(view.R.x.z) < 0.9 ? Vec3<double>{0, 0, 1} : Vec3<double>{0, 1, 0};
  view.R.y = unit(cross(side, view.R.x));
  view.R.z = cross(view.R.x, view.R.y);
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3<double> ray = view.R.to_B(rays[i]);
    if (!(ray.x > 0.05)) return std::nullopt;
    view.corners[i] = {-view.f * ray.y / ray.x, -view.f * ray.z / ray.x};
  }
  return view;
}

/// The body's pose from the corners of one tag.
std::optional<RigidPose> pose_of_one(const Camera& camera, const Tags& tags, const FoundTag& tag) {
  double H[9];
  const std::optional<PinholeView> view = pinhole_view(camera, tag.corners);
  if (!view || !homography(view->corners, H)) return std::nullopt;
  // In the view, with x = 1 for depth: a column (u, v, w) is along (w, -u / f, -v / f).
  const double f = view->f, half = 0.5 * tags.size;
  const auto column = [&](int k) { return Vec3<double>{H[6 + k], -H[k] / f, -H[3 + k] / f}; };
  const Vec3<double> right = column(0), up = column(1), middle = column(2);
  const double scale = 2 * half / (norm(right) + norm(up));
  if (!(scale * middle.x > Camera::nearest_depth)) return std::nullopt;
  const Vec3<double> x = unit(right), across = cross(x, up);
  if (!(norm(across) > 0)) return std::nullopt;
  // Plate axes in the view: right, up, and out of the plate.
  const Vec3<double> n = unit(across), y = cross(n, x);
  const Rotation R_SP = {x, y, n};
  const Vec3<double> n_B = tags.normal(tag.face);
  const Rotation R_BP = {{-n_B.y, n_B.x, 0}, {0, 0, 1}, n_B};
  // R_SB = R_SP R_PB, with R_PB the transpose.
  const Rotation R_PB = {R_BP.to_B({1, 0, 0}), R_BP.to_B({0, 1, 0}), R_BP.to_B({0, 0, 1})};
  const Rotation R = compose(R_SP, R_PB);
  const Vec3<double> p = scale * middle - R.to_G(tags.centre(tag.face));
  if (camera.is_plain()) return RigidPose{p, R};
  return RigidPose{view->R.to_G(p), compose(view->R, R)};
}

}  // namespace

double corner_sigma(double n, double cos_incidence, double noise, double smear) {
  // Beyond 45 degrees the lines of a tag merge in the picture.
  const double slant = std::max(1.0, 0.7071 / cos_incidence);
  const double of_noise = 0.65 + 0.0875 * noise, of_smear = 1 + std::clamp(smear - 1, 0.0, 1.0);
  return of_noise * of_smear * slant * sqrt(slant) * (0.05 + 30 / square(n));
}

double cos_incidence(const Tags& tags, int face, const RigidPose& pose) {
  const auto [centre, normal] = plate_of(tags, face, pose);
  return -dot(normal, centre) / norm(centre);
}

PoseInformation::PoseInformation(const Camera& camera, const Tags& tags, const RigidPose& pose)
    : camera_(camera), tags_(tags), pose_(pose) {}

void PoseInformation::add(int face, double sigma) noexcept {
  const double weight = 1 / square(sigma);
  for (const Vec3<double>& corner : tags_.corners(face)) {
    const Vec3<double> arm = pose_.R.to_G(corner);
    const Mat<2, 6> rows = rows_of(camera_, pose_.p + arm, arm);
    sum_ += weight * (transposed(rows) * rows);
  }
  const double n = camera_.pixels(tags_.size, camera_.depth(plate_of(tags_, face, pose_).centre));
  bend_ = std::max(bend_, n / (2 * sigma));
}

std::optional<Mat<6, 6>> PoseInformation::covariance() const noexcept {
  Mat<6, 6> A = sum_;
  for (int i = 3; i < 6; ++i) A(i, i) += bend_;
  const Cholesky<6> factor(A);
  if (!factor.positive) return std::nullopt;
  Mat<6, 6> inverse = factor.solve(identity<6>());
  make_symmetric(inverse);
  return inverse;
}

std::optional<TagPose> refined(const Camera& camera, const Tags& tags, std::span<const FoundTag> found,
                               const RigidPose& guess) {
  constexpr int steps = 12, tries = 6;
  const double widest = camera.widest();
  TagPose best{guess, 0.0};
  Misfit last = misfit(camera, tags, found, guess, widest);
  if (!last.ahead || found.empty()) return std::nullopt;
  double lambda = 1e-6;
  for (int step = 0; step < steps; ++step) {
    Mat<6, 6> sum;
    Column<6> b;
    for (const FoundTag& tag : found) {
      const auto corners = tags.corners(tag.face);
      for (std::size_t i = 0; i < 4; ++i) {
        const Vec3<double> arm = best.pose.R.to_G(corners[i]), p = best.pose.p + arm;
        const Mat<2, 6> rows = rows_of(camera, p, arm);
        const Vec2<double> seen = camera.project(p);
        const Column<2> off = {{{{tag.corners[i].x - seen.x}, {tag.corners[i].y - seen.y}}}};
        sum += transposed(rows) * rows;
        b += transposed(rows) * off;
      }
    }
    bool moved = false;
    for (int k = 0; k < tries; ++k) {
      Mat<6, 6> A = sum;
      for (int i = 0; i < 6; ++i) A(i, i) *= 1 + lambda;
      const Cholesky<6> factor(A);
      if (!factor.positive) return std::nullopt;
      const Column<6> d = factor.solve(b);
      const RigidPose next = {best.pose.p + vec3(d), compose(turn_by(vec3(d, 3)), best.pose.R)};
      const Misfit there = misfit(camera, tags, found, next, widest);
      if (there.ahead && there.squares <= last.squares) {
        moved = last.squares - there.squares > 1e-12 * last.squares;
        best.pose = next;
        last = there;
        lambda = std::max(1e-9, 0.2 * lambda);
        break;
      }
      lambda *= 10;
    }
    if (!moved) break;
  }
  best.rms = sqrt(last.squares / (8.0 * static_cast<double>(found.size())));
  return best;
}

RigidPose mirrored(const Tags& tags, int face, const RigidPose& pose) {
  const auto [centre, n] = plate_of(tags, face, pose);
  const Vec3<double> to_camera = unit(-1.0 * centre), axis = cross(n, to_camera);
  // Twice the angle from the normal to the line of sight.
  const double sine = norm(axis);
  if (!(sine > 0)) return pose;
  const double angle = 2 * atan2(sine, dot(n, to_camera));
  const Rotation R = compose(turn_by((angle / sine) * axis), pose.R);
  return {centre - R.to_G(tags.centre(face)), R};
}

std::optional<TagPose> pose_of(const Camera& camera, const Tags& tags, std::span<const FoundTag> found,
                               const Vec3<double>& up) {
  std::array<TagPose, 2 * Tags::faces_max> all;
  std::size_t count = 0;
  const auto consider = [&](const RigidPose& guess) {
    if (const auto pose = refined(camera, tags, found, guess); pose && count < all.size())
      all[count++] = *pose;
  };
  for (const FoundTag& tag : found) {
    const std::optional<RigidPose> one = pose_of_one(camera, tags, tag);
    if (!one) continue;
    const auto alone = refined(camera, tags, std::span(&tag, 1), *one);
    if (!alone) continue;
    consider(alone->pose);
    consider(mirrored(tags, tag.face, alone->pose));
  }
  if (count == 0) return std::nullopt;
  const auto poses = std::span(all).first(count);
  const double least = std::min_element(poses.begin(), poses.end(), [](const auto& a, const auto& b) {
                         return a.rms < b.rms;
                       })->rms;
  const TagPose* chosen = nullptr;
  for (const TagPose& one : poses) {
    if (one.rms > 1.5 * least + 0.1) continue;
    if (chosen == nullptr || dot(one.pose.R.z, up) > dot(chosen->pose.R.z, up)) chosen = &one;
  }
  return *chosen;
}

}  // namespace sightline
