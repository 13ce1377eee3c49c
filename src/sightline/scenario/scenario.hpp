/// A scenario: everything a run needs, from one TOML file.
///
/// The words are those of the C++ interface; every number that may be left out has the default of the struct
/// it sets.
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
#include "sightline/scenario/campaign_plan.hpp"
#include "sightline/scenario/link.hpp"
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

/// Which solver, and its options.
struct SolverChoice {
  std::string name = "newton_riccati";
  std::variant<NewtonRiccatiOptions, ContinuationOptions> options{};
};

/// The closed loop and how it is judged.
struct Simulation {
  double duration = 60.0;              ///< [s], > 0
  std::uint64_t seed = 1;              ///< of all chance
  double settle = 6.0;                 ///< distances and views count from here [s], >= 0
  double rms_from = 10.0;              ///< position errors count from here [s], >= 0
  std::vector<std::string> compare{};  ///< these solvers fly the same afterwards, but for the run's own
  Disturbances disturbances{};
  std::vector<Fault> faults{};  ///< of measurements
  std::vector<LatePlan> late_plans{};
  std::vector<TimedSignal> signals{};  ///< from outside, to events
};

/// The walls that a flight is judged by: those that the scenario states, and all where a barrier is to keep them;
/// infinite where it is not judged.
struct Walls {
  double floor = -std::numeric_limits<double>::infinity();   ///< least height [m]
  double ceiling = std::numeric_limits<double>::infinity();  ///< greatest height [m]
  double world = std::numeric_limits<double>::infinity();    ///< greatest |p_x| and |p_y| [m]
};

/// What keeps the robots from harm, besides the solver.
struct Safety {
  BarrierMode barrier = BarrierMode::off;
  double d_hard = 0.6;  ///< of a robot to any other body, centre to centre [m], > 0
  BarrierOptions barrier_options{};
  double world = 100.0;  ///< greatest |p_x| and |p_y| [m], > 0
  Walls judged{};
  /// A start beyond a wall, or within d_hard, is meant: the limit is judged from when it is first kept.
  bool start_outside = false;
  double position_sigma = 0.0;  ///< of a measurement, each axis [m], >= 0
  double heading_sigma = 0.0;   ///< [rad], >= 0
  std::optional<SupervisorOptions> supervisor{};
  SearchOptions search{};  ///< of robots that are localized by view
};

/// What the controllers see of a velocity; one that is unknown they take to be zero.
enum class SeenVelocity { measured, unknown };

/// A target or an obstacle, which nobody here controls: how it moves, and what is known of it.
struct UncooperativeBody {
  BodyId body{};
  std::optional<Motion> motion{};  ///< none: it keeps the velocity it has
  SeenVelocity velocity = SeenVelocity::measured;
  double speed_max = 1.5;          ///< what the robots take to be its top speed [m/s], >= 0
  std::optional<double> d_hard{};  ///< never nearer to a robot [m]; none: as the [safety] section says
  std::string
      robot{};  ///< of a robot that another part of the team plans: its model's name; empty: it is none
};

/// Robots that one solver plans, by name.
struct PlannedPart {
  std::string name;
  std::vector<std::string> robots;
};

/// Parts of the team that plan by themselves, on one computer each, and tell each other where their robots will be.
struct PartitionPlan {
  static constexpr std::string_view all = "all";

  std::vector<PlannedPart> parts{};
  ExchangeOptions exchange{};
  std::string
      part{};  ///< the one that is planned here; `all`: one solver plans all; empty: every part, messages simulated

  /// Whether this computer plans one part alone.
  bool apart() const { return !part.empty() && part != all; }
};

struct LogOptions {
  double prediction_period = 0.1;  ///< time between two logged predictions [s], > 0
};

/// Limits of what is read.
inline constexpr std::size_t agents_max = 1024;   // robots; as many targets and obstacles together
inline constexpr double updates_max = 1e9;        // duration / period
inline constexpr std::size_t name_size_max = 64;  // of a robot; names become topics of the log

struct Scenario {
  std::string name;   ///< of the file, without folder and extension
  std::string text;   ///< as it was read; of several files, or with values set, the equivalent text
  FileTexts files{};  ///< that it names, as they were read
  std::filesystem::path file;
  std::shared_ptr<const Registry> registry{};  ///< by which it was read, and will be read again
  Horizon horizon{};
  SolverChoice solver{};
  Team team{};  ///< robots, then targets, then obstacles, each in the order of the file
  std::vector<std::string> coupling_places;  ///< where each coupling of the team is said, "file:line"
  std::vector<BodyId> targets;
  std::vector<BodyId> obstacles;
  std::vector<UncooperativeBody> uncooperative;  ///< targets, then obstacles
  std::vector<double> x0;                        ///< states of all bodies at the start (team.nx())
  std::vector<Presence> presence;  ///< of the bodies at the start; those that are missing are there
  Script script{};                 ///< what changes the team in flight; `team` has all there will ever be
  /// Of a flight that is tuned while it is flown: what comes behind the script, shared by all who follow it. None: nothing does.
  std::shared_ptr<TunedScript> tuned{};
  std::string world = "model";       ///< what it flies in, one of the parts' worlds
  DownwashOptions downwash{};        ///< of its vehicles
  std::optional<ModelFile> model{};  ///< of what else is in the world, where that reads such files
  std::vector<RobotCompensation> compensations{};  ///< of the robots that ask for one
  std::vector<RobotVehicle> vehicles{};            ///< of the robots that are one, in worlds that have them
  CameraOptions vision{};  ///< cameras, tags and hulls that it says; camera_options() has all that there are
  LocalizerOptions localization{};  ///< of the robots that are localized by view
  Radio radio{};                    ///< by which others tell them their poses, in simulation
  Simulation simulation{};
  std::optional<Safety> safety{};
  LogOptions log{};
  std::optional<FleetPlan> fleet{};          ///< how its robots are reached, where they are not simulated
  std::optional<PartitionPlan> partition{};  ///< of the whole team; where it plans apart, `team` is its part
  std::optional<CampaignPlan> campaign{};
  /// Why its [campaign] cannot be flown, which stops no other flight; none where it can, and where it has none.
  std::optional<ScenarioError> campaign_refusal{};
  /// Threads that share the barriers and the simulated world of a large team, told in no file: the result is the same. None: nobody.
  std::shared_ptr<ThreadPool> pool{};
};

/// @param parts  what it may call by name
/// @param set    as in ScenarioChanges
/// @throws ScenarioError
Scenario read_scenario(const std::filesystem::path& file, const Registry& registry = built_in_registry(),
                       const std::vector<std::string>& set = {});

/// What stands in place of what a scenario's files say.
struct ScenarioChanges {
  std::optional<FileTexts> files{};  ///< none: files that it names are read from the disk
  std::vector<std::string> set{};    ///< "KEY=VALUE", keys as refusals name them, values as in TOML
};

/// The same from a text that is already read; `file` stands in the refusals.
/// @throws ScenarioError
Scenario parse_scenario(std::string text, const std::filesystem::path& file,
                        const Registry& registry = built_in_registry(), const ScenarioChanges& changes = {});

/// The vehicle that a body is; none where it is none.
const RobotVehicle* vehicle_of(const Scenario& scenario, BodyId body);

/// The simulated world of a scenario, and what its controllers see of it.
PlantOptions plant_options(const Scenario& scenario);
SensorOptions sensor_options(const Scenario& scenario);

/// Whether this computer plans one part of its team alone.
bool plans_apart(const Scenario& scenario);

/// Whether robots come, go or are coupled anew in flight: then a TeamSwitcher steers.
bool changes_in_flight(const Scenario& scenario);

/// The names of all solvers.
std::vector<std::string_view> solver_names();

/// A solver with its default options.
/// @throws std::invalid_argument for a name that is none, with the names there are
SolverChoice solver_named(std::string_view name);

/// The chosen solver of a team over a horizon.
std::unique_ptr<Solver> make_solver(const SolverChoice& choice, const Team& team, const Horizon& horizon);

/// What a person reads to see that the scenario is what they meant: a few words per robot, coupling and
/// setting.
std::string summary(const Scenario& scenario);

}  // namespace sightline
