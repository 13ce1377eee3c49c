#include "sightline/scenario/read_link_fault.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "sightline/ocp/team.hpp"
#include "sightline/scenario/read_part.hpp"

namespace sightline {
namespace {

constexpr std::size_t link_faults_most = 1000;

std::vector<std::string_view> fault_names() {
  std::vector<std::string_view> names;
  for (const LinkFaultText& text : link_faults) names.push_back(text.name);
  return names;
}

LinkFault read_link_fault(const TomlTable& at, const Team& team, const FleetPlan& fleet) {
  at.expect_only({"robot", "kind", "since", "at", "duration", "size"});
  const std::vector<std::string_view> names = fault_names();
  LinkFault fault;
  const std::string robot = read_name(at, "robot", team, Among::robots, "the robot that has it");
  fault.robot = team.find(robot);
  const auto place = std::find(names.begin(), names.end(), at.word("kind", names)) - names.begin();
  fault.kind = static_cast<LinkFaultKind>(place);
  const LinkFaultText& text = text_of(fault.kind);
  const auto link = std::find_if(fleet.links.begin(), fleet.links.end(),
                                 [&](const Link& one) { return one.robot == fault.robot; });
  if (link != fleet.links.end() && !can_have(*link, fault.kind))
    at.throw_invalid("kind",
                     fmt::format("a fault of robots behind {}, {} is not", link->kind_name(), text.name));
  if (at.has("since") && at.word("since", fault_clocks) == fault_clocks[1]) fault.since = FaultClock::flight;
  constexpr Range seconds = {0.0, 1e6, "0 to 1e6 s"};
  fault.at = at.number("at", seconds);
  if (at.has("duration")) fault.duration = at.number("duration", {1e-3, 1e6, "0.001 to 1e6 s"});
  if (at.has("size") && text.size.empty())
    at.throw_invalid("size", fmt::format("no such key for {}", text.name));
  fault.size = text.fallback;
  if (at.has("size")) fault.size = TableSource(at).number("size", text.bounds, text.size);
  return fault;
}

}  // namespace

bool can_have(const Link& link, LinkFaultKind kind) {
  const FaultOf& of = text_of(kind).of;
  const std::array<bool, 3> by_kind = {of.px4, of.crazyswarm2, of.ros2};
  return by_kind[link.kind.index()] && (link.has_camera || !of.camera);
}

void read_link_faults(const TomlTable& at, const Team& team, FleetPlan& fleet) {
  const std::vector<TomlTable> tables = at.tables("fault");
  if (tables.size() > link_faults_most)
    at.throw_invalid("fault", fmt::format("at most {}", link_faults_most));
  for (const TomlTable& one : tables) fleet.faults.push_back(read_link_fault(one, team, fleet));
}

}  // namespace sightline
