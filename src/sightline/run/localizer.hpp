/// Estimates the poses of robots without a position sensor, between the measurement and the
/// controllers.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "sightline/estimate/broadcast_track.hpp"
#include "sightline/estimate/localization_graph.hpp"
#include "sightline/estimate/pose_filter.hpp"
#include "sightline/safety/search.hpp"
#include "sightline/solver/solver.hpp"
#include "sightline/world/world.hpp"

namespace sightline {

/// A robot without a position sensor.
struct LocalizedRobot {
  BodyId robot{};
  SensorMount mount{};             ///< of its camera
  std::vector<BodyId> observes{};  ///< bodies whose sightings localize it
  FilterOptions filter{};
  double camera_rate = 30.0;  ///< [Hz], > 0
};

struct LocalizerOptions {
  std::vector<LocalizedRobot> robots{};
  BroadcastOptions broadcast{};  ///< `sighting_rate` is the highest rate of the cameras that observe the body
  Cycles cycles = Cycles::refused;

  /// @throws std::invalid_argument naming a number out of its range
  void check() const;
};

/// The outcome of one detection in the filter.
struct DetectionFit {
  BodyId observer{}, target{};
  double stamp = 0.0;  ///< of the exposure [s]
  Fit fit{};
};

/// The states of robots that are localized by vision, each from its own filter. A filter receives the
/// robot's motion, the detections of its camera, and the broadcasts of the detected bodies. The
/// measured state of such a robot is ignored.
///
/// Each estimate() processes motions, then broadcasts, then detections, robots of lower tiers
/// first. A localized robot passes its estimate to the robots that observe it. The velocities among
/// a robot's states are those of the model under the applied inputs, filtered towards those of the
/// pose filter.
///
/// The stamp of a robot is that of its estimate, the end of its last motion. It is minus infinity
/// before the first estimate, and it ages if no motion arrives. Until then the robot is at its
/// start, with the received velocity. The result depends on the inputs alone, bit for bit. After
/// construction nothing allocates, throws, locks or prints.
class Localizer {
 public:
  /// @param start  states of all bodies (nx)
  /// @throws std::invalid_argument for options out of range, for a robot whose model has no
  ///         position or no heading, for a graph that LocalizationGraph refuses, and for a filter
  ///         of attitudes that observes a localized robot
  Localizer(const Team& team, std::span<const double> start, const LocalizerOptions& options);

  /// Sets the presence of each body, as for a World.
  void set_presence(std::span<const Presence> presence) noexcept;
  /// The measurement at t [s] with the states and stamps of localized robots from their filters. t
  /// must rise. Valid until the next call.
  Measured estimate(double t, const Measured& received) noexcept;
  /// Records that the inputs u (nu) are in force for `periods` periods of `period` [s], from the
  /// last estimate() on.
  void apply(std::span<const double> u, double period, std::int64_t periods) noexcept;

  /// Whether every localized robot has had a pose estimate. Until then the loop requests no plan.
  bool knows_all() const noexcept { return knows_all_; }
  /// Of each body, the standard deviation of its estimated position [m]; 0: measured; infinity:
  /// unknown.
  std::span<const double> sigma() const noexcept { return sigma_; }
  /// Of each body, the uncertainty of its view of the body that it observed last; zero if it is not
  /// localized.
  std::span<const ViewUncertainty> uncertainties() const noexcept { return uncertainties_; }
  /// Of each body; `known` is false for a body that is not localized.
  std::span<const PoseEstimate> estimates() const noexcept { return estimates_; }
  /// The views of the localized robots, for a Search; lower tiers first.
  std::span<const View> views() const noexcept { return views_; }
  /// Starts a robot's filter at a pose that is known otherwise: p [m] in G, psi [rad].
  /// @param P  covariance of (p, psi), positive definite
  void start(BodyId robot, const Vec3<double>& p, double psi, const Mat<4, 4>& P) noexcept;
  /// Outcomes of the detections of the last estimate().
  std::span<const DetectionFit> fits() const noexcept { return fits_; }
  const LocalizationGraph& graph() const noexcept { return graph_; }

 private:
  struct Robot {
    LocalizedRobot what;
    std::size_t body = 0, x = 0, u = 0, nx = 0;
    std::vector<std::size_t> velocities{};      // among its states
    std::vector<Vec3<double>> velocity_axes{};  // of each in G, at heading 0
    std::unique_ptr<PoseFilter> filter{};
    std::array<MotionSample, PoseFilter::memory> received{};
    std::size_t counted = 0;
    std::vector<double> predicted{};
  };

  Robot made(const LocalizedRobot& what) const;
  void forget(Robot& robot) noexcept;
  void move(const RobotMotion& motion) noexcept;
  void look(Robot& robot, View& view, const Detection& detection) noexcept;
  void accept_measurement(Robot& robot, View& view, double t) noexcept;

  Team team_;
  LocalizerOptions options_;
  LocalizationGraph graph_;
  std::vector<Robot> robots_;           // lower tiers first
  std::vector<int> robot_of_;           // index into robots_ for each body; -1: its pose is measured
  std::vector<BroadcastTrack> tracks_;  // of each body
  std::vector<Presence> presence_;
  std::vector<double> start_, states_, stamps_, sigma_;
  std::vector<ViewUncertainty> uncertainties_;
  std::vector<PoseEstimate> estimates_;
  std::vector<DetectionFit> fits_;
  std::vector<View> views_;  // of the robots, in the order of robots_
  bool knows_all_ = false;
};

}  // namespace sightline
