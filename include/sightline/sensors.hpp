/// Simulated sensors: cameras with tags, detections, position and motion sensors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/estimator.hpp"
#include "sightline/events.hpp"
#include "sightline/model.hpp"
#include "sightline/team.hpp"
#include "sightline/world.hpp"

namespace sightline {

// Cameras, the tags that they detect, and the hulls that occlude tags: parameters and geometry.

/// Content of a detection of a tagged body.
enum class CameraOutput {
  pose,      ///< position and attitude
  position,  ///< position alone, that is bearing and range
};
inline constexpr std::array<std::string_view, 2> camera_outputs = {"pose", "position"};

/// Distortion of a lens, by the words of ROS 2.
enum class Distortion {
  none,                 ///< a pinhole
  plumb_bob,            ///< k_1, k_2, p_1, p_2 and perhaps k_3; "radtan" of kalibr
  rational_polynomial,  ///< k_1, k_2, p_1, p_2, k_3 to k_6
  equidistant,          ///< k_1 to k_4, of fisheye lenses: the angle from the axis grows along a picture
};
inline constexpr std::array<std::string_view, 4> distortions = {"none", "plumb_bob", "rational_polynomial",
                                                                "equidistant"};

/// Camera with a global shutter. Its optical axis is x of the sensor frame S.
///
/// With (x, y) = (-p_y, -p_z) / p_x of a point p in S, to the right and down, r^2 = x^2 + y^2, and
/// theta the angle of p from the axis, the formulas of OpenCV give the distorted point:
///
///   plumb_bob, rational_polynomial:  g = (1 + k_1 r^2 + k_2 r^4 + k_3 r^6) / (1 + k_4 r^2 + k_5 r^4 + k_6 r^6)
///                  x_d = x g + 2 p_1 x y + p_2 (r^2 + 2 x^2),   y_d = y g + p_1 (r^2 + 2 y^2) + 2 p_2 x y
///   equidistant:   theta_d = theta (1 + k_1 theta^2 + k_2 theta^4 + k_3 theta^6 + k_4 theta^8),
///                  (x_d, y_d) = theta_d (x, y) / r, for theta up to pi
///
/// and its pixel is (f_x x_d + c_x, f_y y_d + c_y), from the upper left corner.
struct Camera {
  static constexpr std::string_view name = "camera";

  int width = 320, height = 240;
  double field_of_view = 1.0472;
  double rate = 30.0;
  std::array<double, 2> latency = {0.03, 0.08};
  double exposure = 0.008;
  double noise = 4.0;
  double blur = 0.7;
  double dropout = 0.0;
  double outliers = 0.0;
  double flips = 0.0;
  double misalignment = 0.0;
  double correlation_time = 0.0;
  CameraOutput output = CameraOutput::pose;
  std::array<double, 2> focal_length = {0.0, 0.0}, principal_point = {0.0, 0.0};
  Distortion distortion = Distortion::none;
  std::vector<double> coefficients{};

  static constexpr Bounds share = {0.0, 1.0, "0 to 1"};
  static constexpr double nearest_depth = 0.02;  ///< nearer points are not projected [m]
  bool operator==(const Camera&) const = default;

  static constexpr auto parameters() {
    using C = Camera;
    return Parameters{
        parameter("width", &C::width, "px", {16, 4096, "16 to 4096"}, "of a picture"),
        parameter("height", &C::height, "px", {16, 4096, "16 to 4096"}, "of a picture"),
        parameter("field_of_view", &C::field_of_view, "rad",
                  {0.1, 6.2832, "0.1 to 2.6, of equidistant to 2 pi"},
                  "angle that the height covers, without coefficients"),
        parameter("rate", &C::rate, "Hz", {0.1, 1000, "0.1 to 1000"},
                  "pictures; each is taken at the first period that it is due at"),
        parameter("latency", &C::latency, "s", {0, 1, "0 to 1"},
                  "from exposure to arrival: drawn evenly between the two"),
        parameter("exposure", &C::exposure, "s", {0, 0.1, "0 to 0.1"},
                  "while it lasts, what moves is smeared"),
        parameter("noise", &C::noise, "", {0, 64, "0 to 64"}, "of a pixel, of 255 grey levels"),
        parameter("blur", &C::blur, "px", {0, 8, "0 to 8"}, "of the lens, in rendered pictures"),
        parameter("dropout", &C::dropout, "", share, "part of the pictures that is lost"),
        parameter("outliers", &C::outliers, "", share, "part of the detections at another place"),
        parameter("flips", &C::flips, "", share,
                  "part of the detections with a heading off by 0.35 to 1.35 rad"),
        parameter("misalignment", &C::misalignment, "rad", {0, 0.5, "0 to 0.5"},
                  "turn against its mounting, about an axis that is drawn once"),
        parameter("correlation_time", &C::correlation_time, "s", {0, 1e4, "0 to 1e4"},
                  "of the errors of drawn detections of a body; 0: white"),
        parameter("output", &C::output, camera_outputs,
                  "of a body with tags: position and attitude, or where it is alone"),
        parameter("focal_length", &C::focal_length, "px", {0, 1e5, "0 to 1e5"},
                  "f_x, f_y, in place of field_of_view; [0, 0]: by it"),
        parameter("principal_point", &C::principal_point, "px", {0, 4096, "0 to 4096"},
                  "c_x, c_y, from the upper left corner; [0, 0]: the middle"),
        parameter("distortion", &C::distortion, distortions, "of the lens"),
        ListParameter<C, double>{"coefficients", &C::coefficients, "",
                                 "of the distortion, in the order of camera_info", false, false}};
  }

  /// @throws std::invalid_argument naming a number out of its range
  void check() const;
  /// Whether it is a pinhole with square pixels and its axis in the middle.
  bool is_plain() const {
    return distortion == Distortion::none && focal_length[0] == 0 && principal_point[0] == 0 &&
           principal_point[1] == 0;
  }
  /// Focal length f along the height [px].
  double focal() const;
  /// Side of a tag of this size [m] in a picture [px], at this depth [m].
  double pixels(double size, double depth) const { return focal() * size / depth; }
  /// Depth of a point of S that pixels() takes [m]: along the axis; of an equidistant lens the distance.
  double depth(const Vec3<double>& p_S) const {
    return distortion == Distortion::equidistant ? norm(p_S) : p_S.x;
  }
  /// Projection of a point of S that sees() accepts into a picture [px]: right and down from the
  /// image centre.
  Vec2<double> project(const Vec3<double>& p_S) const {
    if (!is_plain()) return distorted(p_S);
    const double f = focal();
    return {-f * p_S.y / p_S.x, -f * p_S.z / p_S.x};
  }
  /// Derivatives of project() by the point, to the right and down [px/m].
  std::array<Vec3<double>, 2> slopes(const Vec3<double>& p_S) const;
  /// Angle from the axis up to which directions have pixels of their own, in (0, pi] [rad].
  double widest() const;
  /// Whether project() applies to a point: at least 0.02 m away, and within widest() of the axis.
  bool sees(const Vec3<double>& p_S, double widest) const;
  /// Unit vector of S that project() takes to this place of a picture; none if no direction within
  /// widest() does, to 1e-9 of a focal length.
  std::optional<Vec3<double>> ray(const Vec2<double>& at) const;

 private:
  Vec2<double> distorted(const Vec3<double>& p_S) const;
};

/// AprilTag families.
enum class TagFamily { tag36h11 };
inline constexpr std::array<std::string_view, 1> tag_families = {"tag36h11"};

/// Square tags on upright plates around a body. The first plate faces ahead (x of B); the others
/// follow to the left at equal angles.
struct Tags {
  static constexpr std::string_view name = "tags";

  double size = 0.2;
  int faces = 4;
  double distance = 0.132;
  double height = 0.0;
  TagFamily family = TagFamily::tag36h11;

  static constexpr int faces_max = 8;
  bool operator==(const Tags&) const = default;
  static constexpr double border = 1.25;  ///< side of a tag with its white border, over its size

  static constexpr auto parameters() {
    using T = Tags;
    return Parameters{parameter("size", &T::size, "m", {1e-3, 10, "0.001 to 10"}, "side of the black square"),
                      parameter("faces", &T::faces, "", {1, faces_max, "1 to 8"},
                                "plates, at equal angles, the first ahead"),
                      parameter("distance", &T::distance, "m", {0, 10, "0 to 10"},
                                "of a plate from the body's origin, level"),
                      parameter("height", &T::height, "m", {-10, 10, "-10 to 10"},
                                "of the plates' middle above that origin"),
                      parameter("family", &T::family, tag_families, "of AprilTag")};
  }

  /// @throws std::invalid_argument naming a number out of its range
  void check() const { check_parameters(*this); }
  /// Outward unit normal of a plate, in B.
  Vec3<double> normal(int face) const;
  /// Centre of a tag in B [m].
  Vec3<double> centre(int face) const;
  /// Corners of a tag in B [m], its size multiplied by `scale`. Order, seen from outside: bottom
  /// left, bottom right, top right, top left.
  std::array<Vec3<double>, 4> corners(int face, double scale = 1.0) const;
};

/// Body that occludes others: an upright cylinder about the body's origin, or a sphere at height 0.
struct Hull {
  static constexpr std::string_view name = "hull";

  double radius = 0.2;
  double height = 0.0;

  static constexpr auto parameters() {
    return Parameters{needed(parameter("radius", &Hull::radius, "m", {1e-3, 100, "0.001 to 100"},
                                       "of the cylinder or the sphere")),
                      parameter("height", &Hull::height, "m", {0, 100, "0 to 100"},
                                "of the cylinder, half of it above the body's origin; 0: a sphere")};
  }

  /// Whether the hull, centred at `at`, intersects the line of sight from a to b. False if a or b
  /// is inside the hull.
  bool hides(const Vec3<double>& at, const Vec3<double>& a, const Vec3<double>& b) const;
};

struct RobotCamera {
  BodyId observer{};
  SensorMount mount{};
  Camera camera{};
  bool render = false;   ///< render pictures and search them for tags; else draw detections
  std::string frame{};   ///< optical frame of a real camera in /tf
  std::string sensor{};  ///< SENSOR of [agent.NAME.sensors.SENSOR]; empty: of [agent.NAME.sensor]
};
struct BodyTags {
  BodyId body{};
  Tags tags{};
};
struct BodyHull {
  BodyId body{};
  Hull hull{};
};

/// All cameras, tags and occluding hulls of a team.
struct CameraOptions {
  std::uint64_t seed = 1;
  std::vector<RobotCamera> cameras{};
  std::vector<BodyTags> tags{};
  std::vector<BodyHull> hulls{};
  std::vector<std::vector<std::string>>
      tag_frames{};  ///< frame names in /tf, for each of `tags`, one for each face

  /// The first camera of this robot, or tags of this body; nullptr if it has none.
  const RobotCamera* camera_of(BodyId observer) const noexcept;
  /// The camera of this robot with this mount; null mount: any. nullptr if it has none.
  const RobotCamera* camera_of(BodyId observer, const SensorMount* mount) const noexcept;
  const BodyTags* tags_of(BodyId body) const noexcept;
};

/// Position and attitude: of a body in G, or of a detected body in S.
struct RigidPose {
  Vec3<double> p{};
  Rotation R{};
};

/// Pose in G of the sensor frame S on a body. A mount that a gimbal holds level uses the body's
/// heading alone.
RigidPose sensor_pose(const SensorMount& mount, const RigidPose& body);
/// Pose of b in the frame a; both are given in G.
RigidPose seen_from(const RigidPose& a, const RigidPose& b);

// Measurement of the simulated world: the true state with delay, noise, drift and injected faults.

struct SensorOptions {
  std::uint64_t seed = 1;
  Noise noise{};
  Odometry odometry{};   ///< of robots
  double delay = 0.0;    ///< from state to measurement [s], in [0, 1]; rounded up to whole measurements
  double period = 0.01;  ///< shortest time between two measurements [s]; sizes the buffer of past states
  std::vector<BodyId> velocity_unknown{};  ///< bodies whose measured velocity is 0
  std::vector<Fault> faults{};
};

/// Measures all bodies at once, as motion capture does. `StateRoles` identify the states of the
/// robot's pose and velocity. Noise and jumps are added to positions, noise also to velocities.
/// Heading noise rotates headings, which stay normalised. A robot whose pose is not among its
/// states gets no noise. The odometry errors are added likewise, with their values at the time of
/// the measurement.
///
/// Each measurement has a stamp for each body: the time of the measured state. Without noise, delay
/// and faults the measurement equals the state, bit for bit. Each fault draws from its own random
/// stream.
class Sensor {
 public:
  /// @throws std::invalid_argument naming an option out of its range
  explicit Sensor(const Team& team, const SensorOptions& options = {});

  /// Takes the true states x (nx) at t [s], which must increase, and returns the measured states
  /// (nx). They are valid until the next call. Until the first state is `delay` old, the first
  /// state is measured. Allocates nothing.
  std::span<const double> measure(double t, std::span<const double> x) noexcept;
  /// A body starts again in this state of the world: its earlier measurements are discarded.
  void begin(BodyId body, std::span<const double> x) noexcept;
  /// Sets the faults that events add. Allocates nothing.
  void surround(const Surroundings& around) noexcept;
  /// Stamps of the last measurement of each body [s]; minus infinity before the first one arrives.
  std::span<const double> stamps() const noexcept { return stamps_; }

 private:
  struct Part {
    Model model;
    std::size_t x;
    RandomStream position, heading, velocity;
    // Indices in the stacked state.
    std::vector<std::pair<std::size_t, std::size_t>> positions;  // axis of G, index
    std::optional<std::array<std::size_t, 2>> direction{};
    std::optional<std::size_t> angle{};
    std::vector<std::size_t> velocities;
    std::optional<OdometryErrors> odometry{};  ///< of a robot with odometry errors
  };
  /// A fault of one body.
  struct Injection {
    Fault fault;
    std::size_t part;
    RandomStream chance;
  };
  /// Combined effect of all faults on one measurement.
  struct FaultEffect {
    double delay = 0.0;
    bool lost = false, frozen = false;
  };

  void remember(double t, std::span<const double> x) noexcept;
  std::size_t youngest(double until) const noexcept;
  void add_noise(Part& part) noexcept;
  void turn(const Part& part, double angle) noexcept;
  void add_drift(Part& part, double since) noexcept;
  void apply_faults(std::size_t part, double t, FaultEffect& effect) noexcept;
  /// Applies one fault to the measurement of a body.
  /// @param hit    whether a fault with a probability occurs this time
  /// @param which  for FaultKind::nan, selects the number, in [0, 1]
  void apply_fault(const Fault& fault, const Part& part, bool hit, double which,
                   FaultEffect& effect) noexcept;

  Noise noise_;
  double delay_;
  std::vector<Part> parts_;
  std::vector<std::size_t> unknown_;  // indices in the stacked state of velocities that are not measured
  std::vector<Injection> injections_;
  std::vector<Fault> brought_;                 // faults from events
  std::vector<double> times_, past_;           // ring buffer of states, the oldest at oldest_
  std::vector<double> fresh_, seen_, stamps_;  // measured now; as received; stamps of seen_
  std::size_t oldest_ = 0, count_ = 0;
};

// Simulated motion samples of a robot's autopilot.

/// Motion samples of a robot from its true poses, with the errors of FilterOptions: white noise and
/// biases. The biases are drawn at the start and continue as Gauss-Markov processes or random
/// walks.
class MotionSensor {
 public:
  /// @param errors  of the autopilot's sensors
  /// @throws std::invalid_argument from FilterOptions::check()
  MotionSensor(const FilterOptions& errors, std::uint64_t seed, int body);

  /// Measures the motion of the dt [s] up to t [s], from the previous pose to this one. The
  /// specific force needs the preceding sample to end at the previous pose. For the first sample
  /// the acceleration is taken as 0.
  /// @param R  attitude, B to G
  MotionSample measure(double t, double dt, const Vec3<double>& p_before, const Mat<3, 3>& R_before,
                       const Vec3<double>& p, const Mat<3, 3>& R) noexcept;

  /// The robot restarts elsewhere: the next sample counts as the first.
  void forget() noexcept { moved_ = false; }

 private:
  FilterOptions errors_;
  RandomStream chance_;
  Vec3<double> velocity_bias_, gyro_bias_, force_bias_;
  double yaw_rate_bias_;
  Vec2<double> tilt_error_;
  Vec3<double> v_before_{};
  bool moved_ = false;
  RandomStream magnetic_;
  GaussMarkov<1> compass_error_;
  double next_compass_ = -infinity;  // time of the next compass measurement [s]
};

// Interface that finds tagged bodies in a picture: a noise model, or rendered pictures.

/// Pose in G of a body when a picture is taken, and one period before.
struct ExposedBody {
  RigidPose now{}, before{};
  bool there = true;
};

/// One picture to be taken.
struct Exposure {
  std::size_t camera = 0;               ///< index into CameraOptions::cameras
  double time = 0.0;                    ///< [s]
  double since = 0.0;                   ///< time from `before` to `now` [s]; 0 at the first picture
  std::span<const ExposedBody> bodies;  ///< in team order
};

class DetectionSource {
 public:
  virtual ~DetectionSource() = default;
  /// Finds at most one detection for each body with tags, in the order of the options. The caller
  /// sets stamp and arrival. Never throws.
  /// @return number of entries of `found` that were written
  virtual std::size_t find(const Exposure& exposure, std::span<Detection> found) noexcept = 0;
};

/// True pose of S in G at the middle of an exposure.
/// @param turned  the rotation of the real sensor frame in the nominal S
RigidPose camera_pose(const RobotCamera& camera, const Rotation& turned, const RigidPose& body);

/// Rotation of each camera against its nominal mounting (Camera::misalignment), drawn once.
std::vector<Rotation> drawn_misalignments(const CameraOptions& options);
/// Index of the random streams of a camera: the robot's, of each further camera of it another.
int stream_of(const CameraOptions& options, std::size_t camera);

/// Motion of a body in the picture during the exposure [px]; 0 if the body was not in front of the
/// camera.
Vec2<double> smear_of(const CameraOptions& options, const Exposure& exposure, const Rotation& turned,
                      BodyId body);

// Pose and covariance of a body from the corners of its tags in a picture.

/// A tag found in a picture.
struct FoundTag {
  int face = 0;
  std::array<Vec2<double>, 4>
      corners{};  ///< in the order of Tags::corners(), in the coordinates of Camera::project() [px]
};

/// Standard deviation of a corner's coordinates [px] for a tag with a side of n px. Measured on
/// rendered pictures, docs/localization.md.
/// @param cos_incidence  cosine of the angle between the tag's normal and the line of sight
/// @param noise  of a pixel, of 255 grey levels
/// @param smear  motion of the tag in the picture during the exposure [px]
double corner_sigma(double n, double cos_incidence, double noise, double smear);
/// Cosine of the incidence angle of a face, for a body at this pose in S.
double cos_incidence(const Tags& tags, int face, const RigidPose& pose);

/// Information matrix J^T J of the corner positions over the body's pose in S (position, rotation),
/// weighted by 1 / sigma^2.
///
/// In frontal view, a rotation of a single plate hardly moves its corners at first order. At second
/// order they move by n theta^2 / 4, so the rotation is known to about theta^2 = 2 sigma / n. The
/// matrix includes that information.
class PoseInformation {
 public:
  PoseInformation(const Camera& camera, const Tags& tags, const RigidPose& pose);

  /// Adds one tag whose corners have the standard deviation sigma [px].
  void add(int face, double sigma) noexcept;
  /// Inverse of the information, in the order of Detection::covariance; none if no tag was added.
  std::optional<Mat<6, 6>> covariance() const noexcept;

 private:
  const Camera& camera_;
  const Tags& tags_;
  RigidPose pose_;
  double bend_ = 0.0;
  Mat<6, 6> sum_{};
};

/// A pose estimated from corners.
struct TagPose {
  RigidPose pose{};  ///< of the body in S
  double rms = 0.0;  ///< root mean square of the reprojection errors [px]
};

/// Least-squares pose of all corners, from a first guess, by Levenberg-Marquardt. None if the guess
/// has a corner behind the camera.
std::optional<TagPose> refined(const Camera& camera, const Tags& tags, std::span<const FoundTag> found,
                               const RigidPose& guess);

/// Mirror solution of a tag's pose: its plate is reflected about the line of sight. A small tag in
/// nearly frontal view does not distinguish the two.
RigidPose mirrored(const Tags& tags, int face, const RigidPose& pose);

/// Pose of all tags found, without a guess. Each single tag gives two candidates, which are refined
/// over all tags. Of the candidates that fit nearly as well as the best, the one whose z axis is
/// nearest to `up` is returned. None if the corners match no plate in front of the camera.
/// @param up  in S
std::optional<TagPose> pose_of(const Camera& camera, const Tags& tags, std::span<const FoundTag> found,
                               const Vec3<double>& up);

// Detections drawn from the noise of tags in rendered pictures, without rendering.

/// Draws detections from a probability model. A tag with a side of n px at its depth, at an angle i
/// to its normal, is found with the probability
///
///   0.99 / (1 + exp((n_0 - n cos(i)^(7/8)) / 0.7)),   i < 75 degrees,
///   n_0 = 10.6 px sharp, 20 px if smeared over 2 px or more,
///
/// provided that it is in the picture with its white border and no hull hides its centre or a
/// corner. The curve is the maximum-likelihood logistic fit to 2197 rendered plates.
///
/// The pose over all tags found has the covariance of PoseInformation with corner_sigma(). One tag
/// alone, within 20 degrees of frontal view, may give its mirror image (mirrored()). The share is
/// 35 % of the pictures below 16 px and 20 % up to 22 px, if the body is as upright in the mirror
/// image.
///
/// Camera::outliers displaces the body: half of the outliers anywhere in the view, half to 1.1 to
/// 1.5 times the distance. Camera::flips rotates it by 0.35 to 1.35 rad about its z axis. Both
/// report the covariance of the undisturbed pose.
///
/// The errors of a body's pose are L x, with L L^T its covariance. The six components of x are
/// independent Gauss-Markov processes of variance 1 with Camera::correlation_time.
///
/// Each pair of camera and body has its own random stream, with the same number of draws for each
/// picture.
class SyntheticDetections final : public DetectionSource {
 public:
  explicit SyntheticDetections(const Team& team, const CameraOptions& options);

  std::size_t find(const Exposure& exposure, std::span<Detection> found) noexcept override;

  /// Probability that a tag with a side of n px is found, at an incidence angle with this cosine.
  /// @param smear  motion of the tag in the picture during the exposure [px]
  static double probability(double n, double cosine, double smear);
  /// Largest incidence angle at which a tag is found [rad].
  static constexpr double incidence_max = 1.309;
  /// Side [px] at which about half of all sharp tags in frontal view are found. At an angle it is
  /// half_found / readable().
  static constexpr double half_found = 10.6;
  /// cos(i)^(7/8): factor by which the incidence angle i reduces the apparent size of a tag.
  static double readable(double cosine);
  /// Probability that a single tag gives its mirror image.
  static double mirror_share(double n, double cosine);

 private:
  struct Draws;
  bool detect(const Exposure& exposure, std::size_t tags, Detection& found) noexcept;
  bool hidden(const Exposure& exposure, BodyId observer, BodyId target, const Vec3<double>& eye,
              const Vec3<double>& point) const noexcept;

  CameraOptions options_;
  std::vector<Rotation> turned_;
  std::vector<RandomStream> streams_;   // one for each pair of camera and body with tags
  std::vector<GaussMarkov<6>> errors_;  // likewise
};

}  // namespace sightline
