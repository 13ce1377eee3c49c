/// Localizes a recorded team by TeamFilter and evaluates the estimates.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sightline/analysis/localization/team_recording.hpp"

namespace sightline {

/// Which data of a recording the filter receives.
struct TeamRun {
  static constexpr double pose_noise = 0.01;  ///< of a known pose, each axis [m], [rad]
  static constexpr double anchor_rate = 1.0;  ///< [Hz]
  static constexpr int no_robot = -1;

  std::vector<bool> sees_landmarks{}, sees_robots{};  ///< one for each robot; empty: all do
  int anchor = no_robot;                              ///< robot whose pose is known at `anchor_rate`
  bool identities = true;                             ///< false: sightings do not identify the body
  bool start_known = true;  ///< the true poses at the start are known; requires the truth
  TeamNoise noise{};
  std::uint64_t seed = 1;  ///< of the noise of known poses
};

/// Standardised innovations of one quantity, range or bearing: 1 in the mean square and white in
/// time if the filter is consistent.
struct InnovationStatistics {
  struct Lag {
    double lag = 0.0;    ///< mean distance in time of two innovations of one pair [s]
    double value = 0.0;  ///< autocorrelation there [-]
    double bound = 0.0;  ///< of a white sequence, 95 %
  };
  std::size_t count = 0;
  double mean_square = 0.0;
  std::vector<Lag> autocorrelation{};
  /// True if the shortest lag is within its bound.
  bool is_white() const;
  /// -lag / ln(autocorrelation) of the shortest lag [s]; 0 if the innovations are white.
  double correlation_time() const;
};

struct TeamLocalization {
  struct Robot {
    std::size_t samples = 0;  ///< of the comparison with the truth, 10 a second
    double rmse = no_value;   ///< of the position [m]
    double max_error = no_value;
    double heading_rmse = no_value;  ///< [rad]
    double sigma = no_value;         ///< root mean square of the reported standard deviation [m]
    double anees = no_value;         ///< of x, y, psi; 3 is consistent
    double independent = 0.0;        ///< samples without their correlation in time
    std::array<double, 2> bounds{no_value, no_value};  ///< of a consistent filter's ANEES, 95 %
    std::size_t accepted = 0, rejected = 0, left_out = 0, located = 0;  ///< sightings; starts by locate()
    InnovationStatistics range{}, bearing{};
    std::array<double, robot_states> states{}, sigmas{};  ///< at the end, after RobotState
  };
  std::vector<Robot> robots{};
  double rmse = no_value, heading_rmse = no_value, anees = no_value;  ///< over all robots
  double rmse_without_anchor = no_value;
  /// Mean absolute errors of the poses of all robots relative to each other [m], [rad].
  double relative_position = no_value, relative_heading = no_value;
  double seconds = 0.0;  ///< of the recording
  /// Twice the negative logarithm of the likelihood of all sightings; those beyond the gate, and
  /// those that a slip explains, count as outliers.
  double cost = 0.0;
};

/// Receives the estimates as they occur.
class TeamEstimates {
 public:
  virtual ~TeamEstimates() = default;
  /// @param truth  in the frame of the estimates; empty if it is not known
  virtual void estimate(double t, int robot, const PoseGuess& pose,
                        const std::optional<PlanarPose>& truth) = 0;
  virtual void fit(const TeamSighting& z, const TeamFit& fit) = 0;
};

/// Runs the filter through a recording; at each time it uses nothing later. Deterministic.
/// @throws std::invalid_argument if the recording cannot serve the run
TeamLocalization localize_team(const TeamRecording& recording, const TeamRun& run,
                               TeamEstimates* to = nullptr);

}  // namespace sightline
