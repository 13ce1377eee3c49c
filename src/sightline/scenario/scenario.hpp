/// A scenario: everything that a run needs, from one TOML file.
///
/// The keys have the names of the C++ interface. Every number that the file omits has the default
/// of the struct that it sets.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sightline/base/thread_pool.hpp"
#include "sightline/ocp/active_team.hpp"
#include "sightline/ocp/ocp.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/ocp/tuned_script.hpp"
#include "sightline/run/compensation.hpp"
#include "sightline/run/guard.hpp"
#include "sightline/run/localizer.hpp"
#include "sightline/run/loop.hpp"
#include "sightline/scenario/campaign_plan.hpp"
#include "sightline/scenario/goal_track.hpp"
#include "sightline/scenario/links.hpp"
#include "sightline/scenario/scenario_text.hpp"
#include "sightline/solver/continuation/cgmres.hpp"
#include "sightline/solver/continuation/cmscgmres.hpp"
#include "sightline/solver/distributed/simulated_messages.hpp"
#include "sightline/solver/newton/newton_riccati.hpp"
#include "sightline/world/camera.hpp"
#include "sightline/world/fault.hpp"
#include "sightline/world/plant.hpp"
#include "sightline/world/sensor.hpp"
#include "sightline/world/telemetry_world.hpp"
#include "sightline/world/vehicle.hpp"

namespace sightline {

struct Registry;
const Registry& built_in_registry();

/// Name and options of a solver.
struct SolverChoice {
  std::string name = "newton_riccati";
  std::variant<NewtonRiccatiOptions, ContinuationOptions> options{};
};

/// Settings of the closed loop and of its evaluation.
struct Simulation {
  double duration = 60.0;              ///< [s], > 0
  std::uint64_t seed = 1;              ///< of all random numbers
  double settle = 6.0;                 ///< start of the statistics of distances and views [s], >= 0
  double rms_from = 10.0;              ///< start of the statistics of position errors [s], >= 0
  std::vector<std::string> compare{};  ///< these solvers repeat the run afterwards; the run's own solver is
                                       ///< skipped
  Disturbances disturbances{};
  std::vector<Fault> faults{};  ///< of measurements
  std::vector<LatePlan> late_plans{};
  std::vector<TimedSignal> signals{};  ///< sent from outside to events
};

/// Walls by which a flight is judged: those that the scenario states, and all if a barrier is
/// active; infinite if not judged.
struct Walls {
  double floor = -std::numeric_limits<double>::infinity();   ///< least height [m]
  double ceiling = std::numeric_limits<double>::infinity();  ///< greatest height [m]
  double world = std::numeric_limits<double>::infinity();    ///< greatest |p_x| and |p_y| [m]
};

/// Safety functions beside the solver.
struct Safety {
  BarrierMode barrier = BarrierMode::off;
  double d_hard = 0.6;  ///< minimum distance of a robot to any other body, centre to centre [m], > 0
  BarrierOptions barrier_options{};
  double world = 100.0;  ///< greatest |p_x| and |p_y| [m], > 0
  Walls judged{};
  /// Allows a start beyond a wall or within d_hard: the limit is judged from the first time at
  /// which it is kept.
  bool start_outside = false;
  double position_sigma = 0.0;  ///< standard deviation of a measurement, each axis [m], >= 0
  double heading_sigma = 0.0;   ///< [rad], >= 0
  std::optional<SupervisorOptions> supervisor{};
  SearchOptions search{};  ///< of vision-localized robots
};

/// How the controllers see a velocity; an unknown one counts as zero.
enum class SeenVelocity { measured, unknown };

/// A target or an obstacle, which no solver of the team controls: its motion, and the robots'
/// assumptions about it.
struct UncooperativeBody {
  BodyId body{};
  std::optional<Motion> motion{};  ///< none: constant velocity
  SeenVelocity velocity = SeenVelocity::measured;
  double speed_max = 1.5;          ///< top speed that the robots assume [m/s], >= 0
  std::optional<double> d_hard{};  ///< minimum distance to a robot [m]; none: that of the [safety] section
  std::string
      robot{};  ///< if another part of the team plans it as a robot: the name of its model; else empty
};

/// Robots that one solver plans, by name.
struct PlannedPart {
  std::string name;
  std::vector<std::string> robots;
};

/// Parts of the team that plan separately, each on its own computer, and exchange predictions of
/// their robots.
struct PartitionPlan {
  static constexpr std::string_view all = "all";

  std::vector<PlannedPart> parts{};
  ExchangeOptions exchange{};
  std::string
      part{};  ///< planned on this computer; `all`: one solver plans all; empty: every part, with simulated
               ///< messages

  /// Whether this computer plans one part only.
  bool apart() const { return !part.empty() && part != all; }
};

struct LogOptions {
  double prediction_period = 0.1;  ///< time between two logged predictions [s], > 0
};

/// Limits of the input.
inline constexpr std::size_t agents_max = 1024;   // robots; same limit for targets plus obstacles
inline constexpr double updates_max = 1e9;        // duration / period
inline constexpr std::size_t name_size_max = 64;  // of a body [bytes]; names become topics of the log

struct Scenario {
  std::string name;   ///< of the file, without folder and extension
  std::string text;   ///< as read; with several files or set values, the equivalent single text
  FileTexts files{};  ///< texts of the files that the scenario names, as read
  std::filesystem::path file;
  std::shared_ptr<const Registry> registry{};  ///< the registry used for reading, also for reading again
  Horizon horizon{};
  SolverChoice solver{};
  Team team{};  ///< robots, then targets, then obstacles, each in the order of the file
  std::vector<std::string> coupling_places;  ///< place in the file of each coupling of the team, "file:line"
  std::vector<BodyId> targets;
  std::vector<BodyId> obstacles;
  std::vector<UncooperativeBody> uncooperative;  ///< targets, then obstacles
  std::vector<double> x0;                        ///< states of all bodies at the start (team.nx())
  std::vector<Presence> presence;                ///< of the bodies at the start; missing entries: present
  Script script{};  ///< changes of the team in flight; `team` has every body of the flight
  /// Events added in flight, after those of the script; shared by all threads that use it. Null: no
  /// tuning.
  std::shared_ptr<TunedScript> tuned{};
  std::string world = "model";       ///< kind of the world, one of the registry's worlds
  DownwashOptions downwash{};        ///< of its vehicles
  std::optional<ModelFile> model{};  ///< of the rest of the world, for worlds that read model files
  std::vector<RobotCompensation> compensations{};  ///< of the robots with a compensation
  std::vector<RobotVehicle> vehicles{};            ///< of the robots that are vehicles in this world
  CameraOptions vision{};  ///< cameras, tags and hulls that the file states; camera_options() has all
  LocalizerOptions localization{};  ///< of the vision-localized robots
  Radio radio{};                    ///< broadcast that sends them poses of others, in simulation
  Simulation simulation{};
  std::optional<Safety> safety{};
  LogOptions log{};
  std::shared_ptr<const Links> links{};      ///< to its robots, if they are not simulated; null: none
  std::vector<RobotGoals> goals{};           ///< of the robots that accept goals in flight
  std::optional<PartitionPlan> partition{};  ///< of the whole team; if one part is planned here, `team` is
                                             ///< that part
  std::optional<CampaignPlan> campaign{};
  /// The error in [campaign], which stops no other flight; none if [campaign] is valid or missing.
  std::optional<ScenarioError> campaign_refusal{};
  /// Threads that share the barriers and the simulated world of a large team; no file sets them,
  /// since the result is the same. Null: one thread.
  std::shared_ptr<ThreadPool> pool{};
};

/// Reads a scenario from a file.
/// @param registry  parts that the scenario may name
/// @param set       as in ScenarioChanges
/// @throws ScenarioError
Scenario read_scenario(const std::filesystem::path& file, const Registry& registry = built_in_registry(),
                       const std::vector<std::string>& set = {});

/// Replacements for contents of a scenario's files.
struct ScenarioChanges {
  std::optional<FileTexts> files{};  ///< none: files that the scenario names are read from the disk
  std::vector<std::string> set{};    ///< "KEY=VALUE": keys as in error messages, values as in TOML
};

/// The same from a text that is already read; error messages name `file`.
/// @throws ScenarioError
Scenario parse_scenario(std::string text, const std::filesystem::path& file,
                        const Registry& registry = built_in_registry(), const ScenarioChanges& changes = {});

/// The vehicle of a body; null if it has none.
const RobotVehicle* vehicle_of(const Scenario& scenario, BodyId body);

/// Options of the simulated world of a scenario; below, of the controllers' sensors.
PlantOptions plant_options(const Scenario& scenario);
SensorOptions sensor_options(const Scenario& scenario);

/// Whether this computer plans one part of the team only.
bool plans_apart(const Scenario& scenario);

/// Whether robots join, leave or change couplings in flight; then a TeamSwitcher is necessary.
bool changes_in_flight(const Scenario& scenario);

/// The names of all solvers.
std::vector<std::string_view> solver_names();

/// A solver with its default options.
/// @throws std::invalid_argument for an unknown name; the sentence lists the known ones
SolverChoice solver_named(std::string_view name);

/// Makes the chosen solver for a team and a horizon.
std::unique_ptr<Solver> make_solver(const SolverChoice& choice, const Team& team, const Horizon& horizon);

/// A summary for the user: a few words for each robot, coupling and setting.
std::string summary(const Scenario& scenario);

}  // namespace sightline
