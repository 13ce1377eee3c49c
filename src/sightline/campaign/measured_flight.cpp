#include "sightline/campaign/measured_flight.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "sightline/judge/present_team.hpp"
#include "sightline/judge/run_evaluator.hpp"
#include "sightline/judge/tracking_error.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

/// Judges the samples of a run, adds its squared errors, and keeps its true states.
class MeasuringSink final : public Sink<Sample> {
 public:
  MeasuringSink(const Scenario& run, RunEvaluator& judge)
      : team_(run.team),
        dt_(run.horizon.dt),
        judge_(judge),
        errors_(squared_errors(run)),
        sums_(errors_.size()),
        counts_(errors_.size()),
        sights_(at(run.team.bodies())) {
    flight_.x.reserve(at(team_.nx()) *
                      (static_cast<std::size_t>(std::llround(run.simulation.duration / dt_)) + 2));
  }

  Sample* claim() noexcept override { return sample_ = judge_.claim(); }
  bool takes_between() const noexcept override { return true; }
  Sample* claim_between() noexcept override { return sample_ = judge_.claim_between(); }
  void publish() noexcept override {
    add(*sample_);
    judge_.publish();
  }
  void close() noexcept override { judge_.close(); }

  MeasuredFlight flight() {
    std::array<int, tune_measures.size()> of_measure{};
    for (std::size_t i = 0; i < errors_.size(); ++i) {
      const auto m = static_cast<std::size_t>(errors_[i].measure);
      flight_.squares[m] += sums_[i] / static_cast<double>(counts_[i]);
      ++of_measure[m];
    }
    for (std::size_t m = 0; m < of_measure.size(); ++m) flight_.squares[m] /= of_measure[m];  // NaN without
    return std::move(flight_);
  }

 private:
  void add(const Sample& sample) noexcept {
    const std::size_t nx = at(team_.nx());
    if (sample.time > (static_cast<double>(rows_) - 0.5) * dt_ &&
        flight_.x.size() + nx <= flight_.x.capacity()) {
      flight_.x.insert(flight_.x.end(), sample.x.begin(), sample.x.end());
      ++rows_;
    }
    if (sample.of != Sample::Of::update) return;
    for (int b = 0; b < team_.bodies(); ++b) sights_[at(b)] = true_sight(team_, BodyId{b}, sample);
    for (std::size_t i = 0; i < errors_.size(); ++i) {
      if (sample.time < errors_[i].from - same_time) continue;
      sums_[i] += errors_[i].value(sample.time, sights_);
      ++counts_[i];
    }
  }

  const Team& team_;
  double dt_;  // [s]
  RunEvaluator& judge_;
  Sample* sample_ = nullptr;
  std::vector<SquaredError> errors_;
  std::vector<double> sums_;
  std::vector<std::int64_t> counts_;
  std::vector<Sight<double>> sights_;
  std::int64_t rows_ = 0;  // of flight_.x
  MeasuredFlight flight_;
};

/// Periods from the measurement of a state to the effect of its command, without those that the
/// controllers compensate.
int delay_of(const Scenario& run) {
  double compensated = 0.0;
  for (const RobotCompensation& one : run.compensations)
    compensated = std::max(compensated, one.command_delay);
  const Disturbances& disturbances = run.simulation.disturbances;
  const double delay = disturbances.input_delay + disturbances.measurement_delay - compensated;
  return static_cast<int>(std::lround(std::max(0.0, delay) / run.horizon.dt));
}

}  // namespace

std::vector<SquaredError> squared_errors(const ScenarioSpec& scenario) {
  const Team& team = scenario.team;
  std::vector<SquaredError> errors;
  for (const Observation& pair : observations(team.couplings())) {
    const auto angle = [pair](std::span<const Sight<double>> sights) {
      const auto seen = [&](BodyId body) { return sights[at(body)]; };
      return view_angle(pair.mount, first_sight(seen, pair.observer, pair.third), sights[at(pair.target)].p);
    };
    const double settle = scenario.simulation.settle;
    std::vector<BodyId> bodies = {pair.observer, pair.target};
    if (pair.third.index >= 0) bodies.push_back(pair.third);
    errors.push_back(
        {TuneMeasure::view_angle, settle, pair.observer, bodies,
         [angle](double, std::span<const Sight<double>> sights) { return square(angle(sights)); }});
    if (std::isnan(pair.alpha)) continue;  // a region
    errors.push_back({TuneMeasure::view_excess, settle, pair.observer, bodies,
                      [angle, alpha = pair.alpha](double, std::span<const Sight<double>> sights) {
                        return square(std::max(0.0, angle(sights) - alpha));
                      }});
  }
  for (int b = 0; b < team.bodies(); ++b) {
    const BodyId robot{b};
    if (!team.is_agent(robot)) continue;
    const Agent& agent = team.agent(robot);
    if (!tracks_position(agent, roles_of(agent.model))) continue;
    errors.push_back({TuneMeasure::rms_position_error,
                      scenario.simulation.rms_from,
                      robot,
                      {robot},
                      [agent, robot, x_ref = std::vector<double>(at(agent.model.nx()))](
                          double t, std::span<const Sight<double>> sights) mutable {
                        agent.x_ref(t, agent.model, x_ref);
                        const Sight<double> wanted = agent.model.sight(x_ref.data(), agent.u_ref.data());
                        const Vec3<double> e = sights[at(robot)].p - wanted.p;
                        return dot(e, e);
                      }});
  }
  return errors;
}

MeasuredFlight fly_measured(const Scenario& run, const CampaignPlan& plan) {
  const Controls controls(run);
  const auto world = make_world(run);
  RunEvaluator judge(run, plan, sized_sample(*world, controls.controllers()));
  MeasuringSink sink(run, judge);
  SimulatedClock clock;
  ClosedLoop loop(run, *world, controls.controllers(), clock, sink);
  const LoopOutcome outcome = loop.fly();
  MeasuredFlight flight = sink.flight();
  flight.recovered =
      judge.result(outcome, outcome.finite ? std::string() : world->ended()).outcome == Outcome::recovered;
  return flight;
}

MeasureGradient differentiate(const Scenario& run, const MeasuredFlight& flight, TuneMeasure measure) {
  const Team& team = run.team;
  const std::size_t nx = at(team.nx()), nu = at(team.nu()), states = flight.x.size() / nx;
  LoopGradient loop(Ocp(team, run.horizon), delay_of(run));
  loop.follow(flight.x);
  std::vector<SquaredError> errors = squared_errors(run);
  std::erase_if(errors, [&](const SquaredError& error) { return error.measure != measure; });

  std::vector<double> by_x(states * nx), by_u((states - 1) * nu);
  std::vector<Sight<double>> sights(at(team.bodies()));
  for (const SquaredError& error : errors) {
    const auto first = static_cast<std::size_t>(std::max(0.0, std::ceil(error.from / run.horizon.dt - 1e-6)));
    const double samples = static_cast<double>(states - 1) - static_cast<double>(first);
    const double share = 1.0 / (samples * static_cast<double>(errors.size()));
    for (std::size_t k = first; k + 1 < states; ++k) {
      const int period = static_cast<int>(k);
      std::vector<double> x(loop.x(period).begin(), loop.x(period).end());
      std::vector<double> u(loop.u(period).begin(), loop.u(period).end());
      const auto look = [&](BodyId body) {
        sights[at(body)] =
            team.model(body).sight(x.data() + team.state_offset(body), u.data() + team.input_offset(body));
      };
      for (int b = 0; b < team.bodies(); ++b) look(BodyId{b});
      const auto slope = [&](BodyId body, double& number) {
        constexpr double step = 1e-6;
        const double here = number;
        std::array<double, 2> values{};
        for (std::size_t side = 0; side < 2; ++side) {
          number = side == 0 ? here - step : here + step;
          look(body);
          values[side] = error.value(period * run.horizon.dt, sights);
        }
        number = here;
        look(body);
        return share * (values[1] - values[0]) / (2 * step);
      };
      for (const BodyId body : error.bodies) {
        const std::size_t state = at(team.state_offset(body));
        for (std::size_t i = state; i < state + at(team.model(body).nx()); ++i)
          by_x[k * nx + i] += slope(body, x[i]);
        if (!team.is_agent(body)) continue;
        const std::size_t input = at(team.input_offset(body));
        for (std::size_t i = input; i < input + at(team.model(body).nu()); ++i)
          by_u[k * nu + i] += slope(body, u[i]);
      }
    }
  }
  MeasureGradient gradient;
  gradient.updates = static_cast<int>(states) - 1;
  gradient.without_derivative = loop.differentiate(by_x, by_u);
  gradient.by_parameters.assign(loop.by_parameters().begin(), loop.by_parameters().end());
  for (const InputGradient::Parameter& parameter : loop.parameters())
    gradient.names.push_back(parameter.name);
  return gradient;
}

}  // namespace sightline
