/// Filter for the pose of a camera rig among AprilTags, and for the places of the tags.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/readers/rig_recording.hpp"

namespace sightline {

/// Noise of the corners, and of the motion.
struct RigNoise {
  static constexpr std::string_view name = "localize";

  double corner_noise = 1.0;
  double position_walk = 0.04;
  double rotation_walk = 0.02;
  double acceleration_walk = 0.3;
  double turn_acceleration_walk = 0.5;
  double gyro_noise = 0.002;
  double gyro_bias_walk = 1e-4;

  static constexpr auto parameters() {
    using N = RigNoise;
    return Parameters{
        parameter("corner_noise", &N::corner_noise, "px", above_zero, "of each coordinate of a corner"),
        parameter("position_walk", &N::position_walk, "m/sqrt(s)", above_zero,
                  "random walk of the odometry, each axis"),
        parameter("rotation_walk", &N::rotation_walk, "rad/sqrt(s)", above_zero,
                  "random walk of the odometry, each axis"),
        parameter("acceleration_walk", &N::acceleration_walk, "m/s/sqrt(s)", above_zero,
                  "random walk of the velocity without odometry, each axis"),
        parameter("turn_acceleration_walk", &N::turn_acceleration_walk, "rad/s/sqrt(s)", above_zero,
                  "random walk of the angular velocity without odometry, each axis"),
        parameter("gyro_noise", &N::gyro_noise, "rad/sqrt(s)", above_zero,
                  "random walk of the turn by a gyroscope, each axis, in place of that of the odometry"),
        parameter("gyro_bias_walk", &N::gyro_bias_walk, "rad/s/sqrt(s)", above_zero,
                  "random walk of its bias, each axis")};
  }
  /// @throws std::invalid_argument naming a number out of its range
  void check() const { check_parameters(*this); }
};

/// A symmetric matrix that grows, n x n, row by row.
class GrowingCovariance {
 public:
  explicit GrowingCovariance(int n) : n_(n), a_(size(n) * size(n)) {}
  int order() const { return n_; }
  double& operator()(int i, int j) { return a_[size(i) * size(n_) + size(j)]; }
  double operator()(int i, int j) const { return a_[size(i) * size(n_) + size(j)]; }
  /// The first `n` rows and columns, or more of them, which are 0.
  GrowingCovariance resized(int n) const;
  Mat<6, 6> block(int i, int j) const;
  void set(int i, int j, const Mat<6, 6>& b);  ///< and its transpose at (j, i)
  void add_to_pose(const Mat<6, 6>& F);        ///< of xi_X += F xi_v, the first six and the next six numbers

 private:
  int n_;
  std::vector<double> a_;
};

/// What came of a sighting.
enum class TagVerdict { accepted, rejected, introduced, started, waiting };
std::string_view to_string(TagVerdict verdict);
struct TagFit {
  TagVerdict verdict = TagVerdict::waiting;
  double squared = no_value;  ///< y^T S^-1 y, 8 in the mean
  double log_det = no_value;  ///< ln det S
  std::array<double, 8> y{};  ///< innovation of the corners [px]
};

/// The state, and its error as twists on the left, in G:
///
///   X, xi_X   pose of B         X_true = exp(xi_X) X
///   v, xi_v   twist of B, (velocity, angular velocity) in B; without odometry alone. With a gyroscope,
///             its bias is in place of the angular velocity
///   T, xi_T   of each tag       T_true = exp(xi_T) T
///
/// With odometry, X' = X D exp(w): the error stays, plus Ad_X' w. Without it, X' = X exp(v dt), so
/// xi_X grows by Ad_X dt xi_v. A gyroscope turns by exp(theta - b dt) in place of either. A corner c of a
/// tag is pictured at pi((X M)^-1 T c), with the mounting M of the camera and its lens pi. Its error is
/// J Ad_{(X M)^-1} (xi_T - xi_X): a motion of the rig and of all tags together is never observed, at
/// whatever estimate the filter linearises. Updates are iterated.
class RigFilter {
 public:
  /// @param recording  its cameras and tags; must outlive this object
  RigFilter(const RigRecording& recording, const RigNoise& noise);

  /// A propagation, for a smoother: the error d after it, of n numbers, gives that before it,
  ///
  ///   C d = F^-1 (d - U G d),   G = Q U^T P^-1,
  ///
  /// with U = the first rows, of the rig, F its propagation and P the covariance after.
  struct Step {
    RigidPose predicted{};     ///< X after it
    Column<6> velocity{};      ///< v
    Mat<6, 6> per_velocity{};  ///< d xi_X / d xi_v
    std::vector<double> Q{};   ///< (rig x rig)
    std::vector<double> G{};   ///< (rig x n), for a smoother alone
    int n = 0;
  };

  bool started() const { return started_; }
  /// Whether v is there.
  bool has_velocity() const { return rig_ > 6; }
  /// Propagates by the odometry's motion in B over dt [s].
  /// @param turn  theta by the gyroscope [rad], if there is one
  Step move(RigidPose motion, const std::optional<Vec3<double>>& turn, double dt, bool smooth);
  /// Propagates at a constant twist over dt [s].
  Step coast(const std::optional<Vec3<double>>& turn, double dt, bool smooth);
  /// Takes the sightings of one time. @param fits  one for each
  /// @return true if the pose was started anew, so that it does not depend on the past
  bool take(std::span<const RigRecording::Sighting> sightings, std::span<TagFit> fits);

  const RigidPose& pose() const { return X_; }
  const Column<6>& velocity() const { return v_; }
  const GrowingCovariance& covariance() const { return P_; }
  int rig_order() const { return rig_; }
  /// Places of the tags with a state, in the order of their rows in the covariance.
  const std::vector<RigidPose>& places() const { return places_; }
  /// The filter just before it forgot a place, and took another tag or the known pose for it.
  struct Forgotten {
    std::size_t place = 0;
    RigidPose pose{};
    Column<6> velocity{};
    std::vector<RigidPose> places{};
    GrowingCovariance P{0};
  };
  /// In the last take(), in order.
  const std::vector<Forgotten>& forgotten() const { return forgotten_; }

  /// Corners of a tag's picture for a pose of the tag in the optical frame, and their derivatives by a
  /// twist on its left, (8 x 6); none if the camera does not see them.
  struct Picture {
    Column<8> corners;
    Mat<8, 6> by_twist;
  };
  static std::optional<Picture> picture(const Camera& camera, double widest, double size,
                                        const RigidPose& tag);

 private:
  struct Candidate {
    RigidPose pose{};  ///< of the tag in the optical frame, or of a body in G
    double cost = 0.0;
  };
  struct Pending {
    std::vector<Candidate> candidates{};  ///< places in G
    int views = 0;
  };
  int row_of(std::size_t place) const { return rig_ + 6 * static_cast<int>(place); }
  /// Propagates the covariance: xi_X += dt A S xi_v, with the white noise W of v and A w A^T of X, a second.
  Step spread(const Mat<6, 6>& A, const Mat<6, 6>& S, const Mat<6, 6>& W, const Mat<6, 6>& w, double dt,
              bool smooth);
  Step finish(Step step, bool smooth);
  std::vector<Candidate> candidates_of(const RigRecording::Sighting& z) const;
  double cost_of(const RigRecording::Sighting& z, const RigidPose& X, const RigidPose& T) const;
  bool start(std::span<const RigRecording::Sighting> sightings);
  bool introduce(const RigRecording::Sighting& z);
  TagFit update(const RigRecording::Sighting& z, std::size_t place, bool gated);
  void set_known(std::size_t place);
  std::size_t add_place(std::size_t tag, const RigidPose& at);
  void keep_forgotten(std::size_t place);
  /// A known tag is back at its pose; another is as one that is new, and leaves its rows to the next.
  void give_up(std::size_t place);

  const RigRecording& recording_;
  RigNoise noise_;
  int rig_;
  bool started_ = false;
  int refused_ = 0;  // times in sequence at which all sightings were refused
  RigidPose X_{};
  Column<6> v_{};
  GrowingCovariance P_;
  std::vector<RigidPose> places_{};
  std::vector<std::size_t> tag_of_place_{};
  std::vector<int> refused_at_{};    // sightings in sequence, of each place
  std::vector<int> place_of_tag_;    // -1: none
  std::vector<std::size_t> free_{};  // places of tags that were given up
  std::vector<Forgotten> forgotten_{};
  std::vector<Pending> pending_;
  std::vector<double> widest_{};
  std::vector<double> gain_{};  // B of finish()
  bool gain_is_new_ = false;
};

}  // namespace sightline
