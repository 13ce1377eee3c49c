#include "sightline/analysis/localization/rig_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sightline/base/symmetric.hpp"
#include "sightline/world/rigid_motion.hpp"

namespace sightline {
namespace {

constexpr double gate = 26.12;                     // 99.9 % quantile of chi^2 with 8 degrees of freedom
constexpr double clear_cost = 20.0;                // by which one of two mirrored poses is the better one
constexpr double cost_max = 400.0;                 // of one view
constexpr double wide_place = 5.0, wide_turn = 2;  // sigma of a pose without prior [m], [rad]
constexpr double new_place = 1.0,
                 new_turn = 0.5;        // sigma of a tag about the pose that its corners give [m], [rad]
constexpr double velocity_start = 1.0;  // sigma of v at the start [m/s], [rad/s]
constexpr double bias_start = 0.05;     // sigma of a gyroscope's bias at the start [rad/s]
constexpr double lost_place = 3.0, lost_turn = 1.0;  // sigma beyond linearisation [m], [rad]
constexpr int refusals_max = 8;
constexpr int iterations = 10;

/// The tag of a sighting as a body of one plate at its origin.
Tags plate_of_size(double size) { return {.size = size, .faces = 1, .distance = 0.0}; }

/// S of a camera (ahead, left, up) in its optical frame (right, down, ahead), and the plate's body
/// (out, right, up) in the frame of its tag (right, up, out).
constexpr Rotation optical_of_S = {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}};
constexpr Rotation tag_of_plate = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};

Vec3<double> to_S(const Vec3<double>& optical) { return {optical.z, -optical.x, -optical.y}; }

Mat<6, 6> diagonal(double place, double turn) {
  Mat<6, 6> D;
  for (int i = 0; i < 6; ++i) D(i, i) = square(i < 3 ? place : turn);
  return D;
}

Mat<6, 6> diagonal_signs(double place, double turn) {
  Mat<6, 6> S;
  for (int i = 0; i < 6; ++i) S(i, i) = i < 3 ? place : turn;
  return S;
}

}  // namespace

std::string_view to_string(TagVerdict verdict) {
  constexpr std::array<std::string_view, 5> words = {"accepted", "rejected", "introduced", "started",
                                                     "waiting"};
  return words[static_cast<std::size_t>(verdict)];
}

GrowingCovariance GrowingCovariance::resized(int n) const {
  GrowingCovariance other(n);
  for (int i = 0; i < std::min(n, n_); ++i)
    for (int j = 0; j < std::min(n, n_); ++j) other(i, j) = (*this)(i, j);
  return other;
}

Mat<6, 6> GrowingCovariance::block(int i, int j) const {
  Mat<6, 6> b;
  for (int k = 0; k < 6; ++k)
    for (int l = 0; l < 6; ++l) b(k, l) = (*this)(i + k, j + l);
  return b;
}

void GrowingCovariance::set(int i, int j, const Mat<6, 6>& b) {
  for (int k = 0; k < 6; ++k)
    for (int l = 0; l < 6; ++l) (*this)(i + k, j + l) = (*this)(j + l, i + k) = b(k, l);
}

void GrowingCovariance::add_to_pose(const Mat<6, 6>& F) {
  // On the rows and then on the columns.
  for (int side = 0; side < 2; ++side)
    for (int j = 0; j < n_; ++j)
      for (int i = 0; i < 6; ++i) {
        double sum = 0.0;
        for (int k = 0; k < 6; ++k) sum += F(i, k) * (side == 0 ? (*this)(6 + k, j) : (*this)(j, 6 + k));
        (side == 0 ? (*this)(i, j) : (*this)(j, i)) += sum;
      }
}

RigFilter::RigFilter(const RigRecording& recording, const RigNoise& noise)
    : recording_(recording),
      noise_(noise),
      rig_(recording.odometry.empty() || !recording.turn_rates.empty() ? 12 : 6),
      P_(rig_),
      place_of_tag_(recording.tags.size(), -1),
      pending_(recording.tags.size()) {
  for (const RigRecording::RigCamera& one : recording.cameras) widest_.push_back(one.camera.widest());
  // A tag that is never seen would only make the state larger.
  std::vector<bool> seen(recording.tags.size());
  for (const RigRecording::Sighting& z : recording.sightings) seen[z.tag] = true;
  for (std::size_t tag = 0; tag < recording.tags.size(); ++tag) {
    const RigRecording::Tag& of = recording.tags[tag];
    if (!of.known || !seen[tag]) continue;
    set_known(add_place(tag, of.pose));
  }
}

void RigFilter::set_known(std::size_t place) {
  const RigRecording::Tag& of = recording_.tags[tag_of_place_[place]];
  places_[place] = of.pose;
  // Position errors along G, d p = rho + theta x p; turns about the tag's axes.
  const Mat<3, 3> R = matrix(of.pose.R);
  Mat<6, 6> L, D;
  set_block(L, 0, 0, identity<3>());
  set_block(L, 0, 3, cross_matrix(of.pose.p) * R);
  set_block(L, 3, 3, R);
  const std::array sigma = {of.p_sigma.x,    of.p_sigma.y,    of.p_sigma.z,
                            of.turn_sigma.x, of.turn_sigma.y, of.turn_sigma.z};
  for (int i = 0; i < 6; ++i) D(i, i) = square(sigma[static_cast<std::size_t>(i)]);
  const int row = row_of(place);
  for (int j = 0; j < P_.order(); ++j)
    for (int i = 0; i < 6; ++i) P_(row + i, j) = P_(j, row + i) = 0.0;
  P_.set(row, row, L * D * transposed(L));
}

std::size_t RigFilter::add_place(std::size_t tag, const RigidPose& at) {
  std::size_t place = places_.size();
  if (free_.empty()) {
    places_.push_back(at), tag_of_place_.push_back(tag), refused_at_.push_back(0);
    P_ = P_.resized(row_of(places_.size()));
  } else {
    place = free_.back();
    free_.pop_back();
    keep_forgotten(place);
    places_[place] = at, tag_of_place_[place] = tag, refused_at_[place] = 0;
  }
  place_of_tag_[tag] = static_cast<int>(place);
  return place;
}

void RigFilter::keep_forgotten(std::size_t place) { forgotten_.push_back({place, X_, v_, places_, P_}); }

void RigFilter::give_up(std::size_t place) {
  const std::size_t tag = tag_of_place_[place];
  refused_at_[place] = 0;
  if (recording_.tags[tag].known) {
    keep_forgotten(place);
    set_known(place);
  } else {
    place_of_tag_[tag] = -1;
    free_.push_back(place);
  }
}

RigFilter::Step RigFilter::finish(Step step, bool smooth) {
  const int n = P_.order();
  for (int i = 0; i < rig_; ++i)
    for (int j = 0; j < rig_; ++j) P_(i, j) += step.Q[size(i * rig_ + j)];
  step.predicted = X_, step.velocity = v_, step.n = n;
  if (!smooth) return step;
  // With B = P_rt P_tt^-1 of the rig and the tags and A = P_rr - B P_tr, the first rows of P^-1 are
  // A^-1 [1, -B]. Only an update or a velocity changes B.
  const int tags = n - rig_;
  if (has_velocity() || !gain_is_new_) {
    Symmetric P_tt(size(tags));
    for (int i = 0; i < tags; ++i)
      for (int j = 0; j <= i; ++j) P_tt.at(size(i), size(j)) = P_(rig_ + i, rig_ + j);
    P_tt.factor();
    gain_.clear();
    for (int i = 0; i < rig_; ++i) {
      std::vector<double> row(size(tags));
      for (int j = 0; j < tags; ++j) row[size(j)] = P_(i, rig_ + j);
      row = P_tt.solve(std::move(row));
      gain_.insert(gain_.end(), row.begin(), row.end());
    }
    gain_is_new_ = true;
  }
  Symmetric A(size(rig_));
  for (int i = 0; i < rig_; ++i)
    for (int j = 0; j <= i; ++j) {
      double sum = P_(i, j);
      for (int k = 0; k < tags; ++k) sum -= gain_[size(i * tags + k)] * P_(rig_ + k, j);
      A.at(size(i), size(j)) = sum;
    }
  A.factor();
  for (int i = 0; i < rig_; ++i) {
    std::vector<double> row(size(rig_));
    for (int j = 0; j < rig_; ++j) row[size(j)] = step.Q[size(i * rig_ + j)];
    row = A.solve(std::move(row));
    step.G.insert(step.G.end(), row.begin(), row.end());
    for (int j = 0; j < tags; ++j) {
      double sum = 0.0;
      for (int k = 0; k < rig_; ++k) sum -= row[size(k)] * gain_[size(k * tags + j)];
      step.G.push_back(sum);
    }
  }
  return step;
}

RigFilter::Step RigFilter::move(RigidPose motion, const std::optional<Vec3<double>>& turn, double dt,
                                bool smooth) {
  if (turn) motion.R = turn_by(*turn - dt * vec3(v_, 3));
  X_ = X_ * motion;
  const Mat<6, 6> A = adjoint(X_);
  const auto walk = diagonal(noise_.position_walk, turn ? noise_.gyro_noise : noise_.rotation_walk);
  // Of v the bias alone has an effect; the rest stays as it began.
  if (turn) return spread(A, diagonal_signs(0, -1), diagonal(0, noise_.gyro_bias_walk), walk, dt, smooth);
  Step step;
  const Mat<6, 6> Q = A * (dt * walk) * transposed(A);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) step.Q.push_back(Q(i, j));
  return finish(std::move(step), smooth);
}

RigFilter::Step RigFilter::coast(const std::optional<Vec3<double>>& turn, double dt, bool smooth) {
  const Mat<6, 6> A = adjoint(X_);
  Column<6> twist = dt * v_;
  if (turn) set_block(twist, 3, 0, column(*turn - dt * vec3(v_, 3)));
  X_ = X_ * exp_of(twist);
  return turn ? spread(A, diagonal_signs(1, -1), diagonal(noise_.acceleration_walk, noise_.gyro_bias_walk),
                       diagonal(0, noise_.gyro_noise), dt, smooth)
              : spread(A, diagonal_signs(1, 1),
                       diagonal(noise_.acceleration_walk, noise_.turn_acceleration_walk), {}, dt, smooth);
}

RigFilter::Step RigFilter::spread(const Mat<6, 6>& A, const Mat<6, 6>& S, const Mat<6, 6>& W,
                                  const Mat<6, 6>& w, double dt, bool smooth) {
  const Mat<6, 6> F = A * S;
  Step step{.per_velocity = dt * F};
  P_.add_to_pose(step.per_velocity);
  const Mat<6, 6> Q_XX = (dt * dt * dt / 3) * (F * W * transposed(F)) + A * (dt * w) * transposed(A),
                  Q_Xv = (dt * dt / 2) * (F * W);
  Mat<12, 12> Q;
  set_block(Q, 0, 0, Q_XX);
  set_both(Q, 0, 6, Q_Xv);
  set_block(Q, 6, 6, dt * W);
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j) step.Q.push_back(Q(i, j));
  return finish(std::move(step), smooth);
}

std::optional<RigFilter::Picture> RigFilter::picture(const Camera& camera, double widest, double side,
                                                     const RigidPose& tag) {
  Picture picture;
  constexpr std::array<Vec2<double>, 4> places = {{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}};
  for (int k = 0; k < 4; ++k) {
    const Vec2<double>& place = places[size(k)];
    const Vec3<double> p = tag.p + tag.R.to_G({side * place.x, side * place.y, 0.0}), p_S = to_S(p);
    if (!camera.sees(p_S, widest)) return std::nullopt;
    const Vec2<double> at = camera.project(p_S);
    picture.corners(2 * k, 0) = at.x + 0.5 * camera.width;
    picture.corners(2 * k + 1, 0) = at.y + 0.5 * camera.height;
    const auto slopes = camera.slopes(p_S);
    for (int axis = 0; axis < 2; ++axis) {
      const Vec3<double>& in_S = slopes[size(axis)];
      const Vec3<double> by_p = {-in_S.y, -in_S.z, in_S.x}, by_turn = cross(p, by_p);
      const std::array row = {by_p.x, by_p.y, by_p.z, by_turn.x, by_turn.y, by_turn.z};
      for (int j = 0; j < 6; ++j) picture.by_twist(2 * k + axis, j) = row[size(j)];
    }
  }
  return picture;
}

std::vector<RigFilter::Candidate> RigFilter::candidates_of(const RigRecording::Sighting& z) const {
  const Camera& camera = recording_.cameras[z.camera].camera;
  const Tags plate = plate_of_size(recording_.tags[z.tag].size);
  FoundTag found{.face = 0, .corners = z.corners};
  for (Vec2<double>& corner : found.corners) corner.x -= 0.5 * camera.width, corner.y -= 0.5 * camera.height;
  std::vector<Candidate> all;
  const auto one = pose_of(camera, plate, std::span(&found, 1), {0, 0, 1});
  if (!one) return all;
  const auto add = [&](const TagPose& pose) {
    const RigidPose in_S = {pose.pose.p, compose(pose.pose.R, inverse({{}, tag_of_plate}).R)};
    all.push_back({RigidPose{{}, optical_of_S} * in_S, 8 * square(pose.rms / noise_.corner_noise)});
  };
  add(*one);
  const auto other = refined(camera, plate, std::span(&found, 1), mirrored(plate, 0, one->pose));
  constexpr double same_turn = 0.02;  // [rad]
  if (other && norm(rotation_vector(between(one->pose.R, other->pose.R))) > same_turn) add(*other);
  return all;
}

double RigFilter::cost_of(const RigRecording::Sighting& z, const RigidPose& X, const RigidPose& T) const {
  const RigRecording::RigCamera& camera = recording_.cameras[z.camera];
  const auto seen = picture(camera.camera, widest_[z.camera], recording_.tags[z.tag].size,
                            inverse(X * camera.mounting) * T);
  if (!seen) return cost_max;
  double squares = 0.0;
  for (int k = 0; k < 4; ++k)
    squares += square(z.corners[size(k)].x - seen->corners(2 * k, 0)) +
               square(z.corners[size(k)].y - seen->corners(2 * k + 1, 0));
  return std::min(cost_max, squares / square(noise_.corner_noise));
}

bool RigFilter::start(std::span<const RigRecording::Sighting> sightings) {
  // Each known tag gives two poses; the one that explains all views so far is the pose.
  std::vector<Candidate> poses;
  for (const RigRecording::Sighting& z : sightings) {
    const int place = place_of_tag_[z.tag];
    if (place < 0) continue;
    for (const Candidate& one : candidates_of(z))
      poses.push_back({places_[size(place)] * inverse(recording_.cameras[z.camera].mounting * one.pose)});
  }
  if (poses.empty()) return false;
  for (Candidate& pose : poses) {
    if (started_)
      pose.cost = std::min(cost_max, mahalanobis(log_of(pose.pose * inverse(X_)), P_.block(0, 0)));
    for (const RigRecording::Sighting& z : sightings)
      if (const int place = place_of_tag_[z.tag]; place >= 0)
        pose.cost += cost_of(z, pose.pose, places_[size(place)]);
  }
  X_ = std::min_element(poses.begin(), poses.end(), [](const Candidate& a, const Candidate& b) {
         return a.cost < b.cost;
       })->pose;
  // A gyroscope's bias does not depend on a pose that was lost.
  const bool has_bias = !recording_.turn_rates.empty();
  const int kept = has_bias && started_ ? 9 : rig_;
  for (int i = 0; i < rig_; ++i)
    for (int j = 0; j < P_.order(); ++j)
      if (std::min(i, j) < kept || j >= rig_) P_(i, j) = P_(j, i) = 0.0;
  const Mat<6, 6> A = adjoint(X_);
  P_.set(0, 0, A * diagonal(wide_place, wide_turn) * transposed(A));
  for (int i = 6; i < kept; ++i)
    v_(i - 6, 0) = 0.0, P_(i, i) = square(has_bias && i >= 9 ? bias_start : velocity_start);
  started_ = true, refused_ = 0;
  return true;
}

bool RigFilter::introduce(const RigRecording::Sighting& z) {
  constexpr int views_max = 40;
  constexpr double turn_noise = 0.2;  // of the attitude that one view gives [rad]
  const RigidPose of_camera = X_ * recording_.cameras[z.camera].mounting;
  std::vector<Candidate> now = candidates_of(z);
  if (now.empty()) return false;
  for (Candidate& one : now) one.pose = of_camera * one.pose;
  const auto turned = [](const Candidate& a, const Candidate& b) {
    return norm(rotation_vector(between(a.pose.R, b.pose.R)));
  };
  // The true attitude is the same in all views; the mirrored one turns with the line of sight.
  Pending& pending = pending_[z.tag];
  std::vector<Candidate>& all = pending.candidates;
  if (all.empty()) {
    all = now;
  } else {
    for (Candidate& one : all) {
      double least = cost_max;
      for (const Candidate& other : now)
        least = std::min(least, other.cost + square(turned(one, other) / turn_noise));
      one.cost += least;
    }
  }
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  if (all.size() > 1 && all[1].cost - all[0].cost < clear_cost) {
    // A pair that stays open begins again from a later view.
    if (++pending.views >= views_max) pending = {};
    return false;
  }
  const Candidate& chosen = *std::min_element(now.begin(), now.end(), [&](const auto& a, const auto& b) {
    return turned(all[0], a) < turned(all[0], b);
  });
  // The place follows the rig's error, and is wide until its first update.
  const int row = row_of(add_place(z.tag, chosen.pose));
  for (int j = 0; j < P_.order(); ++j) {
    if (j >= row && j < row + 6) continue;
    for (int i = 0; i < 6; ++i) P_(row + i, j) = P_(j, row + i) = P_(i, j);
  }
  const Mat<6, 6> A = adjoint(chosen.pose);
  P_.set(row, row, P_.block(0, 0) + A * diagonal(new_place, new_turn) * transposed(A));
  pending = {};
  return true;
}

TagFit RigFilter::update(const RigRecording::Sighting& z, std::size_t place, bool gated) {
  const RigRecording::RigCamera& camera = recording_.cameras[z.camera];
  const int row = row_of(place), n = P_.order();
  Mat<12, 12> P;
  set_block(P, 0, 0, P_.block(0, 0));
  set_both(P, 0, 6, P_.block(0, row));
  set_block(P, 6, 6, P_.block(row, row));
  Column<12> xi{};
  TagFit fit{.verdict = TagVerdict::rejected};
  Mat<8, 12> H;
  Mat<8, 8> S;
  Column<8> y;
  for (int k = 0; k < iterations; ++k) {
    const RigidPose X = exp_of(block<6, 1>(xi, 0, 0)) * X_,
                    T = exp_of(block<6, 1>(xi, 6, 0)) * places_[place];
    const RigidPose back = inverse(X * camera.mounting);
    const auto seen = picture(camera.camera, widest_[z.camera], recording_.tags[z.tag].size, back * T);
    if (!seen) return fit;
    const Mat<8, 6> J = seen->by_twist * adjoint(back);
    set_block(H, 0, 0, -1.0 * J);
    set_block(H, 0, 6, J);
    for (int i = 0; i < 4; ++i) {
      y(2 * i, 0) = z.corners[size(i)].x - seen->corners(2 * i, 0);
      y(2 * i + 1, 0) = z.corners[size(i)].y - seen->corners(2 * i + 1, 0);
    }
    y = y + H * xi;
    S = H * P * transposed(H) + identity<8>(square(noise_.corner_noise));
    make_symmetric(S);
    const Cholesky<8> factor(S);
    if (!factor.positive) return fit;
    if (k == 0) {
      const Column<8> white = factor.forward(y);
      fit.squared = 0.0, fit.log_det = 0.0;
      for (int i = 0; i < 8; ++i) {
        fit.squared += square(white(i, 0)), fit.log_det += 2 * log(factor.L(i, i));
        fit.y[size(i)] = y(i, 0);
      }
      if (gated && !(fit.squared <= gate)) return fit;
    }
    const Column<12> next = P * transposed(H) * factor.solve(y), step = next - xi;
    xi = next;
    double length = 0.0;
    for (int i = 0; i < 12; ++i) length += square(step(i, 0));
    if (length < 1e-18) break;
  }
  // W = P H^T L^-T: the state moves by W L^-1 y, and P falls by W W^T.
  const Cholesky<8> factor(S);
  const Column<8> white = factor.forward(y);
  std::vector<Column<8>> W(size(n));
  std::vector<double> moved(size(n));
  for (int i = 0; i < n; ++i) {
    Column<8> G;
    for (int a = 0; a < 8; ++a) {
      double sum = 0.0;
      for (int c = 0; c < 6; ++c) sum += H(a, c) * P_(i, c) + H(a, 6 + c) * P_(i, row + c);
      G(a, 0) = sum;
    }
    W[size(i)] = factor.forward(G);
    for (int a = 0; a < 8; ++a) moved[size(i)] += W[size(i)](a, 0) * white(a, 0);
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) {
      double sum = 0.0;
      for (int a = 0; a < 8; ++a) sum += W[size(i)](a, 0) * W[size(j)](a, 0);
      P_(i, j) = P_(j, i) = P_(i, j) - sum;
    }
  const auto twist = [&](int from) {
    Column<6> d;
    for (int i = 0; i < 6; ++i) d(i, 0) = moved[size(from + i)];
    return d;
  };
  X_ = exp_of(twist(0)) * X_;
  X_.R = rotation_from(orthonormal(matrix(X_.R)));
  if (has_velocity()) v_ = v_ + twist(6);
  for (std::size_t k = 0; k < places_.size(); ++k) {
    places_[k] = exp_of(twist(row_of(k))) * places_[k];
    places_[k].R = rotation_from(orthonormal(matrix(places_[k].R)));
  }
  fit.verdict = TagVerdict::accepted;
  return fit;
}

bool RigFilter::take(std::span<const RigRecording::Sighting> sightings, std::span<TagFit> fits) {
  const Mat<6, 6> A = adjoint(inverse(X_)), P_B = A * P_.block(0, 0) * transposed(A);
  const bool lost = refused_ >= refusals_max || P_B(0, 0) + P_B(1, 1) + P_B(2, 2) > square(lost_place) ||
                    P_B(3, 3) + P_B(4, 4) + P_B(5, 5) > square(lost_turn);
  const bool anew = (!started_ || lost) && start(sightings);
  forgotten_.clear();
  if (!started_) return false;
  std::vector<std::size_t> order(sightings.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (anew) {
    // The first update of a wide pose passes no gate, so it is that of the view which this pose explains best.
    const auto cost = [&](std::size_t k) {
      const int place = place_of_tag_[sightings[k].tag];
      return place < 0 ? infinity : cost_of(sightings[k], X_, places_[size(place)]);
    };
    std::iter_swap(order.begin(),
                   std::min_element(order.begin(), order.end(),
                                    [&](std::size_t a, std::size_t b) { return cost(a) < cost(b); }));
  }
  bool any = false, all_refused = true, accepted_before = false;
  gain_is_new_ = false;
  for (const bool known : {true, false})
    for (const std::size_t k : order) {
      const RigRecording::Sighting& z = sightings[k];
      if ((fits[k].verdict != TagVerdict::waiting) || (known && place_of_tag_[z.tag] < 0)) continue;
      const bool fresh = place_of_tag_[z.tag] < 0;
      if (fresh && !introduce(z)) continue;
      const bool wide = fresh || (anew && all_refused);
      const int place = place_of_tag_[z.tag];
      fits[k] = update(z, size(place), !wide);
      const bool accepted = fits[k].verdict == TagVerdict::accepted;
      int& refused = refused_at_[size(place)];
      refused = accepted ? 0 : refused + 1;
      // It was mirrored, or it was moved.
      if (refused >= refusals_max && accepted_before) give_up(size(place));
      accepted_before = accepted_before || accepted;
      if (accepted && wide) fits[k].verdict = fresh ? TagVerdict::introduced : TagVerdict::started;
      any = true, all_refused = all_refused && !accepted;
    }
  if (any) refused_ = all_refused ? refused_ + 1 : 0;
  return anew;
}

}  // namespace sightline
