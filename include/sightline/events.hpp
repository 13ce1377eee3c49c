/// Teams that change in flight: triggers, actions, scripts, shapes of large teams, and the active team.
#pragma once

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/potential.hpp"
#include "sightline/team.hpp"

namespace sightline {

// What events change around a team: which bodies are present, and of a simulated world the
// positions of targets and obstacles, the wind and measurement faults.

enum class Presence : std::uint8_t {
  absent,   ///< not in the world
  steered,  ///< a robot of the team
  hold,     ///< present, not controlled: a robot that brakes and stays, a target or an obstacle
  land,     ///< a robot that brakes and descends
};

/// Changes of a simulated world; others ignore them.
struct Surroundings {
  /// A target or an obstacle that moves to a place and stays there, whatever its motion was before.
  struct Move {
    BodyId body{};
    Vec3<double> to{};                   ///< in G [m]
    double begin = 0.0, duration = 0.0;  ///< [s]; lasts longer if the body would exceed its top speed
  };
  /// Steady acceleration of all robots in G.
  struct Wind {
    Vec3<double> acceleration{};         ///< [m/s^2]
    double begin = 0.0, duration = 0.0;  ///< duration of the change from the previous wind [s]
  };
  enum class FaultKind { dropout, freeze, jump };
  /// A fault in the measurements of a body, during from <= t < until.
  struct Fault {
    FaultKind kind = FaultKind::dropout;
    BodyId body{};
    Vec3<double> offset{};           ///< of a jump, in G [m]
    double from = 0.0, until = 0.0;  ///< [s]
  };
  /// Greatest number of faults in force at one time.
  static constexpr std::size_t faults_max = 32;

  std::vector<Move> moves{};  ///< the latest of each body
  std::optional<Wind> wind{};
  std::vector<Fault> faults{};
};

/// Progress at t of a change that begins at `begin` and takes `duration`: 0 to 1, with zero slope
/// at both ends.
inline double blended(double t, double begin, double duration) {
  return Ramp{.begin = begin, .duration = duration, .from = 0.0, .to = 1.0}.at(t);
}

// Chooses observers and targets among robots that are localized by vision: `best` of a [[shape]].

struct EventContext;
struct EventInstant;

/// Variance that the view of a target adds to the observer's position, by their distance.
struct ViewVariance {
  double step = 0.1;             ///< [m], > 0
  std::vector<double> values{};  ///< at 0, step, 2 step, ... [m^2], >= 0; infinite: not detected

  /// Variance at a distance [m], by interpolation; infinite beyond the last value.
  double at(double distance) const noexcept;
};

/// Cost of a turn to another target [m^2]: a share of the variance gained without a view, q t +
/// sigma_b^2 t^2 with t = delay + angle / rate. That variance vanishes soon after the turn, while
/// the variance of a view stays. Of shares from 0.1 to 1, 0.25 gave the best result
/// (docs/shapes.md).
struct TurnPrice {
  double delay = 0.2;         ///< [s], >= 0
  double rate = 1.2;          ///< of the turn [rad/s], > 0
  double walk = 0.05;         ///< sqrt(q) [m/sqrt(s)], >= 0
  double drift_sigma = 0.08;  ///< sigma_b, bias of the measured velocity [m/s], >= 0
  double share = 0.25;        ///< in [0, 1]

  double operator()(double angle) const noexcept;
};

/// Each observer views one of the targets, with at most `at_most` observers for each target. A
/// target that is not an observer has a known position. The variance of an observer is that of its
/// target plus that of the view, so a path of views leads to a known position.
struct ViewChoice {
  std::string name{};
  std::vector<AgentId> observers{};
  std::vector<BodyId> targets{};                  ///< observers may be among them
  std::vector<ViewVariance> variances{};          ///< [observer][target]
  int at_most = std::numeric_limits<int>::max();  ///< observers of one target, >= 1
  double margin = 0.01;  ///< standard deviation that a change must gain, beside the turn [m], >= 0
  double dwell = 1.0;    ///< duration of that gain [s], > 0; least time between changes of one observer
  TurnPrice price{};
  std::vector<int> first{};  ///< target of each observer at first, -1: none

  static constexpr int nobody = -1;

  /// @throws std::invalid_argument with a sentence: numbers out of range, a duplicate observer or
  /// target, no target with a known position
  void check(const Team& team) const;
};

/// Chooses targets once each period, from the state of that period.
///
/// Computes shortest paths from the targets with known positions (Dijkstra). A view costs its
/// variance; a view that is not present also costs its turn and margin^2. A change takes place once
/// the paths have required it for `dwell`, or at once for an observer without a target. It must not
/// close a cycle or exceed at_most. An observer without any path keeps its target, unless others
/// need its place.
///
/// Absent targets and observers that are not steered are left out. Deterministic; allocates nothing
/// after construction.
class ViewChooser {
 public:
  explicit ViewChooser(const ViewChoice& choice);

  /// Updates the choice; to be called once each period.
  void look(const EventInstant& now) noexcept;
  /// Target of an observer, by indices in the choice; `nobody` if it has none.
  int target(std::size_t observer) const noexcept { return present_[observer]; }
  /// Whether the last look() changed the target.
  bool changed(std::size_t observer) const noexcept { return changed_[observer] != 0; }

  /// The best choice for these poses without any present views: for ViewChoice::first.
  static std::vector<int> first(const ViewChoice& choice, const Team& all, const EventContext& known);

 private:
  struct Node {
    BodyId body{};
    int observer = -1, target = -1;  // indices in the choice
    bool there = false, done = false;
    double cost = 0.0;
    Sight<double> sight{};
  };

  void plan(const EventInstant& now) noexcept;
  void consider(Node& observer, const Node& target) noexcept;
  bool can_be(std::span<const int> targets) const noexcept;
  void turn(std::size_t observer, int target, double t) noexcept;

  ViewChoice choice_;
  std::vector<Node> nodes_;  // observers, then targets that are not observers
  std::vector<int> node_of_target_;
  std::vector<int> want_, present_, trial_;  // [observer]: targets
  std::vector<std::size_t> order_;           // observers, nearest to a known position first
  std::vector<int> used_;                    // [target]
  mutable std::vector<int> count_;           // [target]
  std::vector<double> since_, turned_;       // [observer] [s]
  std::vector<char> changed_, due_;
};

// Teams that change in flight: the changes and their times. A script is data; `ActiveTeam` applies
// the changes to the team, `EventMonitor` decides when. See docs/events.md.
//
// All bodies belong to one Team with every body of the flight. A run is in one stage at a time; it
// begins in "start". An event is armed in its own stage only, or in all stages. After it has
// happened, it stays disarmed until its stage is entered again, unless it repeats. Stages "x:a"
// and "x:b" exclude each other only, not those of another x or of none.

// What a condition measures; of absent bodies there is no measure.

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
/// steered. Made by shapes only.
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

// Triggers: when an event occurs.

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

// Actions: what an event changes.

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
/// (keeps_apart()) stay, and the new target gets the same if it has none. If a region does both,
/// its limits that keep them apart stay behind.
struct Observe {
  AgentId observer;
  BodyId target;
  std::optional<SensorMount>
      through{};  ///< of several sensors, the one that turns; none: the first that observes
};

struct SetReference {
  AgentId agent;
  Reference reference;
};

/// An observer of a choice (ViewChoice) turns to another target, or its certified view does:
/// couplings of these names fade out, if they are in force; others of the same names fade in. Made
/// by shapes and for certified views only.
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
  std::vector<ViewChoice> choices{};                             ///< that events follow
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

// The active team: which bodies are present and which couplings are in force, as events change
// them.

/// A robot whose reference blends from the previous to the present one.
struct Turn {
  AgentId agent;
  Reference from;
  Ramp ramp;
};

/// State that events change. Bodies are those of `all`.
struct TeamState {
  Team all;                         ///< only its bodies are used
  std::vector<Agent> agents;        ///< with present tuning, in the order of `all`
  std::vector<Coupling> couplings;  ///< in force or fading
  std::vector<Constraint> constraints;
  std::vector<Turn> turns;
  std::vector<Presence> presence;  ///< of each body
  Surroundings around{};

  /// Index of a robot in `agents`.
  std::size_t place(AgentId id) const { return all.agent_index(id); }
  /// Reference of a robot from time t [s] on.
  Reference reference(AgentId id, double t) const;
  /// Whether a coupling or constraint of that name is in force or fading in.
  bool has_term(std::string_view name) const;
};

/// Present state of each body of a team, for the evaluation and the guard of commands.
struct Membership {
  std::vector<Presence> presence;  ///< [body]
  std::vector<std::vector<BodyId>>
      partners;                     ///< [robot]: bodies with couplings that act on it; empty unless steered
  std::vector<InputLimits> limits;  ///< [robot]
  Surroundings around{};            ///< changes by events
  std::vector<std::vector<BodyId>> observed{};  ///< [robot]: bodies that it observes; empty unless steered
};

class ActiveTeam {
 public:
  /// @param all       every body of the flight, and the initial couplings
  /// @param presence  of each body; missing entries: robots are steered, other bodies on hold
  explicit ActiveTeam(Team all, std::vector<Presence> presence = {});

  /// Applies one change at time t [s]; weights are blended over `ramp` [s].
  /// @return the reason of a rejection, a sentence, with the team unchanged; else empty
  std::string apply(const Action& action, double t, double ramp);

  /// The steered robots and the terms that act on them, from time t on. Bodies keep the order of
  /// all(). A robot that is not steered is an obstacle with its heading, for the robots coupled
  /// with it and for the robots of its swarms. Terms that have faded out are omitted.
  /// @throws std::invalid_argument if no steered robot is left
  Team team(double t) const;
  /// Time at which the last ramp that is active at t ends [s]; minus infinity without one.
  double at_rest_from(double t) const;

  Membership membership() const;

  const Team& all() const { return now_.all; }
  /// A robot with its present tuning.
  const Agent& agent(AgentId robot) const { return now_.agents[now_.place(robot)]; }
  const std::vector<Presence>& presence() const { return now_.presence; }
  Presence presence(BodyId body) const { return now_.presence[at(body)]; }
  /// Couplings in force or fading, of present and of absent bodies.
  const std::vector<Coupling>& couplings() const { return now_.couplings; }
  const std::vector<Constraint>& constraints() const { return now_.constraints; }
  /// Whether a coupling or constraint of that name is in force or fading in.
  bool has_term(std::string_view name) const { return now_.has_term(name); }

 private:
  std::vector<Coupling> swarm_couplings() const;

  TeamState now_;
};

// Events that a user adds in flight, after those of the script; they happen when they arrive.
//
// One thread adds events, the control thread takes one per period, and other threads read their
// state. No thread waits: an event never changes once it is counted. Appended to the scenario with
// the times at which they happened, they are ordinary events, and a replay gives the same flight.

class TunedScript {
 public:
  static constexpr std::size_t room = 1000;  ///< greatest number of events of one flight

  /// What the events may change: the team alone, or the simulated world around it, too.
  enum class Scope { team, world };

  explicit TunedScript(Scope scope = Scope::world) : scope_(scope), all_(room) {}

  Scope scope() const noexcept { return scope_; }

  bool is_full() const noexcept { return size() == room; }
  /// Appends an event. By one thread; not once the script is full.
  /// @param text  the keys of its [[event]] other than `at`, as in a scenario, with their line ends
  void add(TeamEvent event, std::string text) {
    const std::size_t i = size();
    all_[i] = std::make_unique<Tuned>(std::move(event), std::move(text));
    size_.store(i + 1, std::memory_order_release);
  }

  std::size_t size() const noexcept { return size_.load(std::memory_order_acquire); }
  const TeamEvent& event(std::size_t i) const noexcept { return all_[i]->event; }
  /// Time at which it happened [s]; NaN before.
  double at(std::size_t i) const noexcept { return all_[i]->at.load(std::memory_order_acquire); }
  /// Whether the team rejected it, with no change.
  bool is_ignored(std::size_t i) const noexcept { return all_[i]->ignored.load(std::memory_order_acquire); }
  /// The text as an [[event]] at t [s].
  std::string text(std::size_t i, double t) const {
    return fmt::format("\n[[event]]\nat = {}\n{}", t, all_[i]->text);
  }

  // By the control thread only.

  void occur(std::size_t i, double t) noexcept { all_[i]->at.store(t, std::memory_order_release); }
  void ignore(std::size_t i) noexcept { all_[i]->ignored.store(true, std::memory_order_release); }

 private:
  struct Tuned {
    Tuned(TeamEvent what, std::string keys) : event(std::move(what)), text(std::move(keys)) {}
    TeamEvent event;
    std::string text;
    std::atomic<double> at{std::numeric_limits<double>::quiet_NaN()};
    std::atomic<bool> ignored{false};
  };

  Scope scope_;
  std::vector<std::unique_ptr<Tuned>> all_;
  std::atomic<std::size_t> size_{0};
};

/// The event of that number in a flight: of the script, then of the tuned ones; null beyond the
/// last.
/// @param tuned  null: no tuned events
inline const TeamEvent* flown_event(const Script& script, const TunedScript* tuned, std::size_t number) {
  const std::size_t n = script.events.size();
  if (number < n) return &script.events[number];
  return tuned != nullptr && number - n < tuned->size() ? &tuned->event(number - n) : nullptr;
}

// Whether a trigger occurs, by the state of a period and the history of its event.

/// State of a period.
struct EventContext {
  double t = 0.0;                      ///< [s]
  std::span<const double> x;           ///< states of all bodies (nx)
  std::span<const double> u;           ///< inputs of all robots (nu)
  std::span<const double> ages;        ///< of the last measurement of each body [s]; empty: all 0
  std::span<const Presence> presence;  ///< of each body; conditions on an absent body do not hold
};

/// History of an event's condition.
struct ConditionState {
  bool holds = false;  ///< the condition, with its hysteresis
  bool fired = false;  ///< since it last began to hold
  double since = 0.0;  ///< when it began to hold [s]
};

/// State of a period at which a trigger is evaluated.
struct EventInstant {
  const Team& all;
  const EventContext& known;
  double began;    ///< begin of its stage [s]
  bool signalled;  ///< its signal arrived since the last evaluation
  ConditionState& condition;
  std::span<const ViewChooser> choosers{};  ///< of the script's choices

  bool is_there(BodyId body) const noexcept {
    return known.presence.empty() || known.presence[at(body)] != Presence::absent;
  }
  bool is_steered(BodyId body) const noexcept {
    return known.presence.empty() || known.presence[at(body)] == Presence::steered;
  }
  double age(BodyId body) const noexcept { return known.ages.empty() ? 0.0 : known.ages[at(body)]; }
  Sight<double> sight(BodyId body) const noexcept {
    const double* const u = all.is_agent(body) ? known.u.data() + all.input_offset(body) : nullptr;
    return all.model(body).sight(known.x.data() + all.state_offset(body), u);
  }
};

/// To be called once in each period; neither allocates nor throws.
bool occurs(const Trigger& trigger, const EventInstant& now) noexcept;

// Determines once each period which events of a script happen.

class EventMonitor {
 public:
  /// @param all  the bodies of the script
  EventMonitor(const Script& script, const Team& all);

  /// The events that happen now, in the order of the script; a stage that one of them enters begins
  /// now. Allocates nothing.
  /// @return indices in the script, valid until the next call
  std::span<const std::size_t> look(const EventContext& known) noexcept;

  /// Registers a message; the events that wait for it happen at the next look(). Thread-safe.
  /// @return whether an event of the script has this signal
  bool signal(std::string_view name) noexcept;

  /// The present stage of a region; empty if the script has none of it.
  std::string_view stage(std::string_view region = {}) const noexcept;

 private:
  struct State {
    std::size_t stage = 0, enter = 0;  // in stages_, 0: none
    bool over = false;
    ConditionState condition{};
  };

  /// The present stage of those that exclude each other.
  struct Region {
    std::string name;
    std::size_t stage = 0;
    double began = 0.0;  // [s]
  };

  std::size_t stage_of(const std::string& name);
  Region& region_of_stage(std::size_t stage) noexcept { return regions_[stage_regions_[stage]]; }

  Script script_;
  Team all_;
  std::vector<std::string> stages_;  // the first is no stage
  std::vector<State> states_;
  std::deque<std::atomic<bool>> signals_;  // of each event
  std::vector<ViewChooser> choosers_;
  std::vector<std::size_t> triggered_;
  std::vector<std::size_t> stage_regions_;  // of each stage
  std::vector<Region> regions_;
};

// Topologies of couplings in a large team, in one line.
//
//   chain      b_1 observes b_0, b_2 observes b_1, ...    n - 1 pairs
//   ring       the same, and b_0 observes the last        n pairs
//   star       many observe one centre                    a pair each
//   all pairs  each body with each later one              n (n - 1) / 2 pairs
//
// A shape is only a list of pairs; `couple` expands it to ordinary couplings, so that no other
// code depends on shapes.

/// Each of these rejects a duplicate body.
/// @throws std::invalid_argument
std::vector<Between> chain(const std::vector<BodyId>& bodies);
std::vector<Between> ring(const std::vector<BodyId>& bodies);
std::vector<Between> star(BodyId centre, const std::vector<BodyId>& observers);
std::vector<Between> all_pairs(const std::vector<BodyId>& bodies);

/// On whom the couplings of a shape act: on the first of each pair, or on both, if they are robots.
enum class FeltBy { observer, both };

/// The agents of a pair on which its couplings act.
std::vector<AgentId> feeling(const Team& team, Between pair, FeltBy felt_by);

/// The terms of a pair: an observer's potential has the mount of its own sensor.
using TermsOf = std::function<std::vector<Weighted>(Between)>;

/// Couples each pair by each of its terms, pair by pair.
/// @throws std::invalid_argument as Team::couple does
void couple(Team& team, const TermsOf& terms_of, std::span<const Between> pairs, FeltBy felt_by);
/// The same with equal terms for all pairs.
void couple(Team& team, const std::vector<Weighted>& terms, std::span<const Between> pairs, FeltBy felt_by);

/// Condition under which another robot becomes the observer.
struct RelayOptions {
  std::string name{};   ///< of the relay, its couplings, stages and events
  double margin = 0.3;  ///< by which it must be nearer [m], >= 0
  double dwell = 1.0;   ///< for which it must be nearer [s], > 0
  double ramp = 1.0;    ///< of the weights [s], >= 0
};

/// The nearest of several robots observes a target, and the terms act on it; initially the first of
/// the list. An event for each ordered pair of robots hands over, in stages "<name>:<robot>".
/// @throws std::invalid_argument for a name that is empty or taken, or as couple()
void relay(Team& team, Script& script, const TermsOf& terms_of, const std::vector<AgentId>& observers,
           BodyId target, const RelayOptions& options);

/// Each observer of the choice views one of its targets, and the terms act on the observer.
/// Initially the targets are choice.first. Events "<name>: <observer> turns to <target>" follow the
/// choice, with couplings "<name>:<observer> <number>".
/// @param ramp  of the weights [s], >= 0
/// @throws std::invalid_argument for a choice that check() rejects, an observer of another choice,
/// a name that is empty or taken, or as couple()
void best(Team& team, Script& script, const TermsOf& terms_of, ViewChoice choice, double ramp);

}  // namespace sightline
