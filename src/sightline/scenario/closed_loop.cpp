#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "sightline/base.hpp"
#include "sightline/registry.hpp"
#include "sightline/run/controller.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/read_camera.hpp"
#include "sightline/scenario/read_estimate.hpp"
#include "sightline/scenario/read_partition.hpp"
#include "sightline/scenario/read_safety.hpp"
#include "sightline/scenario/templates.hpp"
#include "sightline/sensors.hpp"
#include "sightline/solvers.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

std::optional<Guard> guard_of(const Scenario& scenario, const World& world) {
  std::optional<GuardOptions> options = guard_options(scenario);
  if (!options) return std::nullopt;
  options->absent_robots_stay = world.absent_robots_stay();
  options->pool = scenario.pool;
  return std::optional<Guard>(std::in_place, scenario.team, *options);
}

std::optional<Compensation> compensation_of(const Scenario& scenario) {
  if (scenario.compensations.empty()) return std::nullopt;
  return std::optional<Compensation>(std::in_place, scenario.team, scenario.compensations,
                                     scenario.horizon.dt);
}

std::optional<Localizer> localizer_of(const Scenario& scenario) {
  if (scenario.localization.robots.empty()) return std::nullopt;
  return std::optional<Localizer>(std::in_place, scenario.team, scenario.x0, scenario.localization);
}

/// Minimum distance of a robot to each body [m]: the scenario's hard distance, otherwise
/// LoopOptions::at_one_place.
std::vector<double> hard_distances(const Scenario& scenario) {
  std::vector<double> d_hard;
  for (int i = 0; i < scenario.team.bodies(); ++i) {
    const std::optional<double> d = hard_distance(scenario, BodyId{0}, BodyId{i});
    d_hard.push_back(d.value_or(LoopOptions::at_one_place));
  }
  return d_hard;
}

/// Whether the pose uncertainty of some robot shrinks its view.
bool has_uncertain_views(const ScenarioSpec& scenario) {
  const auto& robots = scenario.localization.robots;
  return std::any_of(robots.begin(), robots.end(),
                     [](const LocalizedRobot& robot) { return robot.mount.sigmas > 0; });
}

/// @param changes  whether the team changes in flight
void check_abilities(const ScenarioSpec& scenario, bool changes, const SolverList& solvers) {
  const bool swarms = !scenario.team.swarms().empty();
  const auto& agents = scenario.team.agents();
  const auto rated =
      std::find_if(agents.begin(), agents.end(), [](const Agent& agent) { return !agent.R_rate.empty(); });
  std::vector<std::string> names = scenario.simulation.compare;
  names.insert(names.begin(), scenario.solver.name);
  for (const std::string& name : names) {
    using Can = SolverAbilities;
    const Can can = solvers.named(name).can;
    if (changes && !can.changing_teams)
      throw_invalid("the team changes in flight, which the solver {} cannot follow, expected {}", name,
                    solvers.names_that(&Can::changing_teams));
    if (swarms && !can.keep_apart)
      throw_invalid("the solver {} knows no keep_apart, expected {}", name,
                    solvers.names_that(&Can::keep_apart));
    if (has_uncertain_views(scenario) && !can.uncertain_views)
      throw_invalid("the solver {} lets no view shrink by the sigmas of a sensor, expected {}", name,
                    solvers.names_that(&Can::uncertain_views));
    if (rated != agents.end() && !can.input_rates)
      throw_invalid("{} has a cost of its inputs' rates, R_rate, expected the solver {}, which plans with it",
                    rated->name, solvers.names_that(&Can::input_rates));
  }
}

}  // namespace

const Registry& registry_of(const Scenario& scenario) {
  return scenario.registry ? *scenario.registry : built_in_registry();
}

void check_solvers(const ScenarioSpec& spec, const Registry& registry) {
  check_abilities(spec, changes_in_flight(spec), registry.solvers);
}

void check_solvers(const Scenario& scenario) {
  check_abilities(scenario, changes_in_flight(scenario), registry_of(scenario).solvers);
}

void make_tunable(Scenario& scenario, TunedScript::Scope scope) {
  if (scenario.partition) throw_invalid("--tune of a team that plans in parts, expected one solver for all");
  TomlDocument document = parse_toml(scenario.text, scenario.file.native());
  toml::table* const simulation = document.root["simulation"].as_table();
  if (simulation != nullptr && simulation->erase("compare") > 0) scenario.text = printed(document);
  scenario.simulation.compare.clear();
  scenario.tuned = std::make_shared<TunedScript>(scope);
  check_solvers(scenario);
}

void lift_deadline(SolverChoice& choice) {
  const auto lift = [](auto& options) {
    if constexpr (requires { options.deadline; }) options.deadline = 0.0;
  };
  std::visit(lift, choice.options);
}

SensorOptions sensor_options(const ScenarioSpec& scenario) {
  SensorOptions options{.seed = scenario.simulation.seed,
                        .noise = scenario.simulation.disturbances.noise,
                        .odometry = scenario.simulation.disturbances.odometry,
                        .delay = scenario.simulation.disturbances.measurement_delay,
                        .period = scenario.horizon.dt,
                        .velocity_unknown = {},
                        .faults = scenario.simulation.faults};
  for (const UncooperativeBody& uncooperative : scenario.uncooperative) {
    if (uncooperative.velocity == SeenVelocity::unknown)
      options.velocity_unknown.push_back(uncooperative.body);
  }
  return options;
}

void share_updates(SolverChoice& choice, const std::shared_ptr<ThreadPool>& pool) {
  const auto share = [&](auto& options) {
    if constexpr (requires { options.pool; }) options.pool = pool;
  };
  std::visit(share, choice.options);
}

MakeSolver solver_maker(SolverChoice choice, const Horizon& horizon) {
  return
      [choice = std::move(choice), horizon](const Team& team) { return make_solver(choice, team, horizon); };
}

Controls::Controls(const Scenario& scenario) {
  check_solvers(scenario);
  if (scenario.partition && scenario.partition->part.empty()) {
    const PartitionPlan& plan = *scenario.partition;
    talks_ = true;
    solver_ = std::make_unique<PartitionedSolver>(
        scenario.team, partition_of(plan, scenario.team), solver_maker(scenario.solver, scenario.horizon),
        PartitionOptions{.order = ExchangeOrder::jacobi, .messages = plan.exchange});
    return;
  }
  if (!changes_in_flight(scenario)) {
    solver_ = make_solver(scenario.solver, scenario.team, scenario.horizon);
    return;
  }
  team_switcher_ =
      std::make_unique<TeamSwitcher>(ActiveTeam(scenario.team, scenario.presence), scenario.script,
                                     solver_maker(scenario.solver, scenario.horizon), scenario.tuned);
}

bool Controls::restart() {
  if (team_switcher_ || talks_) return false;
  solver_->restart();
  return true;
}

Controllers Controls::controllers() const {
  if (team_switcher_) return {*team_switcher_->present().solver};
  return {*solver_};
}

KernelUse Controls::kernels() const {
  return team_switcher_ ? team_switcher_->present().solver->kernels() : solver_->kernels();
}

std::unique_ptr<World> make_world(const Scenario& scenario) {
  const Registry& registry = registry_of(scenario);
  const WorldPart* const kind = registry.worlds.find(scenario.world);
  if (kind == nullptr)
    throw_invalid("world.kind = {}, expected one of {}", scenario.world,
                  fmt::join(registry.worlds.names(), ", "));
  const auto reporting = [&](std::unique_ptr<World> world) -> std::unique_ptr<World> {
    if (scenario.localization.robots.empty()) return world;
    return std::make_unique<TelemetryWorld>(std::move(world), telemetry_options(scenario));
  };
  std::unique_ptr<World> world = kind->make(scenario);
  const CameraOptions options = camera_options(scenario);
  if (options.cameras.empty() || options.tags.empty()) return reporting(std::move(world));
  std::unique_ptr<DetectionSource> source = std::make_unique<SyntheticDetections>(scenario.team, options);
  if (renders_pictures(options)) {
    if (!kind->renders())
      throw_invalid("camera.render = true, expected false in the world \"{}\"", scenario.world);
    source = kind->renderer(scenario);
  }
  return reporting(std::make_unique<CameraWorld>(std::move(world), options, std::move(source)));
}

ClosedLoop::ClosedLoop(const Scenario& scenario, World& world, const Controllers& controllers, Clock& clock,
                       Sink<Sample>& sink, std::int64_t (*allocations)() noexcept,
                       TeamSwitcher* team_switcher, const std::atomic<bool>* stop)
    : guard_(guard_of(scenario, world)),
      localizer_(localizer_of(scenario)),
      compensation_(compensation_of(scenario)),
      loop_(world, controllers, clock, sink,
            {.duration = scenario.simulation.duration,
             .period = scenario.horizon.dt,
             .path_interval = scenario.log.prediction_period,
             .warm_up = std::min(scenario.loop.warm_up, 0.5 * scenario.horizon.dt),
             .allocations = allocations,
             .stop = stop,
             .guard = guard_ ? &*guard_ : nullptr,
             .localizer = localizer_ ? &*localizer_ : nullptr,
             .compensation = compensation_ ? &*compensation_ : nullptr,
             .late_plans = scenario.simulation.late_plans,
             .team_switcher = team_switcher,
             .signals = scenario.simulation.signals,
             .d_hard = hard_distances(scenario)}) {}

}  // namespace sightline
