#include "sightline/scenario/guarantee.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "sightline/run/team_barrier.hpp"
#include "sightline/scenario/read_safety.hpp"

namespace sightline {
namespace {

/// Why no distance is guaranteed in this scenario, whatever the pair; empty: some are.
std::string why_none(const ScenarioSpec& scenario) {
  const Disturbances& d = scenario.simulation.disturbances;
  const bool pushed = norm(d.wind.x, d.wind.y) > scenario.safety->barrier_options.residual_acceleration ||
                      d.wind.z != 0 || d.gust_sigma > 0 || d.airflow.amplitude > 0;
  if (scenario.links != nullptr) return "real vehicles deviate from their models";
  if (pushed || d.yaw_lag > 0 || d.input_gain != 1 || d.slip > 0)
    return "simulation.disturbance moves the robots otherwise than their models";
  std::vector<double> delays(scenario.team.agents().size());
  for (const RobotCompensation& of : scenario.compensations) {
    delays[scenario.team.agent_index(of.robot)] = of.command_delay;
    if (of.disturbance_time > 0) return "the estimate of a disturbance may move";
  }
  if (std::any_of(delays.begin(), delays.end(), [&](double delay) { return delay != d.input_delay; }))
    return "commands do not act after the command_delay that the barrier predicts";
  if (d.spoil_measurements() || !scenario.simulation.faults.empty()) return "the measurements are disturbed";
  if (!scenario.simulation.late_plans.empty()) return "plans are late";
  if (!scenario.localization.robots.empty()) return "robots know positions by estimates alone";
  if (scenario.partition) return "the team is planned in parts, which may not receive each other";
  if (!scenario.script.events.empty()) return "events change the team";
  return "";
}

class Guarantees {
 public:
  explicit Guarantees(const ScenarioSpec& scenario)
      : scenario_(scenario),
        team_(scenario.team),
        options_(*guard_options(scenario)),
        abilities_(abilities_of(team_, options_.limits_to_come)) {
    for (const RobotSpeed& of : uncooperative_robots(scenario)) speeds_[of.robot.index] = of.speed;
    const std::vector<double> none(static_cast<std::size_t>(team_.nu()) + 1, 0.0);
    for (int i = 0; i < team_.bodies(); ++i) {
      const BodyId body{i};
      seen_.push_back(team_.model(body).sight(scenario.x0.data() + team_.state_offset(body), none.data()));
      if (!team_.is_agent(body)) continue;
      const Authority& can = abilities_[barriers_.size()].can;
      barriers_.emplace_back(team_.model(body), can, scenario.horizon.dt, options_.barrier_options);
    }
  }

  PairGuarantee of(BodyId a, BodyId b) const {
    PairGuarantee pair{a, b, why_not(a, b), ""};
    if (pair.holds()) pair.condition = condition_of(a);
    if (pair.holds() || !team_.is_agent(b) || cooperate(a, b)) return pair;
    const std::string other = why_not(b, a);
    if (other.empty()) return {a, b, "", condition_of(b)};
    if (other != pair.why_not && barrier(a).drives()) pair.why_not += ", and " + other;
    return pair;
  }

 private:
  const Ability& ability(BodyId robot) const { return abilities_[team_.agent_index(robot)]; }
  const Barrier& barrier(BodyId robot) const { return barriers_[team_.agent_index(robot)]; }
  bool cooperate(BodyId a, BodyId b) const {
    return team_.is_agent(a) && team_.is_agent(b) && ability(a).kind == ability(b).kind && !barrier(a).lags();
  }
  /// The speed that the barriers assume of an uncooperative body, and its true bound [m/s].
  double assumed(BodyId body) const {
    return options_.bodies[static_cast<std::size_t>(body.index)].speed_max;
  }
  double true_speed(BodyId body) const {
    if (const auto known = speeds_.find(body.index); known != speeds_.end()) return known->second;
    const double at_start = norm(seen_[static_cast<std::size_t>(body.index)].v);
    for (const UncooperativeBody& one : scenario_.uncooperative)
      if (one.body == body) return one.motion ? top_speed(*one.motion) : at_start;
    return at_start;
  }
  std::string condition_of(BodyId robot) const {
    return barrier(robot).drives() ? "" : "if no wall is within the robot's plan";
  }

  /// Why a robot alone, or with the other's cooperation, does not guarantee the distance.
  std::string why_not(BodyId robot, BodyId other) const {
    const Authority& can = ability(robot).can;
    const bool together = cooperate(robot, other);
    for (const RobotVehicle& vehicle : scenario_.vehicles) {
      if (vehicle.robot == robot || (together && vehicle.robot == other))
        return "a vehicle deviates from its model";
    }
    constexpr double rounding = 1e-9;  // [m/s]
    if (!together && true_speed(other) > assumed(other) + rounding)
      return fmt::format("a body is up to {:.3g} m/s fast, but the barriers assume {:.3g} m/s",
                         true_speed(other), assumed(other));
    if (can.drives()) {
      if (!together && assumed(other) > 0)
        return "a robot that drives along its heading stands and cannot flee";
    } else {
      if (can.thrust_lag > 0 && can.misfit > 0)
        return "the drag of a robot that tilts late depends on the direction";
      // The fastest body that every plan outruns: docs/safety.md, 3.
      constexpr double fastest = 2.5, usual_period = 0.01;  // [m/s], [s]
      if (!together && assumed(other) > fastest)
        return fmt::format("a body is up to {:.3g} m/s fast, beyond {} m/s", assumed(other), fastest);
      // The residual acceleration makes a body as fast, relative to the plan, as it makes the robot.
      const double w = options_.barrier_options.residual_acceleration;
      if (w > 0 && can.drag > 0 && !together &&
          assumed(other) + w / can.drag > barrier(robot).acceleration() / can.drag)
        return "the residual acceleration leaves no plan that outruns the body";
      if (w > 0 && !together && team_.is_agent(other))
        return "the residual acceleration of a robot that moves by another law is not counted";
      if (team_.bodies() > 2) return "a robot that flies has more than one neighbour";
      if (!options_.barrier_options.zones.empty()) return "zones may stop a plan";
      if (scenario_.horizon.dt > usual_period && (can.thrust_count == 0 || can.free < 1 - 1e-6))
        return "plans are exact for periods of up to 0.01 s only";
    }
    const Sight<double>& seen = seen_[static_cast<std::size_t>(other.index)];
    const bool keeps =
        barrier(robot).keeps(std::span(scenario_.x0)
                                 .subspan(static_cast<std::size_t>(team_.state_offset(robot)),
                                          static_cast<std::size_t>(team_.model(robot).nx())),
                             {.p = seen.p,
                              .v = seen.v,
                              .d_hard = hard_distance(scenario_, robot, other).value_or(0.0),
                              .speed_max = assumed(other),
                              .tie = robot.index < other.index ? 1.0 : -1.0,
                              .behavior = together ? Behavior::cooperative : Behavior::uncooperative});
    if (!keeps) return "the start leaves no plan";
    return "";
  }

  const ScenarioSpec& scenario_;
  const Team& team_;
  GuardOptions options_;
  std::vector<Ability> abilities_;
  std::vector<Sight<double>> seen_;
  std::vector<Barrier> barriers_;
  std::map<int, double> speeds_;
};

}  // namespace

std::vector<PairGuarantee> distance_guarantees(const ScenarioSpec& scenario) {
  std::vector<PairGuarantee> pairs;
  if (!scenario.safety || scenario.safety->barrier != BarrierMode::on) return pairs;
  const std::string none = why_none(scenario);
  std::optional<Guarantees> guarantees;
  if (none.empty()) guarantees.emplace(scenario);
  const Team& team = scenario.team;
  for (int i = 0; i < team.bodies(); ++i) {
    for (int j = i + 1; j < team.bodies() && team.is_agent(BodyId{i}); ++j)
      pairs.push_back(guarantees ? guarantees->of(BodyId{i}, BodyId{j})
                                 : PairGuarantee{BodyId{i}, BodyId{j}, none, ""});
  }
  return pairs;
}

std::string describe(const std::vector<PairGuarantee>& pairs, const Team& team, std::size_t most) {
  struct Verdict {
    std::string words, names;
    std::size_t count = 0;
  };
  std::vector<Verdict> verdicts;
  for (const PairGuarantee& pair : pairs) {
    std::string words = pair.holds() ? "guaranteed" : "not guaranteed, " + pair.why_not;
    if (!pair.condition.empty()) words += ", " + pair.condition;
    auto verdict = std::find_if(verdicts.begin(), verdicts.end(),
                                [&](const Verdict& known) { return known.words == words; });
    if (verdict == verdicts.end()) verdict = verdicts.insert(verdicts.end(), {std::move(words), "", 0});
    if (verdict->count++ < most)
      verdict->names += fmt::format("{}{} and {}", verdict->names.empty() ? "" : ", ", team.name(pair.first),
                                    team.name(pair.second));
  }
  std::string text;
  for (const Verdict& one : verdicts) {
    text += fmt::format("distance    {}: {}", one.words, one.names);
    text += one.count > most ? fmt::format(", and {} more\n", one.count - most) : "\n";
  }
  return text;
}

}  // namespace sightline
