#include "sightline/scenario/read_safety.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sightline/base/polygon.hpp"
#include "sightline/run/steady_state.hpp"
#include "sightline/safety/authority.hpp"
#include "sightline/safety/zone.hpp"
#include "sightline/scenario/read_part.hpp"

namespace sightline {
namespace {

SupervisorOptions read_supervisor(const TomlTable& at) {
  SupervisorOptions o;
  const LadderTimes& times = o.times;
  read_keys(at, {}, o.times, o.sigmas, o, o.limits);
  const auto rising = [&](std::string_view key, double value, std::string_view below, double than) {
    if (value < than) at.throw_invalid(key, fmt::format(">= {} = {} s", below, than));
  };
  rising("slow_after", times.slow_after, "fresh", times.fresh);
  rising("hold_after", times.hold_after, "slow_after", times.slow_after);
  rising("land_after", times.land_after, "hold_after", times.hold_after);
  if (o.sigmas.land <= o.sigmas.hold)
    at.throw_invalid("sigma_land", fmt::format("> sigma_hold = {} m", o.sigmas.hold));
  return o;
}

Zone read_zone(const TomlTable& at) {
  at.expect_only(parameter_keys<Zone>());
  Zone zone;
  for (const std::vector<double>& corner : at.rows("polygon", TomlTable::any_length, 2))
    zone.polygon.push_back({corner[0], corner[1]});
  if (zone.polygon.size() > Zone::most_corners)
    at.throw_invalid("polygon", fmt::format("at most {} corners", Zone::most_corners));
  if (const std::string expected = expected_of_corners(zone.polygon); !expected.empty())
    at.throw_invalid("polygon", expected);
  if (at.has("from")) zone.from = at.number("from");
  if (at.has("to")) zone.to = at.number("to");
  if (zone.from >= zone.to) at.throw_invalid("to", fmt::format("> from = {} m", zone.from));
  zone.keep = at.word("keep", Zone::sides) == Zone::sides[0] ? Zone::Keep::inside : Zone::Keep::outside;
  return zone;
}

std::vector<Zone> read_zones(const TomlTable& safety) {
  constexpr std::size_t most = 16;
  std::vector<Zone> zones;
  for (const TomlTable& at : safety.tables("zone")) zones.push_back(read_zone(at));
  if (zones.size() > most) safety.throw_invalid("zone", fmt::format("at most {} zones", most));
  return zones;
}

using ReadFault = void (*)(const TomlTable& at, const Team& team, Fault& fault);

void read_probability(const TomlTable& at, Fault& fault) {
  if (at.has("probability")) fault.probability = at.number("probability", {0.0, 1.0, "0 to 1"});
}

void read_dropout(const TomlTable& at, const Team&, Fault& fault) {
  at.expect_only({"kind", "body", "from", "until", "probability"});
  read_probability(at, fault);
}

void read_delay(const TomlTable& at, const Team&, Fault& fault) {
  at.expect_only({"kind", "body", "from", "until", "delay"});
  fault.delay = at.number("delay", {0.0, longest_fault_delay, "0 to 10 s"});
}

void read_freeze(const TomlTable& at, const Team&, Fault&) {
  at.expect_only({"kind", "body", "from", "until"});
}

void read_nan(const TomlTable& at, const Team& team, Fault& fault) {
  at.expect_only({"kind", "body", "from", "until", "probability", "state"});
  read_probability(at, fault);
  if (!at.has("state")) return;
  if (fault.body.index < 0) at.throw_invalid("state", "no such key without a body");
  const auto states = team.model(fault.body).states();
  const std::string_view name = at.word("state", states);
  fault.number = static_cast<int>(std::find(states.begin(), states.end(), name) - states.begin());
}

void read_jump(const TomlTable& at, const Team&, Fault& fault) {
  at.expect_only({"kind", "body", "from", "until", "probability", "offset"});
  read_probability(at, fault);
  fault.offset = at.vec3("offset");
}

constexpr std::string_view late_plan = "late_plan";

/// Every kind of measurement fault, in the order of FaultKind.
constexpr std::array kinds = {Named<ReadFault>{"dropout", read_dropout},
                              Named<ReadFault>{"delay", read_delay}, Named<ReadFault>{"freeze", read_freeze},
                              Named<ReadFault>{"nan", read_nan}, Named<ReadFault>{"jump", read_jump}};

template <class Timed>
void read_window(const TomlTable& at, Timed& fault) {
  if (at.has("from")) fault.from = at.number("from", time_range);
  if (at.has("until")) fault.until = at.number("until", time_range);
  if (fault.until <= fault.from) at.throw_invalid("until", fmt::format("> from = {} s", fault.from));
}

LatePlan read_late_plan(const TomlTable& at) {
  at.expect_only({"kind", "from", "until", "delay"});
  LatePlan late;
  read_window(at, late);
  late.delay = at.number("delay", {0.0, longest_fault_delay, "0 to 10 s"});
  return late;
}

std::string window(double from, double until) {
  return until < largest_number ? fmt::format("from {} to {} s", from, until)
                                : fmt::format("from {} s on", from);
}

}  // namespace

std::optional<Safety> read_safety(const TomlTable& root, const Disturbances& disturbances) {
  if (!root.has("safety")) return std::nullopt;
  const TomlTable at = root.table("safety");
  Safety safety{.position_sigma = disturbances.noise.position, .heading_sigma = disturbances.noise.heading};
  BarrierOptions& barrier = safety.barrier_options;
  read_keys(at, {"supervisor", "search", "zone"}, safety, barrier);
  if (barrier.ceiling <= barrier.floor)
    at.throw_invalid("ceiling", fmt::format("> floor = {} m", barrier.floor));
  barrier.world = safety.world;
  barrier.zones = read_zones(at);
  const bool all = safety.barrier != BarrierMode::off;
  if (all || at.has("floor")) safety.judged.floor = barrier.floor;
  if (all || at.has("ceiling")) safety.judged.ceiling = barrier.ceiling;
  if (all || at.has("world")) safety.judged.world = safety.world;
  if (at.has("start_outside")) safety.start_outside = at.boolean("start_outside");
  if (at.has("supervisor")) {
    safety.supervisor = read_supervisor(at.table("supervisor"));
    TrackLimits& limits = safety.supervisor->limits;
    limits.world = safety.world;
    limits.position_sigma = safety.position_sigma;
    limits.heading_sigma = safety.heading_sigma;
  }
  if (at.has("search")) safety.search = read_part<SearchOptions>(TableSource(at.table("search")));
  return safety;
}

void check_starts(const TomlTable& root, const ScenarioSpec& scenario) {
  if (!scenario.safety || root.has("campaign")) return;  // a campaign draws starts
  const Team& team = scenario.team;
  const std::vector<Zone>& zones = scenario.safety->barrier_options.zones;
  const Walls& walls = scenario.safety->judged;
  const std::vector<double> u(static_cast<std::size_t>(team.nu()));
  const auto place = [&](BodyId body) {
    return team.model(body).sight(scenario.x0.data() + team.state_offset(body), u.data()).p;
  };
  bool outside = false;
  for (std::size_t k = 0; k < zones.size(); ++k) {
    for (const Agent& agent : team.agents()) {
      const double reserve = zone_reserve(zones[k], place(team.find(agent.name)));
      outside = outside || reserve < 0;
      if (reserve >= 0 || scenario.safety->start_outside) continue;
      const TomlTable start = root.table("agent").table(agent.name).table("start");
      start.throw_invalid(
          start.has("state") ? "state" : "p",
          fmt::format("a place {} safety.zone[{}], {:.3g} m from this one, or safety.start_outside = true",
                      to_string(zones[k].keep), k, -reserve));
    }
  }
  if (outside || !scenario.safety->start_outside) return;
  for (int i = 0; i < team.bodies(); ++i) {
    const Vec3<double> p = place(BodyId{i});
    const bool beyond =
        p.z < walls.floor || p.z > walls.ceiling || std::max(std::abs(p.x), std::abs(p.y)) > walls.world;
    if (team.is_agent(BodyId{i}) && beyond) return;
    for (int j = 0; j < i; ++j) {
      const auto d_hard = hard_distance(scenario, BodyId{j}, BodyId{i});
      if (d_hard && norm(p - place(BodyId{j})) < *d_hard) return;
    }
  }
  root.table("safety").throw_invalid(
      "start_outside",
      "no such key where every start is within the walls and zones that are judged and keeps d_hard");
}

void read_faults(const TomlTable& simulation, const Team& team, Simulation& to) {
  std::vector<std::string_view> bodies;
  for (int i = 0; i < team.bodies(); ++i) bodies.push_back(team.name(BodyId{i}));
  for (const TomlTable& at : simulation.tables("fault")) {
    auto known = std::vector<std::string_view>{late_plan};
    for (const auto& kind : kinds) known.push_back(kind.name);
    const std::string_view name = at.word("kind", known);
    if (name == late_plan) {
      to.late_plans.push_back(read_late_plan(at));
      continue;
    }
    Fault fault;
    const auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.name == name; });
    fault.kind = static_cast<FaultKind>(kind - kinds.begin());
    if (at.has("body")) fault.body = team.find(at.word("body", bodies));
    read_window(at, fault);
    kind->read(at, team, fault);
    to.faults.push_back(fault);
  }
}

namespace {

/// Authority of a robot; none if the barrier does not support it.
std::optional<Authority> ability(const Agent& agent) {
  try {
    return authority_of(agent.model, agent.limits.u_min().front(), agent.limits.u_max().front());
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

}  // namespace

std::vector<RobotSpeed> uncooperative_robots(const ScenarioSpec& scenario) {
  std::vector<RobotSpeed> robots;
  if (!scenario.safety || scenario.safety->barrier == BarrierMode::off) return robots;
  const Team& team = scenario.team;
  if (team.agents().size() < 2) return robots;
  struct Flown {
    std::string_view model;
    std::vector<double> probe;
    const Agent* agent;
    std::vector<double> low, high;
    std::optional<double> top{};
  };
  std::vector<Flown> flown;
  std::vector<std::size_t> of;  // [robot]: its place in `flown`
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    if (!team.is_agent(body)) continue;
    // Limits of the whole flight, including those that events set.
    const Agent& agent = team.agent(body);
    std::vector<double> low = agent.limits.u_min().front(), high = agent.limits.u_max().front();
    const auto widen = [&](const InputLimits& limits) {
      for (std::size_t k = 0; k < limits.times().size(); ++k) {
        for (std::size_t j = 0; j < low.size(); ++j) {
          low[j] = std::min(low[j], limits.u_min()[k][j]);
          high[j] = std::max(high[j], limits.u_max()[k][j]);
        }
      }
    };
    widen(agent.limits);
    for (const TeamEvent& event : scenario.script.events) {
      for (const Action& action : event.actions) {
        const auto* retune = std::get_if<RetuneAgent>(&action);
        if (retune != nullptr && retune->limits && retune->agent == body) widen(*retune->limits);
      }
    }
    // Most robots of a team are alike, and a simulation of each takes tens of milliseconds.
    std::vector<double> probe(static_cast<std::size_t>(agent.model.nx()));
    agent.model.f(state_at_rest(agent.model).data(), high.data(), probe.data());
    for (const std::vector<double>* bound : {&low, &high})
      probe.insert(probe.end(), bound->begin(), bound->end());
    const auto known = std::find_if(flown.begin(), flown.end(), [&](const Flown& one) {
      return one.model == agent.model.name() && one.probe == probe;
    });
    of.push_back(static_cast<std::size_t>(known - flown.begin()));
    if (known == flown.end())
      flown.push_back({agent.model.name(), std::move(probe), &agent, std::move(low), std::move(high)});
  }
  const std::optional<Authority> first = ability(*flown.front().agent);
  const auto moves_as_first = [&](const Flown& one) {
    const std::optional<Authority> can = ability(*one.agent);
    return one.model == flown.front().model && first && can && moves_alike(*first, *can);
  };
  const bool alike = std::all_of(flown.begin() + 1, flown.end(), moves_as_first);
  if (alike && (!first || (first->climb_lag == 0 && first->thrust_lag == 0))) return robots;
  for (std::size_t r = 0, i = 0; i < static_cast<std::size_t>(team.bodies()); ++i) {
    const BodyId body{static_cast<int>(i)};
    if (!team.is_agent(body)) continue;
    Flown& one = flown[of[r++]];
    if (!one.top) one.top = top_speed(one.agent->model, one.low, one.high);
    std::vector<double> u(one.low.size());
    const double at_start =
        norm(team.model(body).sight(scenario.x0.data() + team.state_offset(body), u.data()).v);
    robots.push_back({body, std::max(at_start, *one.top), !alike});
  }
  return robots;
}

std::vector<LimitsToCome> limits_to_come(const ScenarioSpec& scenario) {
  std::vector<LimitsToCome> limits;
  for (const TeamEvent& event : scenario.script.events) {
    for (const Action& action : event.actions) {
      const auto* retune = std::get_if<RetuneAgent>(&action);
      if (retune != nullptr && retune->limits) limits.push_back({retune->agent, *retune->limits});
    }
  }
  return limits;
}

std::optional<GuardOptions> guard_options(const ScenarioSpec& scenario) {
  const Safety safety = scenario.safety.value_or(Safety{});
  const bool searches = !scenario.localization.robots.empty();
  if (safety.barrier == BarrierMode::off && !safety.supervisor && !searches &&
      scenario.certified_views.empty())
    return std::nullopt;
  GuardOptions options{.supervisor = safety.supervisor,
                       .barrier = safety.barrier,
                       .barrier_options = safety.barrier_options,
                       .position_sigma = safety.position_sigma,
                       .period = scenario.horizon.dt,
                       .search = safety.search};
  // If a period exceeds the time in which the reserve may be used up, one period uses all of it,
  // not more.
  double& rate = options.barrier_options.rate;
  rate = std::min(rate, 1.0 / scenario.horizon.dt);
  if (options.supervisor) options.supervisor->period = scenario.horizon.dt;
  for (const LocalizedRobot& of : scenario.localization.robots) options.searchers.push_back(of.robot);
  options.bodies.resize(static_cast<std::size_t>(scenario.team.bodies()), {.d_hard = safety.d_hard});
  for (const RobotCompensation& of : scenario.compensations) {
    options.command_delays.resize(options.bodies.size());
    options.command_delays[static_cast<std::size_t>(of.robot.index)] = of.command_delay;
  }
  options.limits_to_come = limits_to_come(scenario);
  options.views = scenario.certified_views;
  // A robot that is not cooperative, since another moves differently, is as fast as its model
  // allows.
  for (const RobotSpeed& of : uncooperative_robots(scenario)) {
    if (of.counts && std::isfinite(of.speed))
      options.bodies[static_cast<std::size_t>(of.robot.index)].speed_max = of.speed;
  }
  for (const UncooperativeBody& uncooperative : scenario.uncooperative) {
    options.bodies[static_cast<std::size_t>(uncooperative.body.index)] = {
        uncooperative.d_hard.value_or(safety.d_hard), uncooperative.speed_max, uncooperative.robot};
  }
  return options;
}

std::optional<double> hard_distance(const ScenarioSpec& scenario, BodyId a, BodyId b) {
  const auto agents = static_cast<int>(scenario.team.agents().size());  // agents come first
  if (a.index >= agents && b.index >= agents) return std::nullopt;
  const int other = std::max(a.index, b.index);
  if (other >= agents) {
    const auto uncooperative =
        std::find_if(scenario.uncooperative.begin(), scenario.uncooperative.end(),
                     [&](const UncooperativeBody& s) { return s.body == BodyId{other}; });
    if (uncooperative != scenario.uncooperative.end() && uncooperative->d_hard) return uncooperative->d_hard;
  }
  if (!scenario.safety) return std::nullopt;
  return scenario.safety->d_hard;
}

double hold_after(const ScenarioSpec& scenario) {
  const bool supervised = scenario.safety && scenario.safety->supervisor;
  return supervised ? scenario.safety->supervisor->times.hold_after : LadderTimes{}.hold_after;
}

std::string describe(const Safety& safety) {
  constexpr std::array<std::string_view, 3> modes = {"off", "on", "only reports"};
  std::string text = fmt::format("safety      barrier {}, d_hard {} m, height {} to {} m, world {} m\n",
                                 modes[static_cast<std::size_t>(safety.barrier)], safety.d_hard,
                                 safety.barrier_options.floor, safety.barrier_options.ceiling, safety.world);
  for (const Zone& zone : safety.barrier_options.zones) {
    text += fmt::format("zone        keep {} {} corners{}{}\n", to_string(zone.keep), zone.polygon.size(),
                        zone.from > -infinity ? fmt::format(", from {} m", zone.from) : "",
                        zone.to < infinity ? fmt::format(", to {} m", zone.to) : "");
  }
  if (!safety.supervisor) return text;
  const LadderTimes& times = safety.supervisor->times;
  return text + fmt::format("supervisor  slow after {} s, hold after {} s, land after {} s\n",
                            times.slow_after, times.hold_after, times.land_after);
}

std::string describe(const Simulation& simulation, const Team& team) {
  std::string text;
  for (const Fault& fault : simulation.faults) {
    text += fmt::format("fault       {} of {}, {}\n", to_string(fault.kind),
                        fault.body.index < 0 ? "all bodies" : team.name(fault.body),
                        window(fault.from, fault.until));
  }
  for (const LatePlan& late : simulation.late_plans) {
    text += fmt::format("fault       plans {} s late, {}\n", late.delay, window(late.from, late.until));
  }
  return text;
}

}  // namespace sightline
