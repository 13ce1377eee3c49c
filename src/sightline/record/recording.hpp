/// A run as its files tell it: what a report is made from.
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

/// What run.mcap and timing.csv of one folder hold. Columns of one name space have one row a period, `time`.
/// What was not finite is not a number.
struct Recording {
  /// What the filter of a robot that is localized by view knew: estimates, and detections by what became of them.
  struct Localization {
    std::vector<double> time, error, sigma, nees;   ///< [s]; of the position [m]; of position and heading
    std::vector<double> estimated_time, estimated;  ///< of the exposures [s]; y^T S^-1 y
    std::vector<double> refused_time, refused;      ///< likewise
  };
  /// What a camera said of a body with tags (Detection).
  struct Sighted {
    double stamp = 0.0;      ///< of the exposure [s]
    std::size_t target = 0;  ///< in `bodies`
    Vec3<double> p{};        ///< in S [m]
    Quaternion q{};          ///< no_attitude where the position alone is known
  };
  struct Body {
    std::string name;
    std::string robot;  ///< of the model, "body" for what is not controlled
    bool is_agent = false;
    std::vector<Vec3<double>> p;  ///< [m], one a period
    std::vector<double> heading;  ///< psi [rad], unwrapped, one a period
    std::vector<Vec3<double>> v;  ///< in G [m/s], one a period
    std::vector<Vec2<double>>
        lean{};          ///< true one, forward and to the left, one a period; 0 where it is not logged
    bool leans = false;  ///< the true one is logged: a vehicle, or with a camera that is fixed to the body
    std::vector<double> planned_time{};  ///< [s], rising, one for each predicted path
    std::vector<Sight<double>>
        planned{};  ///< pose and lean that were planned for then, PlannedAhead::ahead before
    std::vector<std::string> inputs;     ///< names of the inputs
    std::vector<double> u_min, u_max;    ///< at the start, one for each input
    std::vector<std::vector<double>> u;  ///< applied, [input][period]
    std::vector<double> reference_time;  ///< [s], every 0.1 s; empty: neither place nor heading is asked for
    std::vector<Vec3<double>> reference_p;  ///< empty where the place is free
    std::vector<double> reference_heading;  ///< psi [rad], unwrapped; empty where the heading is free
    std::vector<double> barrier;            ///< 1 where the barrier acted, one a period; empty without one
    std::optional<Camera> camera{};         ///< its size and focal length
    std::optional<Tags> tags{};             ///< of its body
    std::vector<Sighted> sighted{};         ///< by its camera, in the order of arrival
    Localization localization{};            ///< empty of one that is not localized by view
    std::vector<double> reserve;            ///< the barrier's [m], one a period; not a number: nobody near
  };
  /// An observer and its target, by the coupling with a sensor; limits that no coupling states are not a
  /// number.
  struct Pair {
    std::size_t observer = 0, target = 0;  ///< in `bodies`
    SensorMount mount{};
    double alpha = 0.0;  ///< limit of the view angle [rad]
    double d_min = 0.0, d_max = 0.0;
  };
  /// Two bodies with couplings between them that are felt by the same of them; a body that is no robot feels
  /// nothing.
  struct Coupled {
    std::size_t first = 0, second = 0;  ///< in `bodies`
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
    std::vector<std::string> status;  ///< one a period
    std::vector<double> residual;
    std::vector<int> iterations;
    std::vector<double> pairs;  ///< that were kept apart, one a period; empty where there is no keep_apart
  };

  /// Another solver's flight of the same scenario, in a folder of its own within the run's.
  struct Comparison {
    std::string summary;  ///< text of its summary.json
    std::string solver;
    std::vector<double> solve_us;  ///< measured, one a period
  };

  std::string name, scenario, version, compiler, solver;
  std::uint64_t seed = 0;
  double period = 0.0;     ///< [s]
  std::size_t stride = 1;  ///< periods from one row to the next
  double last = 0.0;  ///< where that is more than one: when the last period began, which may have no row [s]
  std::vector<double> time;  ///< [s]
  std::vector<double> cost;  ///< stage cost l, one a period
  std::vector<Body> bodies;
  std::vector<Pair> pairs;
  std::vector<Coupled> couplings;
  std::vector<std::vector<std::size_t>> swarms;  ///< of each the robots, in `bodies`, that feel those near by
  std::vector<double> d_hard;                    ///< the hard distances there are, rising [m]
  double floor = std::numeric_limits<double>::quiet_NaN(),
         ceiling = floor;  ///< of [safety], else not a number [m]
  std::vector<Controller> controllers;
  std::vector<Event> events;
  std::vector<std::string> script;      ///< names of the scenario's [[event]]s
  std::vector<double> solve_us;         ///< measured, all controllers together, one a row of timing.csv
  std::vector<Comparison> comparisons;  ///< in the order of the solvers' names
  bool complete = true;                 ///< false: the log ends in the middle, the run was killed
  std::optional<double>
      lost_after{};  ///< of the last row before periods that are missing, and that the loop did not miss [s]

  double row_time() const { return static_cast<double>(stride) * period; }  ///< from one row to the next [s]
  /// Of the run [s]; 0 where it has no row.
  double end() const { return time.empty() ? 0.0 : (stride > 1 ? last : time.back()) + period; }
};

/// Reads a run's folder; the log of a killed run as far as it is sound. A log whose period lacks what each has, or has it
/// twice, is refused.
/// @param visitor  receives each message of run.mcap once it is read, so that what it keeps is of the same moment of a log that grows
/// @param stride   periods from one row to the next, >= 1
/// @throws std::runtime_error with a sentence that names the file where it cannot be read
Recording read_recording(const std::filesystem::path& folder,
                         const std::function<void(const McapMessage&)>& visitor = {}, std::size_t stride = 1);

/// Reads a run's folder piece by piece, while it is still written.
class RecordingReader {
 public:
  /// Reads what the log says of itself, no row yet.
  /// @throws as read_recording()
  explicit RecordingReader(const std::filesystem::path& folder, std::size_t stride = 1);
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  /// Takes in what has been written since.
  /// @param visitor  is shown each message once it is taken
  /// @throws as read_recording()
  void read_on(const std::function<void(const McapMessage&)>& visitor = {});

  /// As far as it is read. The first rows() of each column are whole, some columns have more; headings are as they were logged, not
  /// unwrapped; there are no comparisons.
  const Recording& run() const;
  std::size_t rows() const;

 private:
  friend Recording read_recording(const std::filesystem::path& folder,
                                  const std::function<void(const McapMessage&)>& visitor, std::size_t stride);
  class Files;
  std::unique_ptr<Files> files_;
};

}  // namespace sightline
