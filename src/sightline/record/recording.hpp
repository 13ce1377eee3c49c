/// A run as read from its files: the input of a report.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/model/frames.hpp"
#include "sightline/world/camera.hpp"

namespace sightline {

struct McapMessage;

/// Contents of run.mcap and timing.csv of one folder. Each column has one row per period, at
/// `time`, unless it has its own time column. A number that was not finite is NaN.
struct Recording {
  /// Output of the filter of a vision-localized robot: estimates, and detections by their verdict.
  struct Localization {
    std::vector<double> time, error, sigma, nees;   ///< [s]; of position [m]; of both (nees)
    std::vector<double> estimated_time, estimated;  ///< time of the exposures [s]; y^T S^-1 y
    std::vector<double> refused_time, refused;      ///< likewise, of rejected detections
  };
  /// A camera's detection of a body with tags (Detection).
  struct Sighted {
    double stamp = 0.0;      ///< of the exposure [s]
    std::size_t target = 0;  ///< index in `bodies`
    Vec3<double> p{};        ///< in S [m]
    Quaternion q{};          ///< no_attitude if only the position is known
  };
  struct Body {
    std::string name;
    std::string robot;  ///< name of the model; "body" for a body without control
    bool is_agent = false;
    std::vector<Vec3<double>> p;         ///< [m], one per period
    std::vector<double> heading;         ///< psi [rad], unwrapped, one per period
    std::vector<Vec3<double>> v;         ///< in G [m/s], one per period
    std::vector<Vec2<double>> lean{};    ///< true tilt, forward and left [-], one per period; 0 if not logged
    bool leans = false;                  ///< true tilt is logged: a vehicle, or a body-fixed camera
    std::vector<double> planned_time{};  ///< [s], increasing, one for each predicted path
    std::vector<Sight<double>>
        planned{};                     ///< pose and tilt planned for planned_time, PlannedAhead::ahead before
    std::vector<std::string> inputs;   ///< names of the inputs
    std::vector<double> u_min, u_max;  ///< at the start, one for each input
    std::vector<std::vector<double>> u;     ///< applied, [input][period]
    std::vector<double> reference_time;     ///< [s], every 0.1 s; empty: position and heading are free
    std::vector<Vec3<double>> reference_p;  ///< empty if the position is free
    std::vector<double> reference_heading;  ///< psi [rad], unwrapped; empty if the heading is free
    std::vector<double> barrier;            ///< 1 if the barrier acts, one per period; else empty
    std::optional<Camera> camera{};         ///< size and focal length
    std::optional<Tags> tags{};             ///< on the body
    std::vector<Sighted> sighted{};         ///< by its camera, in the order of arrival
    Localization localization{};            ///< empty if the robot is not vision-localized
    std::vector<double> reserve;            ///< the barrier's [m], one per period; NaN: no body near
  };
  /// An observer and its target, from the coupling with a sensor; a limit that no coupling sets is
  /// NaN.
  struct Pair {
    std::size_t observer = 0, target = 0;  ///< indices in `bodies`
    SensorMount mount{};
    double alpha = 0.0;  ///< limit of the view angle [rad]
    double d_min = 0.0, d_max = 0.0;
  };
  /// Two bodies with couplings that affect the same robots of the pair; a body that is not a robot
  /// is never affected.
  struct Coupled {
    std::size_t first = 0, second = 0;  ///< indices in `bodies`
    bool first_feels = false, second_feels = false;
  };
  struct Event {
    double time = 0.0;
    std::string kind;
    int controller = 0;
    double value = 0.0;
  };
  struct Controller {
    std::string name;
    std::vector<std::string> status;  ///< one per period
    std::vector<double> residual;
    std::vector<int> iterations;
    std::vector<double> pairs;  ///< of robots kept apart, one per period; empty without keep_apart
  };

  /// Flight of the same scenario with another solver, in a subfolder of the run.
  struct Comparison {
    std::string summary;  ///< text of its summary.json
    std::string solver;
    std::vector<double> solve_us;  ///< measured [us], one per period
  };

  std::string name, scenario, version, compiler, solver;
  std::uint64_t seed = 0;
  double period = 0.0;       ///< [s]
  std::size_t stride = 1;    ///< periods from one row to the next
  double last = 0.0;         ///< if stride > 1: start of the last period, which may have no row [s]
  std::vector<double> time;  ///< [s]
  std::vector<double> cost;  ///< stage cost l [-], one per period
  std::vector<Body> bodies;
  std::vector<Pair> pairs;
  std::vector<Coupled> couplings;
  std::vector<std::vector<std::size_t>> swarms;  ///< of each, indices in `bodies` of its robots
  std::vector<double> d_hard;                    ///< all distinct hard distances, increasing [m]
  double floor = std::numeric_limits<double>::quiet_NaN(),
         ceiling = floor;  ///< of [safety], else NaN [m]
  std::vector<Controller> controllers;
  std::vector<Event> events;
  std::vector<std::string> script;      ///< names of the scenario's [[event]]s
  std::vector<double> solve_us;         ///< measured [us], sum of all controllers, one per row of timing.csv
  std::vector<Comparison> comparisons;  ///< sorted by solver name
  bool complete = true;                 ///< false: the log is truncated because the run was killed
  std::optional<double> lost_after{};   ///< last row before lost periods that the loop did not miss [s]

  double row_time() const { return static_cast<double>(stride) * period; }  ///< from one row to the next [s]
  /// Duration of the run [s]; 0 without rows.
  double end() const { return time.empty() ? 0.0 : (stride > 1 ? last : time.back()) + period; }
};

/// Reads a run's folder; for a killed run, the intact part of the log. Rejects a log with a missing
/// or duplicate message that each period must have once.
/// @param visitor  receives each message of run.mcap after it is read; so its data matches the
///   recording, also for a growing log
/// @param stride   periods from one row to the next, >= 1
/// @throws std::runtime_error with a sentence that names the file, if it cannot be read
Recording read_recording(const std::filesystem::path& folder,
                         const std::function<void(const McapMessage&)>& visitor = {}, std::size_t stride = 1);

/// Reads a run's folder incrementally while the run is still being written.
class RecordingReader {
 public:
  /// Reads the metadata of the log, no rows yet.
  /// @throws as read_recording()
  explicit RecordingReader(const std::filesystem::path& folder, std::size_t stride = 1);
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  /// Reads what was written since the last call.
  /// @param visitor  receives each message after it is read
  /// @throws as read_recording()
  void read_on(const std::function<void(const McapMessage&)>& visitor = {});

  /// The recording so far. The first rows() rows of each column are complete; some columns are
  /// longer. Headings are as logged, not unwrapped; there are no comparisons.
  const Recording& run() const;
  std::size_t rows() const;

 private:
  friend Recording read_recording(const std::filesystem::path& folder,
                                  const std::function<void(const McapMessage&)>& visitor, std::size_t stride);
  class Files;
  std::unique_ptr<Files> files_;
};

}  // namespace sightline
