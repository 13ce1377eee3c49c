/// Teams that change in flight: the changes and their times. A script is data; `ActiveTeam` applies
/// the changes to the team, `EventMonitor` decides when. See docs/events.md.
///
/// All bodies belong to one Team with every body of the flight. A run is in one stage at a time; it
/// begins in "start". An event is armed in its own stage only, or in all stages. After it has
/// happened, it stays disarmed until its stage is entered again, unless it repeats. Stages "x:a"
/// and "x:b" exclude each other only, not those of another x or of none.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sightline/ocp/event/add_body.hpp"
#include "sightline/ocp/event/add_term.hpp"
#include "sightline/ocp/event/after_time.hpp"
#include "sightline/ocp/event/at_time.hpp"
#include "sightline/ocp/event/condition.hpp"
#include "sightline/ocp/event/hand_over.hpp"
#include "sightline/ocp/event/inject_fault.hpp"
#include "sightline/ocp/event/move_body.hpp"
#include "sightline/ocp/event/observe.hpp"
#include "sightline/ocp/event/remove_body.hpp"
#include "sightline/ocp/event/remove_term.hpp"
#include "sightline/ocp/event/retune_agent.hpp"
#include "sightline/ocp/event/retune_term.hpp"
#include "sightline/ocp/event/set_reference.hpp"
#include "sightline/ocp/event/set_wind.hpp"
#include "sightline/ocp/event/signal.hpp"

namespace sightline {

/// When: a struct of ocp/event/, each complete in a file of its own. Its constants and functions:
///
///   keys           its keys in a scenario; exactly one key of an event is of a trigger
///   may_repeat     whether it can occur more than once
///   faults         numbers out of range, a sentence each
///   takes_no_time  whether it can occur at the begin of its stage
///   occurs         evaluated once in each period; neither allocates nor throws
///   describe       a text for the user
///   read           from the event's table
///   bodies         that it refers to, if any; they must be present
using Trigger = std::variant<AtTime, AfterTime, Condition, Signal>;

/// What: likewise.
///
///   key            its key in a scenario, if it has one; actions with the same key differ by
///   kinds          of which exactly one is in its table, with the keys `beside`
///   named          made of a body alone, if it can be: remove = "uav2"
///   expected       in the error for a value that is not a table, if more than "a table"
///   read           from its table
///   apply          makes the change; returns the reason of a rejection, a sentence, with nothing changed
///   subject        what it changes: two changes of one subject at one time contradict each other
///   describe       a text for the user
///   needs          bodies that must be present, if any
///   usual_ramp     default duration of its weights' change, if not 0 [s]
///   changes_surroundings  defined if it changes the world around the team
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

/// Duration of the change of an event's weights [s]: its own, else the longest usual_ramp of its
/// actions, else 0.
double ramp_of(const TeamEvent& event);

/// An event as a text for the user: its name, its trigger, its changes.
std::string in_words(const TeamEvent& event, const Team& all);

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
