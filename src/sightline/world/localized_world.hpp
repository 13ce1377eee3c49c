/// A world in which robots do not know where they are but by what they see of others.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sightline/estimate/broadcast_track.hpp"
#include "sightline/estimate/localization_graph.hpp"
#include "sightline/estimate/pose_filter.hpp"
#include "sightline/world/motion_sensor.hpp"
#include "sightline/world/world.hpp"

namespace sightline {

/// A robot without a position of its own.
struct LocalizedRobot {
  BodyId robot{};
  SensorMount mount{};            ///< of its camera
  std::vector<BodyId> watches{};  ///< by sightings of whom it is localized
  FilterOptions filter{};
  FilterOptions errors{};  ///< what its autopilot's sensors are like
};

/// How the bodies that know their poses tell them, each period.
struct LocalizationOptions {
  std::uint64_t seed = 1;
  std::vector<LocalizedRobot> robots{};
  BroadcastOptions broadcast{};
  double broadcast_sigma = 0.01;          ///< of a position that is told, each axis [m], > 0
  double broadcast_heading_sigma = 0.01;  ///< [rad], > 0
  double sigma_hold = 0.5;  ///< an estimate is of now while its position's deviation is within this [m], > 0
  Cycles cycles = Cycles::refused;
};

/// Any world that knows the truth and gives detections, seen by robots that are not told where they are: the
/// state that is measured of such a robot is what its filter makes of its motion, of its camera's detections, and
/// of what the bodies in them tell.
///
/// In each measure(): the motion since the last one, with the errors of an autopilot, goes to each filter; what
/// other bodies tell of themselves is remembered; the detections that have arrived are taken, lower tiers first.
/// The velocities among a robot's states are the model's, under the inputs that were applied, drawn towards those
/// of the filter.
///
/// The stamp of a robot is that of its last estimate within sigma_hold, minus infinity before the first: a
/// supervisor, whose levels go by age, brakes and lands a robot that no longer knows where it is well enough, and
/// asks for no plan before it knows.
class LocalizedWorld final : public World {
 public:
  /// @throws std::invalid_argument for options out of range, for a robot whose model has no position or no
  /// heading, for a graph that
  ///         LocalizationGraph refuses, and for a filter of attitudes that watches a robot which is localized itself
  LocalizedWorld(std::unique_ptr<World> world, LocalizationOptions options);

  const Team& team() const noexcept override { return world_->team(); }
  std::span<const double> start() const noexcept override { return world_->start(); }
  std::size_t detections_max() const noexcept override { return world_->detections_max(); }
  void set_presence(std::span<const Presence> presence) noexcept override;
  Measured measure(double t) noexcept override;
  bool apply(double t, std::span<const double> believed, std::span<const double> u, double period,
             std::int64_t periods) noexcept override;
  std::string ended() const override { return world_->ended(); }

  /// Of the robots in the order of the options, at the last measure().
  std::span<const PoseEstimate> estimates() const noexcept { return estimates_; }
  /// The world that is seen.
  World& seen() noexcept { return *world_; }

 private:
  struct Robot {
    LocalizedRobot what;
    std::size_t x = 0, u = 0, nx = 0;
    std::array<int, 2> direction{};
    std::vector<std::size_t> velocities{};      // among its states
    std::vector<Vec3<double>> velocity_axes{};  // of each in G, where the heading is 0
    std::unique_ptr<PoseFilter> filter{};
    MotionSensor motion;
    std::array<MotionSample, PoseFilter::memory> told{};
    std::size_t told_count = 0;
    Vec3<double> p{};  // the truth at the last measure()
    Mat<3, 3> R = identity<3>();
    double good = 0.0;  // stamp of the last estimate within sigma_hold
    std::vector<double> predicted{};
  };

  void move(Robot& robot, double t, const Measured& now) noexcept;
  void hear(double t, const Measured& now) noexcept;
  void look(Robot& robot, const Detection& detection) noexcept;
  void believe(std::size_t robot, double t) noexcept;
  Mat<3, 3> attitude_of(BodyId body, const Measured& now) const noexcept;

  std::unique_ptr<World> world_;
  LocalizationOptions options_;
  LocalizationGraph graph_;
  std::vector<Robot> robots_;
  std::vector<int> robot_of_;           // of each body; -1: it knows its pose
  std::vector<std::size_t> order_;      // of robots, lower tiers first
  std::vector<BroadcastTrack> tracks_;  // of each body
  std::vector<double> told_stamps_;     // of each body's last message
  RandomStream radio_;
  std::vector<Presence> presence_;
  std::vector<double> measured_, stamps_, applied_;
  std::vector<PoseEstimate> estimates_;
  double last_ = 0.0;
  bool began_ = false;
};

}  // namespace sightline
