/// Teams that change in flight: the changes and their times. A script is data; `ActiveTeam` applies
/// the changes to the team, `EventMonitor` decides when. See docs/events.md.
///
/// All bodies belong to one Team with every body of the flight. A run is in one stage at a time; it
/// begins in "start". An event is armed in its own stage only, or in all stages. After it has
/// happened, it stays disarmed until its stage is entered again, unless it repeats. Stages "x:a"
/// and "x:b" exclude each other only, not those of another x or of none.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sightline/ocp/surroundings.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/ocp/view_choice.hpp"

namespace sightline {

// What a condition looks at. There is no measure of an absent body.

/// Distance of the positions of two bodies [m].
struct DistanceOf {
  BodyId a, b;
};

/// The angle between the sensor's axis and the target, (71) [rad].
struct ViewAngleOf {
  BodyId observer, target;
  SensorMount mount{};
};

/// Age of the last measurement of a body [s].
struct AgeOf {
  BodyId body;
};

/// Violation of a limit, in its unit: > 0 outside.
struct ExcessOf {
  Potential potential;  ///< one that states a limit
  BodyId a, b;          ///< a potential of one robot has the same body twice
};

/// How much nearer the robot b is to a target than the robot a, which b would replace [m]. Infinite
/// if a is not steered, so that b replaces a robot that brakes or sinks; no measure if b is not
/// steered. Made by shapes only (shape.hpp).
struct NearerThan {
  BodyId a, b, target;
};

/// 1 in the period in which a choice turns an observer to this target, or to nobody; else 0. Made
/// by shapes only.
struct TurnedTo {
  std::size_t choice = 0;    ///< index in the script
  std::size_t observer = 0;  ///< index in the choice
  int target = ViewChoice::nobody;
  BodyId body{};  ///< the observer
};

using Measure = std::variant<DistanceOf, ViewAngleOf, AgeOf, ExcessOf, NearerThan, TurnedTo>;

// When.

/// Occurs at this time of the run.
struct AtTime {
  double t = 0.0;  ///< [s], >= 0
};

/// Occurs at this time after its stage began; for an event of all stages, after the run began.
struct AfterTime {
  double delay = 0.0;  ///< [s], >= 0
};

/// Holds once the measure has been beyond the threshold for `dwell`; ends once the measure has
/// returned by more than `hysteresis`.
struct Condition {
  enum class Side { above, below };

  Measure measure;
  Side side = Side::above;
  double threshold = 0.0;
  double hysteresis = 0.0;  ///< in the measure's unit, >= 0
  double dwell = 0.0;       ///< [s], >= 0
};

/// A message from outside, by its name; it is lost if no event waits for it.
struct Signal {
  std::string name;
};

using Trigger = std::variant<AtTime, AfterTime, Condition, Signal>;

// What.

/// Behaviour of a robot that leaves the team.
enum class Afterwards {
  vanish,  ///< it is removed
  hold,    ///< it brakes and stays; its couplings still act on the other robots
  land,    ///< it brakes and descends to the ground
};

struct RemoveBody {
  BodyId body;
  Afterwards afterwards = Afterwards::vanish;  ///< of a robot; other bodies vanish
};

/// Fades out a coupling or constraint, by its name.
struct RemoveTerm {
  std::string name;
};

/// The body joins at its start, with its couplings to bodies that are present.
struct AddBody {
  BodyId body;
};

struct AddCoupling {
  Coupling coupling;
};

struct AddConstraint {
  Constraint constraint;
};

/// New weights, u_ref or limits of a robot. Values that are left out do not change.
struct RetuneAgent {
  AgentId agent;
  std::optional<std::vector<double>> Q{}, R{}, Q_f{}, u_ref{};
  std::optional<InputLimits> limits{};
};

/// Of a coupling or constraint; values that are left out do not change.
struct RetuneTerm {
  std::string name;
  std::optional<double> weight{};
  std::optional<Potential> potential{};
};

/// The robot observes another body from now on. Its couplings with a sensor move to the new target,
/// and so do those that hold it to the previous target. Couplings that keep the two apart
/// (protection.hpp) stay, and the new target gets the same if it has none. If a region does both,
/// its limits that keep them apart stay behind.
struct Observe {
  AgentId observer;
  BodyId target;
};

struct SetReference {
  AgentId agent;
  Reference reference;
};

/// An observer of a choice (view_choice.hpp) turns to another target: couplings of these names fade
/// out, if they are in force; others of the same names fade in. Made by shapes only.
struct HandOver {
  AgentId observer{};
  std::vector<std::string> names{};
  std::vector<Coupling> couplings{};  ///< empty: no target
};

/// A target or an obstacle moves to a place, over the ramp, and stays there; for a simulated world.
struct MoveBody {
  BodyId body;
  Vec3<double> p;  ///< in G [m]
};

/// Another steady wind, which rises over the ramp; for a simulated world.
struct SetWind {
  Vec3<double> acceleration;  ///< in G [m/s^2]
};

/// A fault of a body's measurements that begins now; for a simulated world.
struct InjectFault {
  Surroundings::FaultKind kind;
  BodyId body;
  double lasts;           ///< [s], > 0
  Vec3<double> offset{};  ///< of a jump, in G [m]
};

using Action = std::variant<RemoveBody, RemoveTerm, AddBody, AddCoupling, AddConstraint, RetuneAgent,
                            RetuneTerm, Observe, SetReference, HandOver, MoveBody, SetWind, InjectFault>;

inline constexpr std::string_view first_stage = "start";

struct TeamEvent {
  std::string name;
  Trigger trigger;
  std::vector<Action> actions{};
  std::string stage{};           ///< in which it is armed; empty: in all
  std::string enter{};           ///< the stage that it begins; empty: the present one continues
  bool repeat = false;           ///< of a condition or a signal: whenever it occurs
  std::optional<double> ramp{};  ///< of the weights that change [s], >= 0; none: ramp_of()
};

/// Duration of the change of an event's weights [s]: its own; else 1 s if it turns an observer,
/// moves a body or changes the wind, else 0.
double ramp_of(const TeamEvent& event);

/// "x" of a stage "x:a"; empty for one without.
std::string_view region_of(std::string_view stage);

struct Script {
  std::vector<TeamEvent> events{};
  std::vector<std::string> begins = {std::string(first_stage)};  ///< the first stage of each region
  std::vector<ViewChoice> choices{};                             ///< that events follow (shape.hpp)
  bool empty() const { return events.empty(); }
};

/// Whether an event of the script changes the world around the team, which must then be a simulated
/// one.
bool changes_surroundings(const Script& script);

/// An error in an event of a script, a sentence.
struct ScriptFault {
  std::size_t event;
  std::string sentence;
};

class ActiveTeam;

/// Errors that are known without a flight: numbers out of range; a stage that no event enters;
/// stages that could follow each other in no time; two contradicting events at one time; removal of
/// an absent item or addition of a present one; an event that turns an observer of a choice.
std::vector<ScriptFault> faults_of(const Script& script, const ActiveTeam& active_team);

}  // namespace sightline
