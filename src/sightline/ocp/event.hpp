/// Teams that change in flight: what is to happen, and when. A script is data; `ActiveTeam` says what becomes of the
/// team, `EventMonitor` when. docs/events.md.
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

/// When: a struct of ocp/event/, each in a file of its own that says all of it. Its constants and functions:
///
///   keys           what a scenario calls it; exactly one key of an event is of a trigger
///   may_repeat     whether it can come about more than once
///   faults         numbers out of range, a sentence each
///   takes_no_time  whether it can come about the moment its stage begins
///   happens        asked once in each period; neither allocates nor throws
///   words          as a person reads it
///   read           from the event's table
///   bodies         that it is about, if any; they must be there
using Trigger = std::variant<AtTime, AfterTime, Condition, Signal>;

/// What: likewise.
///
///   key            what a scenario calls it, if it does; several may share one, told apart by
///   kinds          of which one stands in its table, with the keys `beside`
///   named          made of a body alone, if it can be: remove = "uav2"
///   expected       in place of what is no table, if more than "a table"
///   read           from its table
///   apply          makes the change; gives why it cannot be, a sentence: then nothing was changed
///   subject        what it changes: two changes of one subject at one time contradict each other
///   words          as a person reads it
///   needs          bodies that must be there, if any
///   usual_ramp     over which its weights change where the event says nothing, if not at once [s]
///   changes_surroundings  there, if it changes the world around the team
using Action = std::variant<RemoveBody, RemoveTerm, AddBody, AddCoupling, AddConstraint, RetuneAgent,
                            RetuneTerm, Observe, SetReference, HandOver, MoveBody, SetWind, InjectFault>;

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

/// The time over which an event's weights change [s]: its own; else the longest that is usual for its actions, 1 s
/// where an observer changes its target.
double ramp_of(const TeamEvent& event);

/// An event as a person reads it: its name, when it happens, and what it changes.
std::string in_words(const TeamEvent& event, const Team& all);

/// "x" of a stage "x:a"; empty for one without.
std::string_view region_of(std::string_view stage);

struct Script {
  std::vector<TeamEvent> events{};
  std::vector<std::string> begins = {std::string(first_stage)};  ///< the first stage of each region
  std::vector<ViewChoice> choices{};                             ///< whose events follow them (shape.hpp)
  bool empty() const { return events.empty(); }
};

/// Whether an event of the script changes the world around the team, which must then be a simulated one.
bool changes_surroundings(const Script& script);

/// What is wrong with an event of a script, a sentence.
struct ScriptFault {
  std::size_t event;
  std::string sentence;
};

class ActiveTeam;

/// What can be known without a flight: an observer of a choice that an event turns; numbers out of range, a stage that nothing enters, stages that could follow
/// each other in no time, two events at one time that contradict each other, what is not there removed or what
/// is there added.
std::vector<ScriptFault> faults_of(const Script& script, const ActiveTeam& active_team);

}  // namespace sightline
