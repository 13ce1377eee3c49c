#include "sightline/scenario/keys_without_effect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <variant>

#include "sightline/model/state_roles.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/read_safety.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {
namespace {

/// What the robots of a scenario can respond to.
struct Takers {
  int pushed = 0;  // number of robots that an acceleration moves
  bool yaws = false, rolls = false, climbs = false, turns = false;
};

Takers takers_of(const Scenario& scenario) {
  Takers all;
  const Team& team = scenario.team;
  for (const Agent& agent : team.agents()) {
    const Model& model = agent.model;
    all.pushed += vehicle_of(scenario, team.find(agent.name)) != nullptr || takes_push(model) ? 1 : 0;
    all.yaws = all.yaws || yaw_input(model) >= 0;
    all.rolls = all.rolls || model.rolls();
    all.climbs = all.climbs || has_height(model);
    all.turns = all.turns || model.turns();
  }
  return all;
}

class Sentences {
 public:
  void add(bool stated, bool taken, std::string_view key, std::string_view why) {
    if (stated && !taken) all.push_back(fmt::format("{} has no effect: {}", key, why));
  }
  std::vector<std::string> all;
};

void look_at_disturbances(const Scenario& scenario, const Takers& takers, Sentences& to) {
  const Disturbances& d = scenario.simulation.disturbances;
  const std::string at = "simulation.disturbance.";
  constexpr std::string_view no_push = "no robot has an acceleration of G in the rate of a state",
                             no_heading = "no robot turns";
  const bool any = takers.pushed > 0;
  to.add(norm(d.wind) > 0, any, at + "wind", no_push);
  to.add(d.gust_sigma > 0, any, at + "gust", no_push);
  to.add(d.airflow.amplitude > 0, any && scenario.team.agents().size() > 1, at + "airflow",
         any ? "one robot alone is in no wake" : no_push);
  to.add(d.yaw_lag > 0, takers.yaws, at + "yaw_lag", "no robot has one input that turns it");
  to.add(d.slip > 0, takers.rolls, at + "slip", "no robot has wheels");
  to.add(d.noise.heading > 0, takers.turns, at + "noise.heading", no_heading);
  to.add(d.odometry.heading_bias > 0 || d.odometry.heading_walk > 0, takers.turns,
         at + "odometry.heading_bias, heading_walk", no_heading);
  for (const TeamEvent& event : scenario.script.events) {
    const bool blows = std::any_of(event.actions.begin(), event.actions.end(), [](const Action& action) {
      return std::holds_alternative<SetWind>(action);
    });
    to.add(blows, any, fmt::format("wind of the event \"{}\"", event.name), no_push);
  }
}

/// The keys in the text of a scenario.
class Keys {
 public:
  Keys(const Scenario& scenario, Sentences& to)
      : document_(parse_toml(scenario.text, scenario.file.native())), to_(to) {}

  bool states(std::string_view path) const { return static_cast<bool>(document_.root.at_path(path)); }
  /// Adds a sentence for a key that is stated and not used.
  void look(std::string_view path, bool taken, std::string_view why) const {
    to_.add(states(path), taken, path, why);
  }

 private:
  TomlDocument document_;
  Sentences& to_;
};

/// Keys that need another key; skipped with [campaign], which may vary that key.
void look_at_switches(const Scenario& scenario, const Keys& keys) {
  if (keys.states("campaign")) return;
  const Disturbances& d = scenario.simulation.disturbances;
  keys.look("simulation.disturbance.gust.time",
            d.gust_sigma > 0 || keys.states("simulation.disturbance.gust.sigma"),
            "there are no gusts without a sigma");
  keys.look("simulation.disturbance.airflow.distance",
            d.airflow.amplitude > 0 || keys.states("simulation.disturbance.airflow.amplitude"),
            "there is no airflow without an amplitude");
  keys.look("estimate", !scenario.localization.robots.empty(), "no robot is localized by vision");
}

void look_at_safety(const Scenario& scenario, const Takers& takers, const Keys& keys) {
  if (!scenario.safety) return;
  const bool filters = scenario.safety->barrier != BarrierMode::off;
  for (const char* bound : {"safety.floor", "safety.ceiling"})
    keys.look(bound, takers.climbs, "no robot leaves its height");
  for (const char* margin : {"safety.margin", "safety.wall_margin", "safety.residual_acceleration"})
    keys.look(margin, filters, "the barrier is off");
  for (const char* sigma : {"safety.position_sigma", "safety.heading_sigma"})
    keys.look(sigma, filters || scenario.safety->supervisor,
              "the barrier is off, and there is no supervisor");
  keys.look("safety.search", !scenario.localization.robots.empty(), "no robot is localized by vision");
}

}  // namespace

std::vector<std::string> keys_without_effect(const Scenario& scenario) {
  const Takers takers = takers_of(scenario);
  Sentences sentences;
  look_at_disturbances(scenario, takers, sentences);
  const Keys keys(scenario, sentences);
  look_at_safety(scenario, takers, keys);
  look_at_switches(scenario, keys);
  return sentences.all;
}

}  // namespace sightline
