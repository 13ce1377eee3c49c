/// Teams that change in flight: what is to happen, and when. A script is data; `Roster` says what becomes of the
/// team, `Watch` when. docs/events.md.
///
/// Bodies are those of one Team that has all there will ever be. A run is in one stage at a time; it begins in
/// "start". An event is armed in its stage only, or in all; once it has happened it is over until its stage is
/// entered again, unless it repeats. Stages "x:a", "x:b" exclude each other only, not those of other x or of none.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sightline/ocp/team.hpp"

namespace sightline {

// When.

/// At this time of the run.
struct AtTime {
  double t = 0.0;  ///< [s], >= 0
};
/// At this time after its stage began; for an event of all stages, after the run began.
struct AfterTime {
  double delay = 0.0;  ///< [s], >= 0
};
/// A message from outside, by its name; one that arrives while no event waits for it is lost.
struct Signal {
  std::string name;
};
/// One as a simulation sends it.
struct TimedSignal {
  double at = 0.0;  ///< [s], >= 0
  std::string name;
};

/// What a condition looks at.
struct DistanceOf {
  BodyId a, b;  ///< of their positions [m]
};
struct ViewAngleOf {
  BodyId observer, target;
  SensorMount mount{};  ///< angle between the sensor's axis and the target, (71) [rad]
};
/// How far a limit is broken, in its unit: > 0 outside.
struct ExcessOf {
  Potential potential;  ///< one that states a limit
  BodyId a, b;          ///< the same body twice for a potential of one
};
/// How old what is known of a body is [s].
struct AgeOf {
  BodyId body;
};
/// How much nearer than the robot a, in its stead, the robot b is to a target [m]; infinite where a is not steered.
struct NearerThan {
  BodyId a, b, target;
};
using Measure = std::variant<DistanceOf, ViewAngleOf, ExcessOf, AgeOf, NearerThan>;

/// True once the measure has been beyond the threshold for `dwell`; false again once it has come back by more than
/// `hysteresis`.
struct Condition {
  enum class Side { above, below };
  Measure measure;
  Side side = Side::above;
  double threshold = 0.0;
  double hysteresis = 0.0;  ///< in the measure's unit, >= 0
  double dwell = 0.0;       ///< [s], >= 0
};

using Trigger = std::variant<AtTime, AfterTime, Signal, Condition>;

// What.

/// What an uncontrolled robot does.
enum class Afterwards {
  vanish,  ///< it is removed
  hold,    ///< it brakes and stays; the others still feel their couplings with it
  land,    ///< it brakes and sinks to the ground
};
struct RemoveBody {
  BodyId body;
  Afterwards afterwards = Afterwards::vanish;  ///< of a robot; others vanish
};
/// At its start; with its couplings to bodies that are present.
struct AddBody {
  BodyId body;
};
struct AddCoupling {
  Coupling coupling;
};
struct AddConstraint {
  Constraint constraint;
};
/// A coupling or constraint, by its name.
struct RemoveTerm {
  std::string name;
};
/// What is left out does not change.
struct RetuneTerm {
  std::string name;
  std::optional<double> weight{};
  std::optional<Potential> potential{};
};
struct RetuneAgent {
  AgentId agent;
  std::optional<std::vector<double>> Q{}, R{}, Q_f{}, u_ref{};
  std::optional<InputLimits> limits{};
};
struct SetReference {
  AgentId agent;
  Reference reference;
};
/// The robot observes another body from now on: its couplings with a sensor, and those that hold it to what it
/// observed, go over. Whatever keeps the two apart (protection.hpp) stays, and the new target gets the same if it has
/// none; of a region that does both, the limits that keep them apart stay behind.
struct Observe {
  AgentId observer;
  BodyId target;
};
using Action = std::variant<RemoveBody, AddBody, AddCoupling, AddConstraint, RemoveTerm, RetuneTerm,
                            RetuneAgent, SetReference, Observe>;

inline constexpr std::string_view first_stage = "start";

struct TeamEvent {
  std::string name;
  Trigger trigger;
  std::vector<Action> actions{};
  std::string stage{};           ///< armed in this one; empty: in all
  std::string enter{};           ///< the stage that begins with it; empty: the present one goes on
  bool repeat = false;           ///< of a condition or a signal: as often as it comes about
  std::optional<double> ramp{};  ///< of the weights that change [s], >= 0; none: ramp_of()
};

/// The time over which an event's weights change [s]: its own; else 1 s where an observer changes its target,
/// else 0.
double ramp_of(const TeamEvent& event);

/// "x" of a stage "x:a"; empty for one without.
std::string_view region_of(std::string_view stage);

struct Script {
  std::vector<TeamEvent> events{};
  std::vector<std::string> begins = {std::string(first_stage)};  ///< the first stage of each region
  bool empty() const { return events.empty(); }
};

/// What is wrong with an event of a script, a sentence.
struct ScriptFault {
  std::size_t event;
  std::string sentence;
};

class Roster;

/// What can be known without a flight: numbers out of range, a stage that nothing enters, stages that could follow
/// each other in no time, two events at one time that contradict each other, what is not there removed or what
/// is there added.
std::vector<ScriptFault> faults_of(const Script& script, const Roster& roster);

}  // namespace sightline
