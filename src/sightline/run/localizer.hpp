/// Between the measurement and all that goes by it: where robots are that are not told their positions.
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

/// A robot without a position of its own.
struct LocalizedRobot {
  BodyId robot{};
  SensorMount mount{};             ///< of its camera
  std::vector<BodyId> observes{};  ///< by sightings of whom it is localized
  FilterOptions filter{};
  double camera_rate = 30.0;  ///< [Hz], > 0
};

struct LocalizerOptions {
  std::vector<LocalizedRobot> robots{};
  BroadcastOptions broadcast{};  ///< `sighting_rate` is the highest rate of the cameras that watch the body
  Cycles cycles = Cycles::refused;

  /// @throws std::invalid_argument naming a number out of its range
  void check() const;
};

/// What became of one detection.
struct DetectionFit {
  BodyId observer{}, target{};
  double stamp = 0.0;  ///< of the exposure [s]
  Fit fit{};
};

/// The states of robots that are localized by what they see of others: each from a filter of its own, which is told
/// the robot's motion, the detections of its camera, and what the bodies in them broadcast. What is measured of the
/// robot's own state is not looked at.
///
/// In each estimate(): motions first, then broadcasts, then detections, robots of lower tiers first; a robot that is
/// localized tells its estimate to those that watch it. The velocities among a robot's states are the model's, under the
/// inputs that were applied, drawn towards those of the filter.
///
/// The stamp of a robot is that of its estimate, the end of its last motion, so it grows old where nobody tells its
/// motion; minus infinity before the first. Until then it is at its start, with the velocity that it is told. All of
/// it follows from what it is told, bit for bit. Nothing allocates, throws, locks or prints once it is made.
class Localizer {
 public:
  /// @param start  states of all bodies (nx)
  /// @throws std::invalid_argument for options out of range, for a robot whose model has no position or no heading, for a
  ///         graph that LocalizationGraph refuses, and for a filter of attitudes that observes a robot which is localized
  Localizer(const Team& team, std::span<const double> start, const LocalizerOptions& options);

  /// One for each body, as for a World.
  void set_presence(std::span<const Presence> presence) noexcept;
  /// What is known at t [s], which rises: `told`, with states and stamps of localized robots from their filters. Valid
  /// until the next call.
  Measured estimate(double t, const Measured& received) noexcept;
  /// The inputs u (nu) are in force for so many periods of `period` [s], from the last estimate() on.
  void apply(std::span<const double> u, double period, std::int64_t periods) noexcept;

  /// Whether each robot that is localized has been so once; before, nobody is asked for a plan.
  bool knows_all() const noexcept { return knows_all_; }
  /// Of each body, the standard deviation of its estimated position [m]; 0: it is measured; infinity: nothing is known.
  std::span<const double> sigma() const noexcept { return sigma_; }
  /// Of each body, how sure it is of the one that it observes and saw last; of one that is not localized, entirely.
  std::span<const ViewUncertainty> uncertainties() const noexcept { return uncertainties_; }
  /// Of each body; `known` is false of one that is not localized.
  std::span<const PoseEstimate> estimates() const noexcept { return estimates_; }
  /// What each robot that is localized sees, for a Search; lower tiers first.
  std::span<const View> views() const noexcept { return views_; }
  /// Tells a robot where it is, as if it were known otherwise.
  /// @param P  covariance of (p, psi), positive definite
  void start(BodyId robot, const Vec3<double>& p, double psi, const Mat<4, 4>& P) noexcept;
  /// Of the detections that the last estimate() took.
  std::span<const DetectionFit> fits() const noexcept { return fits_; }
  const LocalizationGraph& graph() const noexcept { return graph_; }

 private:
  struct Robot {
    LocalizedRobot what;
    std::size_t body = 0, x = 0, u = 0, nx = 0;
    std::vector<std::size_t> velocities{};      // among its states
    std::vector<Vec3<double>> velocity_axes{};  // of each in G, where the heading is 0
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
  std::vector<int> robot_of_;           // of each body; -1: its pose is measured
  std::vector<BroadcastTrack> tracks_;  // of each body
  std::vector<Presence> presence_;
  std::vector<double> start_, states_, stamps_, sigma_;
  std::vector<ViewUncertainty> uncertainties_;
  std::vector<PoseEstimate> estimates_;
  std::vector<DetectionFit> fits_;
  std::vector<View> views_;  // of the robots, in their order
  bool knows_all_ = false;
};

}  // namespace sightline
