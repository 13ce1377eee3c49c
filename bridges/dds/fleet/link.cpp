#include "bridges/dds/fleet/link.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace sightline {
namespace {

std::string describe_poses(const PosesFrom& poses) {
  std::string words(pose_sources[static_cast<std::size_t>(poses.source)]);
  if (!poses.topic.empty()) words += fmt::format(" on {}", poses.topic);
  if (!poses.name.empty()) words += fmt::format(" of {}", poses.name);
  return words;
}

std::string describe_network(const FleetNetwork& network) {
  return fmt::format("fleet       domain {} on {}, {}{}; {} {}", network.domain,
                     fmt::join(network.interfaces, ", "),
                     network.multicast == Multicast::on
                         ? "by multicast"
                         : fmt::format("asks {}, no multicast", fmt::join(network.peers, ", ")),
                     network.keys.empty() ? "" : ", DDS security", network.node,
                     network.topics ? "shows the flight" : "shows nothing");
}

std::string describe_link(const Link& link, std::string_view name) {
  const std::string how = std::visit([](const auto& kind) { return kind.describe(); }, link.kind);
  const Vec3<double>& p = link.origin.p;
  std::string words = fmt::format("link        {}: {}, poses by {}", name, how, describe_poses(link.poses));
  words += link.poses.estimated() ? std::string(", motion by odometry")
                                  : fmt::format(", origin [{}, {}, {}] m", p.x, p.y, p.z);
  for (const std::string& topic : {link.goals.goal_topic, link.goals.path_topic})
    if (!topic.empty()) words += fmt::format(", goals on {}", topic);
  return words;
}

}  // namespace

std::string describe(const LinkFault& fault) {
  const LinkFaultText& text = text_of(fault.kind);
  std::string words(text.name);
  if (!text.size.empty()) words += fmt::format(" {}", fault.size);
  if (text.size == "s" || text.size == "m") words += fmt::format(" {}", text.size);
  if (std::isfinite(fault.duration)) words += fmt::format(" for {} s", fault.duration);
  return words + fmt::format(", {} s after {}", fault.at,
                             fault.since == FaultClock::start ? "the start" : "it is first steered");
}

std::string link_fault_table() {
  std::string table = "| `kind` | key | of | `size` | default | what happens |\n|---|---|---|---|---|---|\n";
  for (const LinkFaultText& text : link_faults) {
    const bool sized = !text.size.empty();
    table += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", text.name, text.key,
                         text.of.camera          ? "with a camera"
                         : text.of.kinds.empty() ? "all"
                                                 : fmt::format("`{}`", fmt::join(text.of.kinds, "`, `")),
                         sized ? fmt::format("{}, {}", text.size, text.bounds.words) : "",
                         sized ? fmt::format("{}", text.fallback) : "", text.meaning);
  }
  return table;
}

bool can_have(const Link& link, LinkFaultKind kind) {
  const FaultOf& of = text_of(kind).of;
  const bool by_kind =
      of.kinds.empty() || std::find(of.kinds.begin(), of.kinds.end(), link.kind_name()) != of.kinds.end();
  return by_kind && (link.has_camera || !of.camera);
}

std::string FleetPlan::describe(const Team& team) const {
  std::string all = describe_network(network);
  for (const Link& link : links) all += fmt::format("\n{}", describe_link(link, team.name(link.robot)));
  for (const LinkFault& fault : faults)
    all += fmt::format("\nfault       {}: {}", team.name(fault.robot), sightline::describe(fault));
  for (const BodyLink& link : bodies)
    all += fmt::format("\nlink        {}: poses by {}", team.name(link.body), describe_poses(link.poses));
  return all;
}

std::shared_ptr<const Links> FleetPlan::of_part(const ScenarioSpec& whole, const ScenarioSpec& part) const {
  const auto here = [&](BodyId body) { return part.team.find(whole.team.name(body)); };
  const auto elsewhere = [&](const auto& one) { return !part.team.is_agent(one.robot); };
  auto own = std::make_shared<FleetPlan>(*this);
  for (BodyLink& link : own->bodies) link.body = here(link.body);
  for (LinkFault& fault : own->faults) fault.robot = here(fault.robot);
  for (Link& link : own->links) {
    const Link of_whole = link;
    link.robot = here(link.robot);
    if (elsewhere(link)) own->bodies.push_back({.body = link.robot, .poses = link.poses, .robot = of_whole});
  }
  std::erase_if(own->links, elsewhere);
  std::erase_if(own->faults, elsewhere);
  own->network.node += "/" + part.partition->part;
  return own;
}

const FleetPlan& fleet_of(const ScenarioSpec& scenario) {
  const auto* const fleet = dynamic_cast<const FleetPlan*>(scenario.links.get());
  if (fleet == nullptr)
    throw std::invalid_argument("fleet is missing, expected a [fleet] with the links of the robots");
  return *fleet;
}

FleetPlan& own_fleet(ScenarioSpec& scenario) {
  auto own = std::make_shared<FleetPlan>(fleet_of(scenario));
  scenario.links = own;
  return *own;
}

}  // namespace sightline
