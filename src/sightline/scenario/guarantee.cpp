#include "sightline/scenario/guarantee.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "sightline/run/team_barrier.hpp"
#include "sightline/safety/carry.hpp"
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
        abilities_(abilities_of(team_, options_.limits_to_come)),
        x_(scenario.x0) {
    for (const RobotSpeed& of : uncooperative_robots(scenario)) speeds_[of.robot.index] = of.speed;
    const BarrierOptions counted = counted_options(options_);
    const InputHistory at_rest(1, resting_inputs(team_));
    const std::vector<double> none(static_cast<std::size_t>(team_.nu()) + 1, 0.0);
    const double steps = std::ceil(counted.command_delay / scenario.horizon.dt);
    step_ = steps > 0 ? counted.command_delay / steps : 0.0;
    for (int i = 0; i < team_.bodies(); ++i) {
      const BodyId body{i};
      const Model& model = team_.model(body);
      const auto x = std::span(x_).subspan(at(team_.state_offset(body)), at(model.nx()));
      std::vector<double> rows(RungeKuttaScratch::rows_needed * x.size());
      std::vector<Vec3<double>>& coast = coasts_.emplace_back();
      for (double k = 0; k < steps; ++k) {
        if (team_.is_agent(body))
          carry(model, x, at_rest, at(team_.input_offset(body)), k * step_, (k + 1) * step_, {}, rows);
        coast.push_back(model.sight(x.data(), none.data()).p);
      }
      seen_.push_back(model.sight(x.data(), none.data()));
      if (team_.is_agent(body))
        barriers_.emplace_back(model, abilities_[barriers_.size()].can, scenario.horizon.dt, counted);
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
  double assumed(BodyId body) const { return options_.bodies[at(body)].speed_max; }
  double true_speed(BodyId body) const {
    if (const auto known = speeds_.find(body.index); known != speeds_.end()) return known->second;
    const double at_start = norm(seen_[at(body)].v);
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
      const double plan = can.drag > 0 ? (barrier(robot).acceleration() - w) / can.drag : infinity;
      if (!together && assumed(other) > plan)
        return fmt::format("a body is up to {:.3g} m/s fast, beyond the {:.3g} m/s of a plan", assumed(other),
                           plan);
      if (w > 0 && !together && team_.is_agent(other))
        return "the residual acceleration of a robot that moves by another law is not counted";
      if (team_.bodies() > 2) return "a robot that flies has more than one neighbour";
      if (!options_.barrier_options.zones.empty()) return "zones may stop a plan";
      if (scenario_.horizon.dt > usual_period && (can.thrust_count == 0 || can.free < 1 - 1e-6))
        return "plans are exact for periods of up to 0.01 s only";
    }
    Neighbour neighbour = counted_neighbour(options_, robot, other, seen_[at(other)], team_.is_agent(other),
                                            0.0, norm(options_.position_sigma, options_.position_sigma));
    if (together) neighbour.behavior = Behavior::cooperative;
    const auto x = std::span(x_).subspan(at(team_.state_offset(robot)), at(team_.model(robot).nx()));
    if (!coasts_apart(robot, neighbour, other) || !barrier(robot).keeps(x, neighbour))
      return "the start leaves no plan";
    return "";
  }
  /// Whether a robot keeps the distance until its first command acts.
  bool coasts_apart(BodyId robot, const Neighbour& neighbour, BodyId other) const {
    const BarrierOptions& o = options_.barrier_options;
    for (std::size_t k = 0; k < coasts_[at(robot)].size(); ++k) {
      const double t = step_ * static_cast<double>(k + 1),
                   moved = team_.is_agent(other) ? 0.0 : neighbour.speed_max * t,
                   pushed = o.residual_acceleration * t * t;  // of both
      if (norm(coasts_[at(robot)][k] - coasts_[at(other)][k]) < neighbour.d_hard + o.margin + moved + pushed)
        return false;
    }
    return true;
  }

  const ScenarioSpec& scenario_;
  const Team& team_;
  GuardOptions options_;
  std::vector<Ability> abilities_;
  std::vector<double> x_;            // where the first commands act; other bodies as at the start
  std::vector<Sight<double>> seen_;  // there
  double step_;                      // of the time until then [s]
  std::vector<std::vector<Vec3<double>>> coasts_;  // of each body, positions after each step
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
