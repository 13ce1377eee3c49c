#include "sightline/scenario/starts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <variant>

#include "sightline/scenario/reach.hpp"
#include "sightline/scenario/read_safety.hpp"

namespace sightline {
namespace {

constexpr double one_place = 0.05;  // least distance of bodies without a distance limit [m]

struct Start {
  BodyId body;
  Vec3<double> p;
  const TeamEvent* joins = nullptr;  // event that adds a body that is absent at first
};

std::vector<Start> starts_of(const Scenario& scenario) {
  std::map<int, const TeamEvent*> adding;
  for (const TeamEvent& event : scenario.script.events) {
    for (const Action& action : event.actions) {
      if (const auto* add = std::get_if<AddBody>(&action)) adding.try_emplace(add->body.index, &event);
    }
  }
  const Team& team = scenario.team;
  std::vector<Start> starts;
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    const bool absent = is_absent_at_start(scenario, body);
    const auto event = adding.find(i);
    if (absent && event == adding.end()) continue;
    starts.push_back({body, sight_at_start(scenario, body).p, absent ? event->second : nullptr});
  }
  return starts;
}

std::string when(const Start& start) {
  if (start.joins == nullptr) return "starts";
  return start.joins->name.empty() ? "joins by an event"
                                   : fmt::format("joins by the event \"{}\"", start.joins->name);
}

/// Adds a sentence for each wall that a robot's start violates.
void add_walls(const Scenario& scenario, const Start& start, std::vector<std::string>& to) {
  const BarrierOptions& room = scenario.safety->barrier_options;
  const std::string who = fmt::format("{} {} at ({:.3g}, {:.3g}, {:.3g}) m", scenario.team.name(start.body),
                                      when(start), start.p.x, start.p.y, start.p.z);
  constexpr std::size_t height = 2;
  if (reach_of(scenario.team.model(start.body))[height]) {
    if (start.p.z < room.floor) {
      to.push_back(
          fmt::format("{}, {:.3g} m below the floor = {:.3g} m: start it above, or lower safety.floor", who,
                      room.floor - start.p.z, room.floor));
    }
    if (start.p.z > room.ceiling) {
      to.push_back(
          fmt::format("{}, {:.3g} m above the ceiling = {:.3g} m: start it below, or raise safety.ceiling",
                      who, start.p.z - room.ceiling, room.ceiling));
    }
  }
  const double out = std::max(std::fabs(start.p.x), std::fabs(start.p.y)) - scenario.safety->world;
  if (out > 0) {
    to.push_back(
        fmt::format("{}, {:.3g} m outside the world of {:.3g} m: start it within, or raise safety.world", who,
                    out, scenario.safety->world));
  }
}

}  // namespace

bool is_absent_at_start(const Scenario& scenario, BodyId body) {
  return at(body) < scenario.presence.size() && scenario.presence[at(body)] == Presence::absent;
}

Sight<double> sight_at_start(const Scenario& scenario, BodyId body) {
  const Model& model = scenario.team.model(body);
  const std::vector<double> rest(size(model.nu()));
  return model.sight(scenario.x0.data() + scenario.team.state_offset(body), rest.data());
}

std::vector<std::string> warnings_of_starts(const Scenario& scenario) {
  const Team& team = scenario.team;
  const std::vector<Start> starts = starts_of(scenario);
  std::vector<std::string> sentences;
  if (scenario.safety && scenario.safety->start_outside) return sentences;  // intended
  for (const Start& start : starts) {
    if (scenario.safety && team.is_agent(start.body)) add_walls(scenario, start, sentences);
  }
  for (std::size_t i = 0; i < starts.size(); ++i) {
    for (std::size_t j = i + 1; j < starts.size(); ++j) {
      const bool j_joins = starts[j].joins != nullptr;
      const Start &a = starts[j_joins ? j : i], &b = starts[j_joins ? i : j];
      if (!team.is_agent(a.body) && !team.is_agent(b.body)) continue;
      const std::optional<double> d_hard = hard_distance(scenario, a.body, b.body);
      const double distance = norm(a.p - b.p), least = d_hard.value_or(one_place);
      if (distance >= least) continue;
      sentences.push_back(
          fmt::format("{} {} {:.3g} m from the start of {}, nearer than {} = {:.3g} m: {}", team.name(a.body),
                      when(a), distance, team.name(b.body), d_hard ? "d_hard" : "one place", least,
                      a.joins != nullptr ? "start it elsewhere, or let the other be gone by then"
                                         : "start them farther apart"));
    }
  }
  return sentences;
}

}  // namespace sightline
