#include "sightline/scenario/keep_apart_parts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/scenario_parts.hpp"

namespace sightline {
namespace {

std::vector<AgentId> read_agents(const TomlTable& at, const Team& team) {
  std::vector<AgentId> agents;
  const TomlValue value = at.value("agents", "\"all\" or a list of names");
  if (value.is_text()) {
    if (value.text() != "all") value.refuse("\"all\" or a list of names");
    for (const Agent& agent : team.agents()) agents.push_back(AgentId{team.find(agent.name)});
    return agents;
  }
  const std::vector<std::string> names = at.texts("agents", TomlTable::any_length, "names");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const BodyId body = team.find(names[i]);
    if (body.index < 0 || !team.is_agent(body)) {
      std::vector<std::string_view> known;
      for (const Agent& agent : team.agents()) known.push_back(agent.name);
      at.refuse(
          "agents", i,
          fmt::format("a robot, the nearest is \"{}\"", nearest(shortened(names[i], name_size_max), known)));
    }
    if (std::find(agents.begin(), agents.end(), body) != agents.end())
      at.refuse("agents", i, "each robot once");
    agents.push_back(AgentId{body});
  }
  return agents;
}

}  // namespace

void read_keep_apart(const TomlTable& at, Team& team) {
  at.expect_only({"agents", "radius", "potential", "weight", "pairs_max"});
  const std::vector<AgentId> agents = read_agents(at, team);
  const double radius = at.has("radius") ? at.number("radius", positive("> 0 m")) : 2.5;
  const auto n = static_cast<std::int64_t>(agents.size());
  const std::int64_t all = std::max<std::int64_t>(1, n * (n - 1) / 2);
  const std::int64_t room = at.has("pairs_max") ? at.integer("pairs_max", 1, 20'000) : 2000;
  const Weighted term = read_potential(at, {std::string(team.agents()[0].name), {}});
  at.checked([&] { team.keep_apart(term, agents, radius, static_cast<int>(std::min(room, all))); });
}

}  // namespace sightline
