#include "sightline/scenario/read_partition.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/read_part.hpp"

namespace sightline {
namespace {

constexpr std::string_view exchange_key = "exchange", part_key = "part";
constexpr std::size_t parts_max = 1024, part_name_max = 64;

/// Whether a name can be part of a topic.
bool is_part_name(std::string_view name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  return !name.empty() && name.size() <= part_name_max && letter(name[0]) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return letter(c) || (c >= '0' && c <= '9'); });
}

PlannedPart read_part_of(const TomlTable& at, const std::string& name, const Team& team,
                         std::vector<std::string_view>& missing) {
  if (!is_part_name(name) || name == PartitionPlan::all)
    at.throw_invalid(name,
                     fmt::format("a name of a part of letters, digits and _, at most {}, which is not \"{}\"",
                                 part_name_max, PartitionPlan::all));
  PlannedPart part{name, at.texts(name, TomlTable::any_length, "robots by name")};
  for (std::size_t i = 0; i < part.robots.size(); ++i) {
    const auto found = std::find(missing.begin(), missing.end(), part.robots[i]);
    if (found != missing.end()) {
      missing.erase(found);
      continue;
    }
    const BodyId body = team.find(part.robots[i]);
    if (body.index >= 0 && team.is_agent(body)) at.throw_invalid(name, i, "a robot that no part has yet");
    at.throw_invalid(
        name, i, "a robot" + hint(shortened(part.robots[i], name_size_max), body_names(team, Among::robots)));
  }
  return part;
}

/// Maps the ids of bodies from one team to another, by name.
class Renumbered {
 public:
  Renumbered(const Team& from, const Team& to) : from_(from), to_(to) {}
  BodyId operator()(BodyId body) const { return body.index < 0 ? body : to_.find(from_.name(body)); }
  bool steers(BodyId body) const {
    const BodyId here = (*this)(body);
    return here.index >= 0 && to_.is_agent(here);
  }
  /// Keeps the entries of the part's own robots, with their ids in the part.
  template <class List, class Member>
  void keep_own(List& list, Member member) const {
    std::erase_if(list, [&](const auto& one) { return !steers(BodyId{one.*member}); });
    for (auto& one : list) {
      auto& id = one.*member;
      id = std::remove_reference_t<decltype(id)>{(*this)(BodyId{id})};
    }
  }
  /// Replaces the ids of bodies.
  template <class List, class Member>
  void rename(List& list, Member member) const {
    for (auto& one : list) one.*member = (*this)(one.*member);
  }

 private:
  const Team &from_, &to_;
};

/// Whether the coupling acts on a robot of the part.
bool is_felt_within(const Coupling& coupling, const Renumbered& here) {
  return std::any_of(coupling.felt_by.begin(), coupling.felt_by.end(),
                     [&](AgentId agent) { return here.steers(agent); });
}

bool follows_a_robot(const Motion& motion) {
  return std::visit(
      [](const auto& one) {
        return requires { one.agent; };
      },
      motion);
}

void check_flown_in_parts(const ScenarioSpec& whole) {
  const std::string& part = whole.partition->part;
  if (!whole.localization.robots.empty())
    throw_invalid(
        "partition.part = \"{}\" beside agent.{}.localization = vision, expected \"global\", or parts in one "
        "program: messages of parts carry no estimates",
        part, whole.team.name(whole.localization.robots.front().robot));
  for (const UncooperativeBody& body : whole.uncooperative)
    if (body.motion && follows_a_robot(*body.motion))
      throw_invalid(
          "partition.part = \"{}\" beside {}, whose motion is that of a robot, expected one of its own", part,
          whole.team.name(body.body));
}

}  // namespace

void read_partition(const TomlTable& root, ScenarioSpec& scenario) {
  if (!root.has("partition")) return;
  const TomlTable at = root.table("partition");
  PartitionPlan& plan = scenario.partition.emplace();
  std::vector<std::string_view> missing = body_names(scenario.team, Among::robots);
  for (const std::string& key : at.keys()) {
    if (key == exchange_key || key == part_key) continue;
    plan.parts.push_back(read_part_of(at, key, scenario.team, missing));
  }
  if (plan.parts.empty()) at.throw_invalid("a part, as front = [\"uav0\"]");
  if (plan.parts.size() > parts_max) at.throw_invalid(fmt::format("at most {} parts", parts_max));
  if (!missing.empty())
    at.throw_invalid(fmt::format("every robot in one part, {} is in none", missing.front()));
  plan.exchange = read_part<ExchangeOptions>(TableSource(at.table_or_empty(exchange_key)));
  plan.exchange.seed = scenario.simulation.seed;
  if (at.has(part_key)) {
    std::vector<std::string_view> names = {PartitionPlan::all};
    for (const PlannedPart& part : plan.parts) names.push_back(part.name);
    plan.part = at.word(part_key, names);
  }
  at.checked([&] {
    check_plans_in_parts(scenario, at.registry());
    for (const std::vector<AgentId>& part : partition_of(plan, scenario.team))
      (void)subteam_of(scenario.team, part);
    if (plan.apart()) scenario = part_of(scenario);
  });
}

void check_plans_in_parts(const ScenarioSpec& scenario, const Registry& registry) {
  if (!registry.solvers.named(scenario.solver.name).can.changing_teams)
    throw_invalid("the solver {} cannot plan a part, expected {}", scenario.solver.name,
                  registry.solvers.names_that(&SolverAbilities::changing_teams));
  if (changes_in_flight(scenario))
    throw_invalid("the team changes in flight, expected a scenario without events");
}

Partition partition_of(const PartitionPlan& plan, const Team& team) {
  Partition partition;
  for (const PlannedPart& part : plan.parts) {
    std::vector<AgentId>& robots = partition.emplace_back();
    for (const std::string& name : part.robots) robots.push_back(AgentId{team.find(name)});
  }
  return partition;
}

ScenarioSpec part_of(const ScenarioSpec& whole) {
  check_flown_in_parts(whole);
  const auto& parts = whole.partition->parts;
  const auto own = std::find_if(parts.begin(), parts.end(),
                                [&](const PlannedPart& part) { return part.name == whole.partition->part; });
  const auto place = static_cast<std::size_t>(own - parts.begin());
  ScenarioSpec part = whole;
  part.team = subteam_of(whole.team, partition_of(*whole.partition, whole.team)[place], Others::all);
  const Team& team = part.team;
  const Renumbered here(whole.team, team);

  part.coupling_places.clear();
  for (std::size_t c = 0; c < whole.team.couplings().size() && c < whole.coupling_places.size(); ++c)
    if (is_felt_within(whole.team.couplings()[c], here))
      part.coupling_places.push_back(whole.coupling_places[c]);
  for (BodyId& body : part.targets) body = here(body);
  for (BodyId& body : part.obstacles) body = here(body);
  here.rename(part.uncooperative, &UncooperativeBody::body);
  part.x0.assign(at(team.nx()), 0.0);
  part.presence.assign(at(team.bodies()), Presence::hold);
  for (int i = 0; i < whole.team.bodies(); ++i) {
    const BodyId from{i}, to = here(from);
    const double* const x = &whole.x0[at(whole.team.state_offset(from))];
    double* const of_part = &part.x0[at(team.state_offset(to))];
    part.presence[at(to.index)] = team.is_agent(to) ? Presence::steered : Presence::hold;
    if (team.is_agent(to) || !whole.team.is_agent(from)) {
      std::copy_n(x, team.model(to).nx(), of_part);
      continue;
    }
    const Agent& robot = whole.team.agent(from);
    write_body(robot.model.sight(x, robot.u_ref.data()), {of_part, at(team.model(to).nx())});
    part.obstacles.push_back(to);
    part.uncooperative.push_back({.body = to,
                                  .speed_max = whole.partition->exchange.speed_max,
                                  .robot = std::string(robot.model.name())});
  }
  here.keep_own(part.compensations, &RobotCompensation::robot);
  here.keep_own(part.certified_views, &CertifiedView::observer);
  here.rename(part.certified_views, &CertifiedView::target);
  here.keep_own(part.vehicles, &RobotVehicle::robot);
  here.keep_own(part.vision.cameras, &RobotCamera::observer);
  here.rename(part.vision.tags, &BodyTags::body);
  here.rename(part.vision.hulls, &BodyHull::body);
  here.rename(part.simulation.faults, &Fault::body);
  std::erase_if(part.simulation.faults, [&](const Fault& fault) {
    return fault.body.index >= 0 && fault.number >= team.model(fault.body).nx();
  });
  here.keep_own(part.goal_options, &GoalOptions::robot);
  if (part.links) part.links = part.links->of_part(whole, part);
  return part;
}

std::string describe(const PartitionPlan& plan) {
  std::string text;
  const ExchangeOptions& e = plan.exchange;
  for (const PlannedPart& part : plan.parts)
    text += fmt::format("part        {}: {}\n", part.name, fmt::join(part.robots, ", "));
  if (plan.part == PartitionPlan::all) return text + "exchange    none: one solver plans all\n";
  if (!plan.part.empty())
    return text + fmt::format("exchange    {} is planned here; a message counts for {} s\n", plan.part,
                              e.stale_after);
  return text + fmt::format("exchange    each period, after {} s{}, {} % lost{}; a message counts for {} s\n",
                            e.delay, e.jitter > 0 ? fmt::format(" to {} s", e.delay + e.jitter) : "",
                            100 * e.loss, e.offset != 0 ? fmt::format(", clocks {} s apart", e.offset) : "",
                            e.stale_after);
}

}  // namespace sightline
