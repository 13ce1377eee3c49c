/// Scenarios: everything that a run needs, read from one TOML file; and the closed loop that a scenario describes.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/events.hpp"
#include "sightline/loop.hpp"
#include "sightline/potential.hpp"
#include "sightline/sensors.hpp"
#include "sightline/solvers.hpp"
#include "sightline/team.hpp"
#include "sightline/vehicle.hpp"
#include "sightline/world.hpp"
#include "sightline/worlds.hpp"

namespace sightline {

// [campaign] of a scenario: the numbers that a campaign draws for each run, and the criteria of a
// successful run.

/// Distribution of a number. With probability `fraction` it is `constant`, otherwise
///
///   uniform  between values[0] and values[1]
///   normal   of mean values[0] and standard deviation values[1]
///   choice   values[i] with probability fractions[i]
struct Distribution {
  enum class Kind { uniform, normal, choice };
  Kind kind = Kind::uniform;
  std::vector<double> values = {0.0, 0.0};
  std::vector<double> fractions{};  ///< of a choice; their sum is 1
  double constant = 0.0, fraction = 0.0;
};

/// Distribution of a robot's start, relative to another body.
struct StartDraw {
  std::string agent, around;
  Distribution range;                      ///< horizontal distance to `around` [m]
  Distribution bearing;                    ///< direction of `around` from the robot's nose, to the left [rad]
  Distribution height;                     ///< of the robot above `around` [m]
  std::optional<Distribution> heading{};   ///< of the robot [rad]; none: as in the scenario
  std::optional<Distribution> velocity{};  ///< forward and sideward, each drawn [m/s]; none: as in the
                                           ///< scenario
};

/// A number of the scenario by its key, "couple[0].weight".
struct NumberDraw {
  /// Another number that depends on the drawn one: times * drawn + plus.
  struct Linked {
    std::string key;
    double times = 1.0, plus = 0.0;
  };
  std::string key;
  Distribution distribution;
  std::vector<Linked> also{};
};

/// Values of Table 1, one for each run.
struct EvasionColumns {
  std::vector<double> min_obstacle{};  ///< least distance to the obstacle [m]
  std::vector<double> min_target{};    ///< least and
  std::vector<double> max_target{};    ///< greatest distance to the target [m]
  std::vector<double> max_angle{};     ///< greatest view angle while the obstacle is present [rad]
};

/// A robot that evades an obstacle while it observes a target, and the published values.
struct EvasionPlan {
  std::string agent, target, obstacle;
  double from = 0.0, d_obstacle = 1.0, d_min = 0.7, d_max = 2.0, alpha = 0.5;
  EvasionColumns published{};  ///< empty: none

  static constexpr auto parameters() {
    using P = EvasionPlan;
    return Parameters{
        parameter("from", &P::from, "s", from_zero, "the obstacle is present from then on"),
        parameter("d_obstacle", &P::d_obstacle, "m", above_zero, "limit of the distance to the obstacle"),
        parameter("d_min", &P::d_min, "m", above_zero, "least distance to the target"),
        parameter("d_max", &P::d_max, "m", above_zero, "greatest distance to the target"),
        parameter("alpha", &P::alpha, "rad", above_zero, "limit of the view angle")};
  }
};

struct CampaignPlan {
  std::string text{};  ///< of the scenario that has this plan
  double duration = 25.0, view_within = 20.0, d_hard = 0.0, braking = 0.6;
  bool start_outside = false;
  std::vector<StartDraw> starts{};
  std::vector<NumberDraw> draws{};
  std::optional<EvasionPlan> evasion{};  ///< reported for the first runs

  static constexpr auto parameters() {
    using P = CampaignPlan;
    return Parameters{
        KeyText{"start_outside", "true or false", "allows drawn starts beyond a wall", "false"},
        parameter("duration", &P::duration, "s", above_zero, "of each run"),
        parameter("view_within", &P::view_within, "s", from_zero,
                  "time by which every observer must have seen its target, which it must see at the end"),
        parameter("d_hard", &P::d_hard, "m", from_zero,
                  "least distance, if [safety] has none; 0: not judged"),
        parameter("braking", &P::braking, "m/s^2", above_zero,
                  "a run must keep d_hard if this deceleration could keep it from the start")};
  }
};

/// Names of the numbers that are drawn for a run, in order: "uav0.range", ..., then the keys of the
/// draws.
std::vector<std::string> drawn_names(const CampaignPlan& plan);

// Goals and paths that a user sends to a robot in flight, as one continuous reference.

/// A place on a robot's path.
struct Waypoint {
  double after =
      0.0;  ///< time of arrival after the message [s]; 0 for a single waypoint: at the track's own speed
  Vec3<double> p{};      ///< [m], in G
  double heading = 0.0;  ///< [rad]
};

/// Result of a message.
enum class GoalAnswer { taken, too_fast, full };

/// A reference that begins as the robot's own and then follows messages.
///
/// A message at time t leads from the present reference, with its velocity, to the goal. Each leg
/// is the cubic with these ends,
///
///   x*(s) = (2s^3 - 3s^2 + 1) p_0 + (s^3 - 2s^2 + s) T v_0 + (3s^2 - 2s^3) p_1 + (s^3 - s^2) T v_1,
///   s = (time - begin) / T
///
/// which from rest to rest is the blend s^2 (3 - 2 s) of events. A goal has T = 1.5 distance /
/// speed, the time at which the blend's greatest speed is `speed`. T is at least 1 s and 1.5 angle
/// / (1 rad/s). The legs of a path are straight lines, except the first, which meets the velocity
/// of the second. Headings turn the shorter way, by the blend.
///
/// x*(time) depends only on messages up to that time: a log and a replay reproduce the controller's
/// reference. One thread adds messages; any thread may read.
class GoalTrack {
 public:
  static constexpr std::size_t path_most = 64;                                   ///< waypoints of a message
  static constexpr std::size_t messages_most = 16'384, legs_most = 32'768;       ///< of a flight
  static constexpr double least_time = 1.0, turn_speed = 1.0, path_speed = 5.0;  ///< [s], [rad/s], [m/s]

  /// @param own    reference until the first message
  /// @param speed  towards goals [m/s], > 0
  GoalTrack(Model model, Reference own, double speed);

  /// Removes all messages: before a flight.
  void clear() noexcept { messages_.count = 0; }

  /// Adds a message at time t of the flight [s], later than the previous one, with 1 to path_most
  /// waypoints; those of a path have rising times. Allocates nothing.
  GoalAnswer add(double t, std::span<const Waypoint> waypoints) noexcept;

  /// Messages so far. Thread-safe.
  std::size_t messages() const noexcept { return messages_.count.load(std::memory_order_acquire); }
  /// Time of a message [s].
  double time(std::size_t message) const noexcept { return messages_.list[message].t; }
  /// Copies the waypoints of a message into `waypoints`.
  void waypoints(std::size_t message, std::vector<Waypoint>& waypoints) const;

  /// The reference of a track; shares ownership of the track.
  static Reference reference(std::shared_ptr<const GoalTrack> track);

 private:
  struct Leg {
    double begin = 0.0, end = 0.0;  // [s]
    Vec3<double> p_0{}, v_0{}, p_1{}, v_1{};
    double heading_0 = 0.0, heading_1 = 0.0;
    Waypoint waypoint{};
  };
  struct Message {
    double t = 0.0;  // [s]
    std::size_t first = 0, legs = 0;
  };
  struct Messages {
    std::vector<Message> list;
    std::atomic<std::size_t> count{0};
  };
  struct Moving {
    Vec3<double> p{}, v{};
    double heading = 0.0;
    bool heads = false;  // else the heading is free
  };
  /// State of a robot's model.
  struct State {
    std::array<double, Reference::max_states> x;
    std::size_t n;
    operator std::span<const double>() const { return {x.data(), n}; }
  };

  const Message* at(double t) const noexcept;
  const Leg& leg(const Message& message, double t) const noexcept;
  static Moving along(const Leg& leg, double t) noexcept;
  Moving moving(double t) const noexcept;
  Sight<double> own(double t) const noexcept;
  State state(double t) const;

  Model model_;
  Reference own_;
  double speed_;
  std::vector<double> rest_;  // inputs
  std::vector<Leg> legs_;
  Messages messages_;
};

/// A robot that accepts goals in flight.
struct GoalOptions {
  BodyId robot{};
  Reference own{};     ///< until the first goal
  double speed = 0.5;  ///< towards goals [m/s], > 0
};

/// A robot and its track.
struct RobotGoals {
  BodyId robot{};
  std::shared_ptr<GoalTrack> track{};
};

// Links of a team's bodies to real robots: [fleet], and `link` of robots, targets and obstacles.
// Only a bridge knows what they hold.

struct Agent;
struct ScenarioSpec;
class Team;
class TomlTable;

/// The links of a scenario: data, which never change.
class Links {
 public:
  virtual ~Links() = default;
  /// Lines for the summary of a scenario.
  virtual std::string describe(const Team& team) const = 0;
  /// The links of the part of the team that is planned here.
  /// @param part  its scenario, with the links of `whole`
  virtual std::shared_ptr<const Links> of_part(const ScenarioSpec& whole, const ScenarioSpec& part) const = 0;
};

/// Reads links; a program adds it to its Registry by with_links(). Throws ScenarioError.
class LinkReader {
 public:
  virtual ~LinkReader() = default;
  /// The speed towards goals that a robot accepts in flight [m/s], by the link in [agent.NAME];
  /// none: it accepts none.
  virtual std::optional<double> read_goal_speed(const TomlTable& agent, const Agent& robot) const = 0;
  /// All links of a document with [fleet], whose bodies the scenario has already.
  virtual std::shared_ptr<const Links> read_links(const TomlTable& root,
                                                  const ScenarioSpec& scenario) const = 0;
};

// Reads and checks the text of a scenario before it is parsed, and defines ScenarioError.

/// An invalid scenario. what() is one line, `file:line: key = value, expected ...`; within a
/// formula `file:line:column: ...`, columns in characters.
class ScenarioError : public std::runtime_error {
 public:
  /// Escapes control characters and bytes that are not UTF-8, so that what() stays one line.
  /// @param line  0 for an error that belongs to no line of the file
  ScenarioError(std::string_view file, std::size_t line, std::string_view sentence);
  ScenarioError(std::string_view file, std::size_t line, std::size_t column, std::string_view sentence);

  /// The file, or the name of another layer, "--set KEY=VALUE".
  const std::string& file() const { return file_; }
  /// The error, without its place.
  const std::string& sentence() const { return sentence_; }

 private:
  ScenarioError(std::string_view file, const std::string& place, std::string_view sentence);

  std::string file_, sentence_;
};

/// Largest size of a scenario [bytes].
inline constexpr std::size_t scenario_size_max = 10'000'000;

/// Greatest number of parts of a dotted key or header, `a.b.c`; bounds the recursion of the parser.
inline constexpr int key_parts_max = 16;

inline constexpr std::size_t shown_size = 60;  ///< of a key or a value in a message [bytes]

/// The content of a regular file; never waits on a pipe or a device.
/// @throws ScenarioError if the file is not regular, cannot be read or is too large
std::string read_text(const std::filesystem::path& file);

/// Texts of files that a scenario names, by these names.
using FileTexts = std::map<std::string, std::string>;

/// @throws ScenarioError if the text is not UTF-8, is empty, or has control characters or keys with
/// too many parts
void check_text(std::string_view text, std::string_view file);

// A scenario: everything that a run needs, from one TOML file. Reading gives a ScenarioSpec, which
// is data. build() makes the objects of a flight from it.
//
// The keys have the names of the C++ interface. Every number that the file omits has the default
// of the struct that it sets.

struct Registry;
const Registry& built_in_registry();

/// Settings of the closed loop and of its evaluation.
struct Simulation {
  double duration = 60.0;
  std::uint64_t seed = 1;
  double settle = 6.0, rms_from = 10.0;
  std::vector<std::string> compare{};
  Disturbances disturbances{};
  std::vector<Fault> faults{};  ///< of measurements
  std::vector<LatePlan> late_plans{};
  std::vector<TimedSignal> signals{};  ///< sent from outside to events

  static constexpr auto parameters() {
    using S = Simulation;
    return Parameters{
        KeyText{"seed", "an integer >= 0", "of all random numbers", "1"},
        KeyText{"compare", "solvers", "repeat the run afterwards; the run's own solver is skipped"},
        parameter("duration", &S::duration, "s", above_zero, "of the run"),
        parameter("settle", &S::settle, "s", from_zero, "start of the statistics of distances and views"),
        parameter("rms_from", &S::rms_from, "s", from_zero, "start of the statistics of position errors")};
  }
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
  double d_hard = 0.6;
  BarrierOptions barrier_options{.floor = 0.3, .ceiling = 10.0};
  double world = 100.0;
  Walls judged{};
  bool start_outside = false;
  double position_sigma = 0.0, heading_sigma = 0.0;
  std::optional<SupervisorOptions> supervisor{};
  SearchOptions search{};  ///< of vision-localized robots

  static constexpr auto parameters() {
    using S = Safety;
    return Parameters{
        parameter("barrier", &S::barrier, barrier_modes, "safety filter; report: applies nothing"),
        parameter("d_hard", &S::d_hard, "m", above_zero,
                  "least distance of a robot to any other body, centre to centre"),
        parameter("world", &S::world, "m", above_zero, "greatest magnitude of p_x and p_y"),
        KeyText{"start_outside", "true or false",
                "allows a start beyond a wall or zone, or within d_hard: judged from when it is first kept",
                "false"},
        parameter("position_sigma", &S::position_sigma, "m", from_zero,
                  "standard deviation of a measurement, each axis; default: that of the simulated noise"),
        parameter("heading_sigma", &S::heading_sigma, "rad", from_zero, "the same of the heading")};
  }
};

/// How the controllers see a velocity; an unknown one counts as zero.
enum class SeenVelocity { measured, unknown };

/// A target or an obstacle, which no solver of the team controls: its motion, and the robots'
/// assumptions about it.
struct UncooperativeBody {
  BodyId body{};
  std::optional<Motion> motion{};  ///< none: constant velocity
  SeenVelocity velocity = SeenVelocity::measured;
  double speed_max = 1.5;
  std::optional<double> d_hard{};
  std::string
      robot{};  ///< if another part of the team plans it as a robot: the name of its model; else empty

  static constexpr auto parameters() {
    using B = UncooperativeBody;
    return Parameters{
        parameter("velocity", &B::velocity, std::array<std::string_view, 2>{"measured", "unknown"},
                  "for the controllers; unknown: at rest"),
        parameter("speed_max", &B::speed_max, "m/s", from_zero,
                  "top speed that the robots assume; 0 for a body at rest in the scenario"),
        parameter("d_hard", &B::d_hard, "m", above_zero, "distance of robots; default: that of [safety]")};
  }
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
  double prediction_period = 0.1;
  static constexpr auto parameters() {
    return Parameters{parameter("prediction_period", &LogOptions::prediction_period, "s",
                                {1e-4, std::numeric_limits<double>::max(), ">= 1e-4"},
                                "between two logged predictions; default: longer from 100 robots on")};
  }
};

struct LoopKeys {
  double warm_up = 1e-3;
  static constexpr auto parameters() {
    return Parameters{parameter("warm_up", &LoopKeys::warm_up, "s", {0.0, 5e-3, "0 to 0.005"},
                                "longest time before a period of real time in which solvers fill the caches; "
                                "0: they do not; at most half of the period")};
  }
};

/// Limits of the input.
inline constexpr std::size_t agents_max = 1024;   // robots; same limit for targets plus obstacles
inline constexpr double updates_max = 1e9;        // duration / period
inline constexpr std::size_t name_size_max = 64;  // of a body [bytes]; names become topics of the log

/// What a file states. Copies are independent.
struct ScenarioSpec {
  std::string name;   ///< of the file, without folder and extension
  std::string text;   ///< as read; with several files or set values, the equivalent single text
  FileTexts files{};  ///< texts of the files that the scenario names, as read
  std::filesystem::path file;
  Horizon horizon{};
  SolverChoice solver{};
  Team team{};  ///< robots, then targets, then obstacles, each in the order of the file
  std::vector<std::string> coupling_places;  ///< place in the file of each coupling of the team, "file:line"
  std::vector<BodyId> targets;
  std::vector<BodyId> obstacles;
  std::vector<UncooperativeBody> uncooperative;  ///< targets, then obstacles
  std::vector<double> x0;                        ///< states of all bodies at the start (team.nx())
  std::vector<Presence> presence;                ///< of the bodies at the start; missing entries: present
  Script script{};                   ///< changes of the team in flight; `team` has every body of the flight
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
  std::vector<CertifiedView> certified_views{};  ///< with their certificates
  LogOptions log{};
  LoopKeys loop{};
  std::shared_ptr<const Links> links{};      ///< to its robots, if they are not simulated; null: none
  std::vector<GoalOptions> goal_options{};   ///< of the robots that accept goals in flight
  std::optional<PartitionPlan> partition{};  ///< of the whole team; if one part is planned here, `team` is
                                             ///< that part
  std::optional<CampaignPlan> campaign{};
  /// The error in [campaign], which stops no other flight; none if [campaign] is valid or missing.
  std::optional<ScenarioError> campaign_refusal{};

  /// Whether text and files are equal, and what programs change after reading: name, horizon, name
  /// of the solver, world, start, duration, seed and comparisons. The other members follow from
  /// text and files; the formulas of a team cannot be compared. Places in the file do not count.
  bool operator==(const ScenarioSpec& other) const;
};

/// A specification with the objects of its flights.
struct Scenario : ScenarioSpec {
  std::shared_ptr<const Registry>
      registry{};  ///< used for reading, also for reading again; null: the built-in one
  /// Events added in flight, after those of the script; shared by all threads that use it. Null: no
  /// tuning.
  std::shared_ptr<TunedScript> tuned{};
  std::vector<RobotGoals> goals{};  ///< of `goal_options`: the references that goals change
  /// Threads that share the barriers and the simulated world of a large team; no file sets them,
  /// since the result is the same. Null: one thread.
  std::shared_ptr<ThreadPool> pool{};
};

/// Makes the objects of a specification that was read with this registry.
Scenario build(ScenarioSpec spec, const Registry& registry = built_in_registry());

/// Reads a scenario from a file, and builds it.
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

/// Reads a text; error messages name `file`. Makes no solver, guard or world.
/// @throws ScenarioError
ScenarioSpec parse_spec(std::string text, const std::filesystem::path& file,
                        const Registry& registry = built_in_registry(), const ScenarioChanges& changes = {});

/// The text that parse_spec() reads back as an equal specification, unless a program has changed its
/// numbers since.
inline const std::string& toml_text(const ScenarioSpec& spec) { return spec.text; }

/// Reads a text, and builds its scenario.
/// @throws ScenarioError
Scenario parse_scenario(std::string text, const std::filesystem::path& file,
                        const Registry& registry = built_in_registry(), const ScenarioChanges& changes = {});

/// The vehicle of a body; null if it has none.
const RobotVehicle* vehicle_of(const ScenarioSpec& scenario, BodyId body);

/// Options of the simulated world of a scenario; below, with its threads, and of the controllers'
/// sensors.
PlantOptions plant_options(const ScenarioSpec& spec);
PlantOptions plant_options(const Scenario& scenario);
SensorOptions sensor_options(const ScenarioSpec& scenario);

/// Whether this computer plans one part of the team only.
bool plans_apart(const ScenarioSpec& scenario);

/// Whether robots join, leave or change couplings in flight, by the file or by tuning; then a
/// TeamSwitcher is necessary.
bool changes_in_flight(const ScenarioSpec& spec);
bool changes_in_flight(const Scenario& scenario);

/// The registry that a scenario was read with.
const Registry& registry_of(const Scenario& scenario);

/// The names of all solvers.
std::vector<std::string_view> solver_names(const Registry& registry = built_in_registry());

/// A solver with its default options.
/// @throws std::invalid_argument for an unknown name; the sentence lists the known ones
SolverChoice solver_named(std::string_view name, const Registry& registry = built_in_registry());

/// Makes the chosen solver for a team and a horizon.
std::unique_ptr<Solver> make_solver(const SolverChoice& choice, const Team& team, const Horizon& horizon);

/// A summary for the user: a few words for each robot, coupling and setting.
std::string summary(const ScenarioSpec& scenario);

// The numbers in a scenario's text by their keys, and their replacement in place.

struct TomlDocument;

/// A number and the bytes of the text that hold it.
struct NumberInText {
  std::size_t offset = 0, size = 0;
  double value = 0.0;
};

/// By key, as in error messages: "horizon.duration", "agent.uav0.start.p[2]", "couple[0].weight".
using ScenarioNumbers = std::map<std::string, NumberInText, std::less<>>;

ScenarioNumbers numbers_of(const TomlDocument& document);

/// The text with spaces for a section and its subsections: all else stays where it is.
std::string with_spaces_for(std::string_view section, const TomlDocument& document);

/// The text with other numbers at some places, each at most once; all else stays, comments and
/// lines too. A written number is read back bit for bit.
std::string with_numbers(std::string_view text, std::span<const std::pair<NumberInText, double>> changes);

// Checks of a scenario before its flight: reasons to refuse the flight, remarks and warnings.

struct Preflight {
  std::vector<std::string> refusals;  ///< reasons why it cannot be flown, with the file, a sentence each
  std::vector<std::string> remarks;   ///< rounded corners of regions, a sentence each
  std::vector<std::string> warnings;  ///< a sentence each

  /// Appends the first 20 sentences of a kind, and the number of the others.
  void warn(const std::vector<std::string>& sentences);
};

/// Runs the checks of the scenario alone; analysis.hpp has more. Set-up: allocates.
Preflight check_scenario(const Scenario& scenario);

// Closed loop of a scenario: the world and the controllers that `sightline run` and a campaign
// use.

/// @throws std::invalid_argument if the solver, or one of simulation.compare, lacks an ability that
/// the scenario needs (SolverAbilities)
void check_solvers(const ScenarioSpec& spec, const Registry& registry = built_in_registry());
void check_solvers(const Scenario& scenario);

/// The world that the scenario names. Adds cameras if there are cameras and tags, and telemetry if
/// robots are localized by vision.
std::unique_ptr<World> make_world(const Scenario& scenario);

/// Prepares a scenario for changes in flight. Clears `simulation.compare`, in its text too: many
/// solvers do not support a team that changes, and the text with the changes must be replayable.
/// @throws std::invalid_argument for a team that plans in parts, and as check_solvers()
void make_tunable(Scenario& scenario, TunedScript::Scope scope = TunedScript::Scope::world);

/// Removes the deadline for simulated time, so that a run gives the same result on any machine.
void lift_deadline(SolverChoice& choice);

/// Shares each update of a large team over these threads; the commands do not depend on their
/// number.
void share_updates(SolverChoice& choice, const std::shared_ptr<ThreadPool>& pool);

/// Returns a function that makes solvers of that choice, for teams with one horizon.
MakeSolver solver_maker(SolverChoice choice, const Horizon& horizon);

/// Controllers of a scenario: a solver of its team, one for each part, or a TeamSwitcher of them if
/// the team changes in flight.
class Controls {
 public:
  /// @throws as check_solvers(), and for a script with faults
  explicit Controls(const Scenario& scenario);

  /// Controllers of the initial team.
  Controllers controllers() const;
  /// Kernels of the initial solver.
  KernelUse kernels() const;
  /// Null for a team that does not change.
  TeamSwitcher* team_switcher() const { return team_switcher_.get(); }
  /// Prepares for another flight of the scenario, with other starts and another seed.
  /// @return false if new Controls are necessary: the state of a TeamSwitcher or of simulated
  /// messages depends on the flight
  bool restart();

 private:
  std::unique_ptr<Solver> solver_;
  bool talks_ = false;  // plans in parts, with simulated messages
  std::unique_ptr<TeamSwitcher> team_switcher_;
};

/// Guard and loop of one flight in a world, as the scenario specifies. The constructor allocates
/// all memory.
class ClosedLoop {
 public:
  /// @param world          of the scenario's team, from make_world() or another; the world, the
  ///                       controllers, the clock and the sink must outlive this object
  /// @param controllers    solvers of the scenario's team
  /// @param sink           its items are copies of sized_sample()
  /// @param allocations    returns the allocations of the calling thread so far; null: not counted
  /// @param team_switcher  of the Controls, if the scenario has one
  /// @param stop           true ends the flight at the next period
  /// @throws std::invalid_argument for an invalid start, disturbance or sink, with its name
  ClosedLoop(const Scenario& scenario, World& world, const Controllers& controllers, Clock& clock,
             Sink<Sample>& sink, std::int64_t (*allocations)() noexcept = nullptr,
             TeamSwitcher* team_switcher = nullptr, const std::atomic<bool>* stop = nullptr);
  ClosedLoop(const ClosedLoop&) = delete;
  ClosedLoop& operator=(const ClosedLoop&) = delete;

  /// Runs the flight to its end, once; closes the sink.
  LoopOutcome fly() noexcept { return loop_.run(); }

 private:
  std::optional<Guard> guard_;
  std::optional<Localizer> localizer_;
  std::optional<Compensation> compensation_;
  Loop loop_;
};

}  // namespace sightline
