#include "sightline/record/team_json.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "sightline/base/json_text.hpp"
#include "sightline/judge/present_team.hpp"
#include "sightline/scenario/read_safety.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

/// Couplings by pair of bodies with the bodies that they affect; each once.
Json couplings_json(const std::vector<Coupling>& couplings) {
  std::set<std::array<int, 4>> known;
  Json list = Json::array();
  for (const Coupling& c : couplings) {
    const auto feels = [&](BodyId body) {
      return std::any_of(c.felt_by.begin(), c.felt_by.end(), [&](AgentId agent) { return agent == body; });
    };
    const BodyId a = c.between.first, b = c.between.second;
    if (!known.insert({a.index, b.index, feels(a), feels(b)}).second) continue;
    list.push_back({{"between", {a.index, b.index}}, {"felt", {feels(a), feels(b)}}});
  }
  return list;
}

}  // namespace

std::string team_json(const Scenario& scenario) {
  const Team& team = scenario.team;
  Json json = {{"bodies", Json::array()},
               {"pairs", Json::array()},
               {"swarms", Json::array()},
               {"events", Json::array()}};
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    Json entry = {{"name", team.name(body)},
                  {"robot", team.model(body).name()},
                  {"kind", team.is_agent(body) ? "agent" : "obstacle"}};
    if (team.is_agent(body)) {
      const auto inputs = team.model(body).inputs();
      const InputLimits& limits = team.agent(body).limits;
      entry["inputs"] = std::vector<std::string>(inputs.begin(), inputs.end());
      entry["limits"] = {{"times", limits.times()}, {"u_min", limits.u_min()}, {"u_max", limits.u_max()}};
    }
    if (const BodyTags* its = scenario.vision.tags_of(body))
      entry["tags"] = {{"size", its->tags.size},
                       {"faces", its->tags.faces},
                       {"distance", its->tags.distance},
                       {"height", its->tags.height}};
    json["bodies"].push_back(std::move(entry));
  }
  const std::vector<Coupling> couplings = all_couplings(scenario);
  json["couplings"] = couplings_json(couplings);
  for (const Observation& pair : observations(couplings)) {
    json["pairs"].push_back({{"observer", pair.observer.index},
                             {"target", pair.target.index},
                             {"pitch", pair.mount.pitch},
                             {"offset", pair.mount.offset.x},
                             {"alpha", pair.alpha},
                             {"d_min", pair.d_min},
                             {"d_max", pair.d_max}});
    Json& written = json["pairs"].back();
    const LeverArm& arm = pair.mount.offset;
    if (!arm.is_along_x()) written["offset"] = {arm.x, arm.y, arm.z};
    if (pair.mount.yaw != 0) written["yaw"] = pair.mount.yaw;
    if (pair.mount.roll != 0) written["roll"] = pair.mount.roll;
    if (pair.mount.frame == MountFrame::body) written["frame"] = "body";
  }
  for (const Swarm& swarm : team.swarms()) {
    Json& robots = json["swarms"].emplace_back(Json::array());
    for (const AgentId agent : swarm.agents) robots.push_back(agent.index);
  }
  std::set<double> d_hard;
  for (int i = 0; i < team.bodies(); ++i) {
    for (int j = i + 1; j < team.bodies(); ++j) {
      if (const auto d = hard_distance(scenario, BodyId{i}, BodyId{j})) d_hard.insert(*d);
    }
  }
  if (!d_hard.empty()) json["d_hard"] = d_hard;
  if (scenario.safety) {
    const BarrierOptions& walls = scenario.safety->barrier_options;
    if (std::isfinite(walls.floor)) json["floor"] = walls.floor;
    if (std::isfinite(walls.ceiling)) json["ceiling"] = walls.ceiling;
    for (const Zone& zone : walls.zones) {
      Json& polygon = json["zones"].emplace_back(Json::array());
      for (const Vec2<double>& corner : zone.polygon) polygon.push_back({corner.x, corner.y});
    }
  }
  for (const TeamEvent& event : scenario.script.events) json["events"].push_back(event.name);
  return json_text(json);
}

}  // namespace sightline
