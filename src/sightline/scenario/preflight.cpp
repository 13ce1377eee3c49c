#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sightline/model/state_roles.hpp"
#include "sightline/potential/finite.hpp"
#include "sightline/safety/zone.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/keys_without_effect.hpp"
#include "sightline/scenario/reach.hpp"
#include "sightline/scenario/read_safety.hpp"
#include "sightline/scenario/read_view.hpp"
#include "sightline/scenario/starts.hpp"
#include "sightline/scenario/tag_size.hpp"

namespace sightline {
namespace {

/// Mean of the starts of all bodies.
Vec3<double> middle(const Scenario& scenario) {
  const Team& team = scenario.team;
  const std::vector<double> none(static_cast<std::size_t>(team.nu()) + 1, 0.0);
  Vec3<double> sum{};
  for (int i = 0; i < team.bodies(); ++i) {
    sum = sum + team.model(BodyId{i}).sight(scenario.x0.data() + team.state_offset(BodyId{i}), none.data()).p;
  }
  return (1.0 / team.bodies()) * sum;
}

/// Checks regions that are written as text.
class Regions {
 public:
  Regions(const Scenario& scenario, Preflight& to)
      : to_(to),
        search_{.until = scenario.simulation.duration + scenario.horizon.T,
                .period = scenario.horizon.dt,
                .centre = middle(scenario)} {}

  /// @param where  the file, with the line if known
  /// @param whole_flight  if false, the region is in force during an unknown part of the flight
  void look_at(const Potential& potential, std::string_view where, std::string_view who, bool whole_flight) {
    const std::optional<Rounding> rounding = potential.rounding();
    if (!rounding) return;
    if (!rounding->corners.empty()) {
      to_.remarks.push_back(fmt::format("{}: corners of {} are rounded off over {} (m, rad)", who,
                                        fmt::join(rounding->corners, ", "), rounding->width));
    }
    const auto spot = not_finite_at(potential, search_);
    if (!spot) return;
    const std::string what = fmt::format("{} is no finite number with {}", who, to_string(*spot));
    if (whole_flight || !spot->ends) {
      to_.refusals.push_back(
          fmt::format("{}: {}, expected one everywhere until {:.6g} s, the end of the last plan", where, what,
                      search_.until));
    } else {
      to_.warnings.push_back(what + ": let an event end it before");
    }
  }

 private:
  Preflight& to_;
  FiniteSearch search_;
};

void look_at_regions(const Scenario& scenario, Preflight& to) {
  Regions regions(scenario, to);
  const auto& script = scenario.script;
  const std::vector<Coupling> couplings = stated_couplings(scenario);
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    const bool of_file = i < scenario.team.couplings().size();
    const Potential& potential = couplings[i].term.potential;
    const std::string who = of_file ? fmt::format("couple[{}] {}", i, potential.name())
                                    : fmt::format("{} of an event", potential.name());
    const std::string& where = of_file ? scenario.coupling_places[i] : scenario.file.native();
    regions.look_at(potential, where, who, of_file && script.empty());
  }
  const auto& constraints = scenario.team.constraints();
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const Potential& potential = constraints[i].term.potential;
    regions.look_at(potential, scenario.file.native(), fmt::format("constrain[{}] {}", i, potential.name()),
                    script.empty());
  }
}

/// References at places where zones leave a robot no room.
std::vector<std::string> warnings_of_zones(const Scenario& scenario) {
  std::vector<std::string> sentences;
  if (!scenario.safety || scenario.safety->barrier_options.zones.empty()) return sentences;
  const BarrierOptions& safety = scenario.safety->barrier_options;
  constexpr double most_steps = 1e4;
  const double step = std::max(0.1, scenario.simulation.duration / most_steps);  // [s]
  for (const Agent& agent : scenario.team.agents()) {
    const StateRoles roles = roles_of(agent.model);
    const auto is_free = [&](int state) {
      return state >= 0 && agent.Q[static_cast<std::size_t>(state)] == 0;
    };
    const bool is_anywhere = std::any_of(roles.position.begin(), roles.position.end(), is_free);
    if (!roles.has_position() || is_anywhere) continue;
    std::vector<double> x_ref(static_cast<std::size_t>(agent.model.nx()));
    for (std::size_t k = 0; k < safety.zones.size(); ++k) {
      double least = infinity, at = 0.0;
      for (double t = 0.0; t <= scenario.simulation.duration; t += step) {
        agent.x_ref(t, agent.model, x_ref);
        const double reserve =
            zone_reserve(safety.zones[k], agent.model.sight(x_ref.data(), agent.u_ref.data()).p);
        if (reserve < least) least = reserve, at = t;
      }
      if (least < safety.wall_margin)
        sentences.push_back(
            fmt::format("safety.zone[{}] leaves no place for the reference of {} at {:.1f} s: {:.3g} m {} "
                        "it, wall_margin is {:.3g} m",
                        k, agent.name, at, std::abs(least),
                        (least < 0) == (safety.zones[k].keep == Zone::Keep::outside) ? "inside" : "outside",
                        safety.wall_margin));
    }
  }
  return sentences;
}

/// Bodies that move faster than the barrier assumes.
std::vector<std::string> warnings_of_speeds(const Scenario& scenario) {
  std::vector<std::string> sentences;
  if (!scenario.safety || scenario.safety->barrier == BarrierMode::off) return sentences;
  for (const UncooperativeBody& uncooperative : scenario.uncooperative) {
    const double speed = uncooperative.motion ? top_speed(*uncooperative.motion) : 0.0;
    if (speed <= uncooperative.speed_max) continue;
    sentences.push_back(fmt::format("{} moves at up to {} m/s, the barrier reckons with speed_max = {} m/s",
                                    scenario.team.name(uncooperative.body), speed, uncooperative.speed_max));
  }
  return sentences;
}

/// Robots of different models whose speed has no bound.
std::vector<std::string> warnings_of_robot_speeds(const Scenario& scenario) {
  std::vector<std::string> sentences;
  for (const RobotSpeed& of : uncooperative_robots(scenario)) {
    const double assumed = BodySafety{}.speed_max;
    if (!of.counts && of.speed > assumed)
      sentences.push_back(fmt::format(
          "{} climbs late, so that no other robot counts on it, and is up to {:.3g} m/s fast: the barrier "
          "reckons with {} m/s, and does not guarantee d_hard",
          scenario.team.name(of.robot), of.speed, assumed));
    if (!of.counts || std::isfinite(of.speed)) continue;
    sentences.push_back(fmt::format(
        "the speed of {} has no bound in its model, the barrier of robots of other models assumes {} m/s",
        scenario.team.name(of.robot), assumed));
  }
  return sentences;
}

/// Vehicles whose bodies touch at a distance above d_hard.
std::vector<std::string> warnings_of_touches(const Scenario& scenario) {
  std::vector<std::string> sentences;
  const auto radius = [&](BodyId body) {
    const RobotVehicle* vehicle = vehicle_of(scenario, body);
    return vehicle != nullptr ? vehicle->vehicle.radius : 0.0;
  };
  for (const RobotVehicle& vehicle : scenario.vehicles) {
    for (int i = 0; i < scenario.team.bodies(); ++i) {
      const BodyId other{i};
      const double touch = vehicle.vehicle.radius + radius(other);
      if (other == vehicle.robot || (radius(other) > 0 && other.index < vehicle.robot.index)) continue;
      if (hard_distance(scenario, vehicle.robot, other).value_or(touch) >= touch) continue;
      sentences.push_back(fmt::format("{} and {} touch at {:.3g} m, but d_hard is {} m",
                                      scenario.team.name(vehicle.robot), scenario.team.name(other), touch,
                                      *hard_distance(scenario, vehicle.robot, other)));
    }
  }
  return sentences;
}

}  // namespace

void Preflight::warn(const std::vector<std::string>& sentences) {
  constexpr std::size_t most_of_a_kind = 20;
  const std::size_t shown = std::min(sentences.size(), most_of_a_kind);
  warnings.insert(warnings.end(), sentences.begin(), sentences.begin() + static_cast<std::ptrdiff_t>(shown));
  if (shown < sentences.size())
    warnings.push_back(fmt::format("and {} more like it", sentences.size() - shown));
}

Preflight check_scenario(const Scenario& scenario) {
  Preflight p;
  look_at_regions(scenario, p);
  TagSize tags = judge_tag_sizes(scenario);
  std::move(tags.refusals.begin(), tags.refusals.end(), std::back_inserter(p.refusals));
  if (!p.refusals.empty()) return p;
  p.warn(warnings_of_starts(scenario));
  p.warn(warnings_of_zones(scenario));
  p.warn(warnings_of_views(scenario));
  p.warn(keys_without_effect(scenario));
  p.warn(limits_beyond_influence(scenario));
  p.warn(robots_beyond_noise(scenario));
  p.warn(warnings_of_speeds(scenario));
  p.warn(warnings_of_robot_speeds(scenario));
  p.warn(warnings_of_touches(scenario));
  p.warn(tags.warnings);
  if (scenario.campaign_refusal)
    p.warnings.push_back(fmt::format("no campaign can be flown: {}", scenario.campaign_refusal->what()));
  return p;
}

}  // namespace sightline
