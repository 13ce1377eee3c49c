#include "sightline/analysis/observation.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <set>
#include <span>

#include "sightline/analysis/flow.hpp"
#include "sightline/potentials.hpp"

namespace sightline {
namespace {

constexpr double position_weight = 1.6;  // of a held position, near the paper's, (63)

bool is_view(const Team& team, const Coupling& c) {
  return c.term.potential.mount() != nullptr && team.is_agent(c.between.first) &&
         team.is_agent(c.between.second) && c.term.weight * c.ramp.to > 0;
}

/// Cycles of a graph by depth-first search: one for each back edge.
class CycleSearch {
 public:
  explicit CycleSearch(const Team& team)
      : seen_(static_cast<std::size_t>(team.bodies())), next_(seen_.size()) {
    for (const Coupling& c : team.couplings()) {
      auto& of = next_[at(c.between.first)];
      if (is_view(team, c) && std::find(of.begin(), of.end(), c.between.second.index) == of.end())
        of.push_back(c.between.second.index);
    }
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      if (seen_[i] == Seen::never) go_down(static_cast<int>(i));
    }
  }

  std::set<std::vector<int>> found{};

 private:
  enum class Seen { never, on_the_way, done };

  void go_down(int from) {
    // Each body of the path with the index of its next edge.
    std::vector<std::pair<int, std::size_t>> way = {{from, 0}};
    seen_[static_cast<std::size_t>(from)] = Seen::on_the_way;
    while (!way.empty()) {
      auto& [at, edge] = way.back();
      const auto& next = next_[static_cast<std::size_t>(at)];
      if (edge == next.size()) {
        seen_[static_cast<std::size_t>(at)] = Seen::done;
        way.pop_back();
        continue;
      }
      const int to = next[edge++];
      Seen& seen = seen_[static_cast<std::size_t>(to)];
      if (seen == Seen::on_the_way) close(way, to);
      if (seen != Seen::never) continue;
      seen = Seen::on_the_way;
      way.emplace_back(to, 0);
    }
  }

  void close(const std::vector<std::pair<int, std::size_t>>& way, int to) {
    std::vector<int> cycle;
    for (const auto& [body, edge] : way) {
      if (body == to || !cycle.empty()) cycle.push_back(body);
    }
    std::rotate(cycle.begin(), std::min_element(cycle.begin(), cycle.end()), cycle.end());
    found.insert(std::move(cycle));
  }

  std::vector<Seen> seen_;
  std::vector<std::vector<int>> next_;
};

/// A copy of the team with changed couplings.
template <class Change>
Team changed(const Team& team, Change&& change) {
  Team other;
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    if (team.is_agent(body)) {
      other.add(team.agent(body));
    } else {
      other.add(Obstacle{std::string(team.name(body))});
    }
  }
  for (Coupling c : team.couplings()) {
    change(c);
    other.couple(std::move(c));
  }
  for (const Constraint& c : team.constraints()) other.constrain(c);
  return other;
}

/// Robots of a cycle in their team; all other robots stay at their starts.
struct CycleInTeam {
  const Team& team;
  std::span<const double> x0;
  const std::vector<AgentId>& robots;

  bool has(BodyId body) const { return std::find(robots.begin(), robots.end(), body) != robots.end(); }
  std::optional<Vec3<double>> drift(const Team& of) const { return flow_of(of, x0, robots).settle().drift; }
};

/// Changes that bring a cycle to rest, among those that take a user one line.
std::vector<std::string> maneuvers(const CycleInTeam& cycle) {
  const Team& team = cycle.team;
  std::vector<std::string> ways;
  const Team level = changed(team, [&](Coupling& c) {
    const SensorMount* mount = c.term.potential.mount();
    if (mount == nullptr || !cycle.has(c.between.first) || !cycle.has(c.between.second)) return;
    SensorMount straight = *mount;
    straight.pitch = 0.0;
    c.term.potential = c.term.potential.seen_from(straight);
  });
  if (!cycle.drift(level)) ways.emplace_back("level their sensors (sensor.pitch = 0)");

  const AgentId held = cycle.robots.front();
  const std::vector<double> none(static_cast<std::size_t>(team.nu()), 0.0);
  const Vec3<double> p = team.model(held).sight(cycle.x0.data() + team.state_offset(held), none.data()).p;
  Flow holding = flow_of(team, cycle.x0, cycle.robots);
  holding.add({at(held), p, {position_weight, position_weight, position_weight}});
  if (!holding.settle().drift) {
    ways.push_back(
        fmt::format("hold the place of {} (weights of its position in Q, and a reference)", team.name(held)));
  }

  Team banded = changed(team, [](Coupling&) {});
  for (const AgentId robot : cycle.robots) {
    banded.constrain(1.0 * AltitudeBand{.z_min = p.z - 0.5, .z_max = p.z + 0.5}, robot);
  }
  if (!cycle.drift(banded)) ways.emplace_back("constrain each by an altitude_band");
  return ways;
}

/// A team that events can produce from a scenario's.
struct Possible {
  ActiveTeam active_team;
  std::set<std::size_t> occurred{};
  std::vector<std::string> stages;
  std::vector<std::string> names{};  // of the events that lead to it

  auto key() const { return std::pair(occurred, stages); }
};

bool is_armed(const TeamEvent& event, const std::vector<std::string>& stages) {
  return event.stage.empty() || std::find(stages.begin(), stages.end(), event.stage) != stages.end();
}

/// Whether a choice triggers the event; such an event closes no cycle (ViewChoice).
bool is_chosen(const TeamEvent& event) {
  const auto* condition = std::get_if<Condition>(&event.trigger);
  return condition != nullptr && std::holds_alternative<TurnedTo>(condition->measure);
}

/// Whether another timed event must occur first.
bool waits(const Script& script, const Possible& at, std::size_t event) {
  const auto* time = std::get_if<AtTime>(&script.events[event].trigger);
  if (time == nullptr) return false;
  for (std::size_t i = 0; i < script.events.size(); ++i) {
    const auto* other = std::get_if<AtTime>(&script.events[i].trigger);
    if (other != nullptr && other->t < time->t && !at.occurred.contains(i) &&
        is_armed(script.events[i], at.stages))
      return true;
  }
  return false;
}

Possible after(const Script& script, const Possible& before, std::size_t number) {
  const TeamEvent& event = script.events[number];
  Possible next = before;
  const auto t = static_cast<double>(next.names.size() + 1);  // weights change at once, so any
                                                              // increasing time serves
  for (const Action& action : event.actions) (void)next.active_team.apply(action, t, 0.0);
  next.occurred.insert(number);
  next.names.push_back(event.name.empty() ? fmt::format("event[{}]", number)
                                          : fmt::format("the event \"{}\"", event.name));
  if (event.enter.empty()) return next;
  for (std::string& stage : next.stages) {
    if (region_of(stage) == region_of(event.enter)) stage = event.enter;
  }
  std::erase_if(next.occurred, [&](std::size_t i) { return script.events[i].stage == event.enter; });
  return next;
}

/// Adds the cycles of a team that are new; ids are those of the scenario.
void collect(const Scenario& scenario, const Possible& at, std::vector<ObservationCycle>& cycles) {
  const Team team = at.active_team.team(static_cast<double>(at.names.size() + 1));
  std::vector<double> x0;
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i}, original = scenario.team.find(team.name(body));
    const double* x = scenario.x0.data() + scenario.team.state_offset(original);
    if (team.is_agent(body) || !scenario.team.is_agent(original)) {
      x0.insert(x0.end(), x, x + team.model(body).nx());
      continue;
    }
    const std::vector<double> none(static_cast<std::size_t>(scenario.team.nu()), 0.0);
    const Vec3<double> p = scenario.team.model(original).sight(x, none.data()).p;  // holds or lands
    x0.insert(x0.end(), {p.x, p.y, p.z, 0.0, 0.0, 0.0});
  }
  if (CycleSearch(team).found.empty()) return;
  for (ObservationCycle& cycle : observation_cycles(team, x0)) {
    for (AgentId& robot : cycle.robots) robot = AgentId{scenario.team.find(team.name(robot))};
    const bool known = std::any_of(cycles.begin(), cycles.end(), [&](const ObservationCycle& other) {
      return other.robots == cycle.robots && (norm(other.drift) > 0 || norm(cycle.drift) == 0);
    });
    if (known) continue;
    cycle.after = fmt::format("{}", fmt::join(at.names, ", then "));
    cycles.push_back(std::move(cycle));
  }
}

}  // namespace

std::vector<ObservationCycle> observation_cycles(const Team& team, std::span<const double> x0) {
  const auto found_cycles = CycleSearch(team).found;
  std::vector<ObservationCycle> cycles;
  if (found_cycles.empty()) return cycles;
  for (const std::vector<int>& found : found_cycles) {
    ObservationCycle& cycle = cycles.emplace_back();
    for (const int body : found) cycle.robots.push_back(AgentId{BodyId{body}});
    const CycleInTeam in_team = {team, x0, cycle.robots};
    const auto drift = in_team.drift(team);
    if (!drift) continue;
    cycle.drift = *drift;
    cycle.maneuvers = maneuvers(in_team);
  }
  return cycles;
}

std::vector<ObservationCycle> observation_cycles(const Scenario& scenario) {
  std::vector<ObservationCycle> cycles;
  std::deque<Possible> open = {{ActiveTeam(scenario.team, scenario.presence), {}, scenario.script.begins}};
  std::set<std::pair<std::set<std::size_t>, std::vector<std::string>>> met = {open.front().key()};
  for (; !open.empty(); open.pop_front()) {
    const Possible& at = open.front();
    collect(scenario, at, cycles);
    for (std::size_t i = 0; i < scenario.script.events.size() && met.size() < teams_max; ++i) {
      const TeamEvent& event = scenario.script.events[i];
      if (!is_armed(event, at.stages) || (at.occurred.contains(i) && !event.repeat) || is_chosen(event) ||
          waits(scenario.script, at, i))
        continue;
      Possible next = after(scenario.script, at, i);
      if (met.insert(next.key()).second) open.push_back(std::move(next));
    }
  }
  return cycles;
}

std::string to_string(const ObservationCycle& cycle, const Team& team) {
  std::string text;
  for (std::size_t i = 0; i < cycle.robots.size(); ++i) {
    text += fmt::format("{}{} observes {}", i > 0 ? ", " : "", team.name(cycle.robots[i]),
                        team.name(cycle.robots[(i + 1) % cycle.robots.size()]));
  }
  if (!cycle.after.empty()) text += fmt::format(" after {}", cycle.after);
  const Vec3<double>& d = cycle.drift;
  if (norm(d) == 0) return text + ": a cycle that comes to rest";
  const bool upright = std::fabs(d.z) > norm(d.x, d.y);
  text += fmt::format(": no rest suits all, they {} together for ever", !upright  ? "wander"
                                                                        : d.z > 0 ? "climb"
                                                                                  : "sink");
  if (cycle.maneuvers.empty()) return text + "; let one of them observe a body outside the cycle";
  return text + fmt::format("; {}", fmt::join(cycle.maneuvers, ", or "));
}

}  // namespace sightline
