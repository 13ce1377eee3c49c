#include "sightline/scenario.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/run/steady_state.hpp"
#include "sightline/scenario/layers.hpp"
#include "sightline/scenario/read_camera.hpp"
#include "sightline/scenario/read_campaign.hpp"
#include "sightline/scenario/read_coupling.hpp"
#include "sightline/scenario/read_disturbances.hpp"
#include "sightline/scenario/read_estimate.hpp"
#include "sightline/scenario/read_event.hpp"
#include "sightline/scenario/read_motion.hpp"
#include "sightline/scenario/read_part.hpp"
#include "sightline/scenario/read_partition.hpp"
#include "sightline/scenario/read_robot.hpp"
#include "sightline/scenario/read_safety.hpp"
#include "sightline/scenario/read_shape.hpp"
#include "sightline/scenario/read_vehicle.hpp"
#include "sightline/scenario/read_view.hpp"
#include "sightline/scenario/templates.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 27> agent_keys = {
    "robot",        "parameters", "start",   "Q",      "R",        "command_delay",
    "u_ref",        "u_min",      "u_max",   "limits", "rate_max", "reference",
    "sensor",       "present",    "vehicle", "link",   "Q_f",      "disturbance_time",
    "feed_forward", "R_rate",     "camera",  "tags",   "hull",     "localization",
    "observes",     "estimate",   "sensors"};

/// Rejects two sensors of a robot with one mount, by which couplings and events tell them apart.
void check_mounts(const TomlTable& at, const Observer& robot) {
  std::vector<SensorMount> others;
  if (robot.mount) others.push_back(*robot.mount);
  for (const NamedSensor& one : robot.sensors) {
    if (std::find(others.begin(), others.end(), one.mount) != others.end())
      at.table("sensors").throw_invalid(one.name, "another mount than that of another sensor of the robot");
    others.push_back(one.mount);
  }
}

/// Fills a ScenarioSpec from a document, section by section; sections that others refer to come first.
class Reader {
 public:
  Reader(const TomlDocument& document, ScenarioSpec& scenario) : root_(document), scenario_(scenario) {}

  void read() {
    root_.expect_only({"horizon", "solver",     "agent",      "target",    "obstacle",
                       "couple",  "shape",      "keep_apart", "constrain", "event",
                       "world",   "simulation", "safety",     "log",       "loop",
                       "fleet",   "campaign",   "estimate",   "partition", "certify_view"});
    read_keys(root_.table_or_empty("horizon"), {}, scenario_.horizon);
    scenario_.solver = read_solver(root_.table_or_empty("solver"), scenario_.horizon);
    read_world();
    read_simulation();
    read_agents();
    read_log();
    read_bodies("target", scenario_.targets);
    read_bodies("obstacle", scenario_.obstacles);
    for (const TomlTable& at : root_.tables("couple")) {
      read_couple(at, observers_, scenario_.team);
      scenario_.coupling_places.resize(scenario_.team.couplings().size(), at.where());
    }
    for (const TomlTable& at : root_.tables("shape")) {
      read_shape(at, observers_, scenario_);
      scenario_.coupling_places.resize(scenario_.team.couplings().size(), at.where());
    }
    for (const TomlTable& at : root_.tables("keep_apart")) read_keep_apart(at, scenario_.team);
    read_constraints();
    scenario_.safety = read_safety(root_, scenario_.simulation.disturbances);
    check_starts(root_, scenario_);
    read_faults(root_.table_or_empty("simulation"), scenario_.team, scenario_.simulation);
    if (root_.has("fleet")) {
      for (const RobotCamera& one : scenario_.vision.cameras)
        if (scenario_.vision.camera_of(one.observer) != &one)
          root_.throw_invalid("fleet", fmt::format("robots with one camera each, {} has several",
                                                   scenario_.team.name(one.observer)));
      scenario_.links = link_reader(root_).read_links(root_, scenario_);
    }
    scenario_.script = read_events(root_, scenario_, observers_);
    // The guard includes the limits that events set.
    if (const auto options = guard_options(scenario_)) {
      root_.table_or_empty("safety").checked([&] { validate(scenario_.team, *options); });
    }
    read_estimates(root_, scenario_);
    scenario_.certified_views = read_certified_views(root_, scenario_);
    root_.table_or_empty("solver").checked([&] { check_solvers(scenario_, root_.registry()); });
    read_partition(root_, scenario_);
    // A log is replayed without the world.
    if (root_.from_disk()) root_.table_or_empty("world").checked([&] { check_world(); });
  }

 private:
  /// The reader of the links in that table.
  const LinkReader& link_reader(const TomlTable& at) const {
    if (!root_.has("fleet")) at.throw_invalid("link", "no such table without a [fleet]");
    if (root_.registry().links == nullptr)
      root_.throw_invalid("fleet", "no links: this program lacks their reader, with_links()");
    return *root_.registry().links;
  }

  void read_log() {
    const TomlTable at = root_.table_or_empty("log");
    read_keys(at, {}, scenario_.log);
    read_keys(root_.table_or_empty("loop"), {}, scenario_.loop);
    constexpr double predictions_max = 1000.0;  // per second, of all robots together
    if (!at.has("prediction_period"))
      scenario_.log.prediction_period =
          std::max(scenario_.log.prediction_period,
                   static_cast<double>(scenario_.team.agents().size()) / predictions_max);
  }

  void read_world() {
    const TomlTable at = root_.table_or_empty("world");
    const WorldList& worlds = root_.registry().worlds;
    if (at.has("kind")) scenario_.world = at.word("kind", worlds.names());
    const std::array<std::string_view, 2> beside = {"kind", "model"};
    const bool reads_models = static_cast<bool>(worlds.find(scenario_.world)->of_model);
    refuse_without_models(at, std::span(beside).last(1), scenario_.world);
    scenario_.downwash = read_downwash(at, scenario_.world, std::span(beside).first(reads_models ? 2 : 1));
    if (at.has("model")) scenario_.model = read_model_file(at);
  }

  void check_world() const {
    const WorldPart& world = *root_.registry().worlds.find(scenario_.world);
    if (world.has_vehicles())
      validate(world.name, scenario_.team, scenario_.x0, scenario_.vehicles, plant_options(scenario_));
    if (world.check) world.check(scenario_);
  }

  void read_simulation() {
    const TomlTable at = root_.table_or_empty("simulation");
    Simulation& s = scenario_.simulation;
    read_keys(at, {"disturbance", "fault", "signal"}, s);
    s.signals = read_signals(at);
    if (at.has("compare")) read_compare(at);
    if (at.has("seed")) {
      s.seed = static_cast<std::uint64_t>(at.integer("seed", 0, std::numeric_limits<std::int64_t>::max()));
    }
    const double updates = s.duration / scenario_.horizon.dt;
    if (updates > updates_max) {
      at.throw_invalid("duration",
                       fmt::format("at most {:g} periods of {} s", updates_max, scenario_.horizon.dt));
    }
    if (updates < 0.5)
      at.throw_invalid("duration", fmt::format("at least one period of {} s", scenario_.horizon.dt));
    s.disturbances = read_disturbances(at.table_or_empty("disturbance"));
  }

  void read_compare(const TomlTable& at) {
    const auto known = root_.registry().solvers.names();
    auto& compare = scenario_.simulation.compare;
    compare = at.texts("compare", TomlTable::any_length, "solvers");
    for (std::size_t i = 0; i < compare.size(); ++i) {
      const auto name = compare.begin() + static_cast<std::ptrdiff_t>(i);
      if (std::find(known.begin(), known.end(), *name) == known.end() ||
          std::find(compare.begin(), name, *name) != name) {
        at.throw_invalid("compare", i, fmt::format("one of {}, each once", fmt::join(known, ", ")));
      }
    }
  }

  void read_agents() {
    const auto agents = root_.named_tables("agent");
    if (agents.empty()) root_.throw_invalid("agent", "at least one [agent.NAME]");
    if (agents.size() > agents_max)
      root_.throw_invalid("agent", fmt::format("at most {} robots", agents_max));
    for (const auto& [name, at] : agents) {
      at.expect_only(agent_keys);
      const Model model = read_robot(at);
      const auto nx = static_cast<std::size_t>(model.nx()), nu = static_cast<std::size_t>(model.nu());
      const auto list = [&at = at](std::string_view key, std::size_t n, double missing, const Range& range) {
        return at.has(key) ? at.numbers(key, n, range) : std::vector<double>(n, missing);
      };
      const auto bound = [&at = at, nu](std::string_view key, std::span<const double> of_model) {
        return at.has(key) ? at.numbers(key, nu) : std::vector<double>(of_model.begin(), of_model.end());
      };
      Agent agent{.name = name,
                  .model = model,
                  .Q = list("Q", nx, 0.0, not_negative(">= 0")),
                  .R = list("R", nu, 1.0, positive("> 0")),
                  .Q_f = list("Q_f", nx, 0.0, not_negative(">= 0")),
                  .x_ref = read_reference(at, model),
                  .u_ref = list("u_ref", nu, 0.0, any_number()),
                  .limits = read_limits(at, bound("u_min", model.u_min()), bound("u_max", model.u_max()))};
      if (at.has("rate_max")) agent.rate_max = at.numbers("rate_max", nu, positive("> 0 1/s"));
      if (at.has("R_rate")) agent.R_rate = at.numbers("R_rate", nu, not_negative(">= 0 s^2"));
      const std::vector<double> start =
          read_start(at.table("start", "a table with p and heading, or with state"), model);
      check_motion(at, model, start, agent.u_ref);
      if (is_present(at)) check_place(name, at, model.sight(start.data(), agent.u_ref.data()).p);
      scenario_.x0.insert(scenario_.x0.end(), start.begin(), start.end());

      observers_.push_back({name, read_mount(at), read_sensors(at)});
      check_mounts(at, observers_.back());
      std::optional<RobotVehicle> vehicle = read_vehicle(at, model, scenario_.world);
      if (vehicle && model.sight(start.data(), agent.u_ref.data()).p.z < 0)
        at.table("start").throw_invalid(place_key(at), "a place at or above the ground, whose height is 0 m");
      std::optional<double> goal_speed;
      if (at.has("link")) goal_speed = link_reader(at).read_goal_speed(at, agent);
      enter(name, at, [&] { return scenario_.team.add(std::move(agent)); });
      if (vehicle) {
        vehicle->robot = bodies_.at(name);
        scenario_.vehicles.push_back(std::move(*vehicle));
      }
      read_sight(at, bodies_.at(name), observers_.back(), scenario_);
      read_compensation(at, bodies_.at(name));
      if (goal_speed) {
        const BodyId robot = bodies_.at(name);
        scenario_.goal_options.push_back({robot, scenario_.team.agent(robot).x_ref, *goal_speed});
      }
      scenario_.presence.push_back(is_present(at) ? Presence::steered : Presence::absent);
    }
  }

  void read_compensation(const TomlTable& at, BodyId robot) {
    if (!at.has("command_delay") && !at.has("disturbance_time") && !at.has("feed_forward")) return;
    RobotCompensation of{robot};
    read_parameters(TableSource(at), of);
    at.checked([&] { validate(scenario_.team, std::vector{of}); });
    scenario_.compensations.push_back(of);
  }

  /// Rejects a robot whose text model is not finite at its start, as 1 / v is at rest.
  static void check_motion(const TomlTable& at, const Model& model, const std::vector<double>& start,
                           const std::vector<double>& u_ref) {
    std::vector<double> rate(start.size());
    model.f(start.data(), u_ref.data(), rate.data());
    if (all_finite(rate)) return;
    at.throw_invalid(
        "start",
        "a state in which the rates of the robot are finite: start.state gives every state of a robot");
  }

  /// The key that holds a robot's start position.
  static std::string_view place_key(const TomlTable& at) {
    return at.table("start").has("state") ? "state" : "p";
  }

  /// Rejects a robot that starts at the position of another, unless a campaign draws the starts.
  void check_place(const std::string& name, const TomlTable& at, const Vec3<double>& p) {
    constexpr double one_place = 1e-3;  // [m]
    for (const auto& [other, place] : places_) {
      if (root_.has("campaign") || norm(p - place) >= one_place) continue;
      at.table("start").throw_invalid(place_key(at),
                                      fmt::format("a place of its own, {} starts there", other));
    }
    places_.emplace_back(name, p);
  }

  /// Rejects a u_min that is not below its u_max; `where` is the key that holds it.
  static void check_crossing(const TomlTable& at, std::string_view where, const std::vector<double>& u_min,
                             const std::vector<double>& u_max) {
    for (std::size_t i = 0; i < u_min.size(); ++i) {
      if (u_min[i] < u_max[i]) continue;
      at.throw_invalid(where, fmt::format("u_min < u_max, but u_min[{0}] = {1} and u_max[{0}] = {2}", i,
                                          u_min[i], u_max[i]));
    }
  }

  static InputLimits read_limits(const TomlTable& agent, std::vector<double> u_min,
                                 std::vector<double> u_max) {
    if (!agent.has("limits")) {
      check_crossing(agent, agent.has("u_min") ? "u_min" : "u_max", u_min, u_max);
      return {std::move(u_min), std::move(u_max)};
    }
    for (const std::string_view key : {"u_min", "u_max"}) {
      if (agent.has(key)) agent.throw_invalid(key, "no such key beside limits, which has its own");
    }
    const TomlTable at = agent.table("limits");
    at.expect_only({"times", "u_min", "u_max"});
    const std::vector<double> times = at.rising("times");
    const auto lower = at.rows("u_min", times.size(), u_min.size()),
               upper = at.rows("u_max", times.size(), u_min.size());
    for (std::size_t k = 0; k < times.size(); ++k) check_crossing(at, "u_min", lower[k], upper[k]);
    return {times, lower, upper};
  }

  /// Reads a start by all states of the robot, in their order.
  static std::vector<double> read_whole_start(const TomlTable& at, const Model& model) {
    for (const std::string_view key : {"p", "heading", "v"}) {
      if (at.has(key)) at.throw_invalid(key, "no such key beside state, which has every state of the robot");
    }
    std::vector<double> x = at.numbers("state", static_cast<std::size_t>(model.nx()));
    if (!model.normalise(x.data())) at.throw_invalid("state", "a heading other than (0, 0)");
    return x;
  }

  /// The velocity state that moves a robot with heading (1, 0) along `way`, at 1 m/s for a value of
  /// 1 m/s; -1 if none does.
  static int velocity_along(const Model& model, const Vec3<double>& way) {
    const std::vector<double> u(static_cast<std::size_t>(model.nu()));
    for (const int state : roles_of(model).velocities) {
      std::vector<double> x = state_at_rest(model);
      const Vec3<double> resting = model.sight(x.data(), u.data()).v;
      x[size(state)] += 1.0;
      if (norm(model.sight(x.data(), u.data()).v - resting - way) < 1e-9) return state;
    }
    return -1;
  }

  std::vector<double> read_start(const TomlTable& at, const Model& model) {
    at.expect_only({"p", "heading", "v", "state"});
    if (at.has("state")) return read_whole_start(at, model);
    const double heading = at.has("heading") ? at.number("heading") : 0.0;
    std::vector<double> x(static_cast<std::size_t>(model.nx()));
    model.at_rest({at.vec3("p"), {cos(heading), sin(heading)}}, x.data());
    if (!model.turns() && heading != 0)
      at.throw_invalid("heading", fmt::format("0, {} has no heading", model.name()));
    if (!at.has("v")) return x;
    const int forward = velocity_along(model, {1, 0, 0}), sideward = velocity_along(model, {0, 1, 0});
    if (forward < 0) at.throw_invalid("v", fmt::format("no velocity, {} has none", model.name()));
    const std::vector<double> v = at.numbers("v", 2);
    x[size(forward)] = v[0];
    if (sideward >= 0) {
      x[size(sideward)] = v[1];
    } else if (v[1] != 0) {
      at.throw_invalid("v", 1, fmt::format("0, {} does not drive sideward", model.name()));
    }
    return x;
  }

  void read_bodies(std::string_view section, std::vector<BodyId>& ids) {
    const auto bodies = root_.named_tables(section);
    if (scenario_.targets.size() + bodies.size() > agents_max) {
      root_.throw_invalid(section, fmt::format("at most {} targets and obstacles", agents_max));
    }
    for (const auto& [name, at] : bodies) {
      UncooperativeStart read =
          read_uncooperative(at, [&](const TomlTable& table) { return agent_of(table); });
      const Vec3<double>&p = read.p, &v = read.v;
      scenario_.x0.insert(scenario_.x0.end(), {p.x, p.y, p.z, v.x, v.y, v.z});
      enter(name, at, [&, &n = name] { return scenario_.team.add(Obstacle{n}); });
      ids.push_back(read.uncooperative.body = bodies_.at(name));
      read_sight(at, read.uncooperative.body, {}, scenario_);
      scenario_.uncooperative.push_back(std::move(read.uncooperative));
      if (at.has("link")) (void)link_reader(at);
      scenario_.presence.push_back(is_present(at) ? Presence::hold : Presence::absent);
    }
  }

  static bool is_present(const TomlTable& at) { return !at.has("present") || at.boolean("present"); }

  /// Adds a body to the team under a new name that is valid in a topic.
  template <class Add>
  void enter(const std::string& name, const TomlTable& at, Add&& add) {
    const bool fit =
        !name.empty() && name.size() <= name_size_max && std::all_of(name.begin(), name.end(), [](char c) {
          return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
                 c == '-';
        });
    if (!fit) at.throw_invalid(fmt::format("a name of 1 to {} letters, digits, _ and -", name_size_max));
    if (bodies_.contains(name))
      at.throw_invalid("a name of its own, another robot, target or obstacle has this one");
    bodies_[name] = at.checked(add);
  }

  /// The robot named under `agent`.
  AgentId agent_of(const TomlTable& at) const {
    const std::string name = at.text("agent", "the name of a robot");
    const auto found = bodies_.find(name);
    if (found == bodies_.end() || !scenario_.team.is_agent(found->second)) {
      std::vector<std::string_view> known;
      for (const Agent& agent : scenario_.team.agents()) known.push_back(agent.name);
      at.throw_invalid("agent", "a robot" + hint(shortened(name, name_size_max), known));
    }
    return AgentId{found->second};
  }

  void read_constraints() {
    for (const TomlTable& at : root_.tables("constrain")) {
      if (at.has("limit")) {
        at.expect_only({"agent", "limit"});
      } else {
        at.expect_only({"name", "agent", "potential", "limit", "weight"});
      }
      const AgentId agent = agent_of(at);
      if (at.has("limit")) {
        const RelaxedBarrier barrier = read_limit(at);
        at.checked([&] { scenario_.team.constrain(barrier, agent); });
        continue;
      }
      const Weighted term = read_potential(at, observer_of(scenario_.team, observers_, agent));
      at.checked(
          [&] { scenario_.team.constrain({.term = term, .agent = agent, .name = name_or_place(at)}); });
    }
  }

  TomlTable root_;
  ScenarioSpec& scenario_;
  Observers observers_;
  std::unordered_map<std::string, BodyId> bodies_;
  std::vector<std::pair<std::string, Vec3<double>>> places_;  // starts of the robots that are present at
                                                              // first
};

}  // namespace

bool ScenarioSpec::operator==(const ScenarioSpec& other) const {
  const auto values = [](const ScenarioSpec& s) {
    return std::tie(s.name, s.text, s.files, s.horizon.T, s.horizon.N, s.horizon.dt, s.solver.name, s.world,
                    s.x0, s.presence, s.simulation.duration, s.simulation.seed, s.simulation.compare);
  };
  return values(*this) == values(other);
}

ScenarioSpec parse_spec(std::string text, const std::filesystem::path& file, const Registry& registry,
                        const ScenarioChanges& changes) {
  ScenarioSpec scenario;
  TomlDocument document = layered(text, file.native(), changes.set);
  document.registry = &registry;
  document.from_disk = !changes.files;
  if (changes.files) document.files = *changes.files;
  const bool in_layers = !document.layers.empty();
  if (in_layers) text = printed(document);
  expand(document);
  Reader(document, scenario).read();
  read_campaign(document, text, changes, scenario);
  if (in_layers) {  // a valid layered scenario is read again from its single text, as a log is
    auto places = std::move(scenario.coupling_places);
    auto campaign_refusal = std::move(scenario.campaign_refusal);
    scenario = parse_spec(std::move(text), file, registry, {.files = changes.files});
    scenario.coupling_places = std::move(places);
    if (campaign_refusal) scenario.campaign_refusal = std::move(campaign_refusal);
    return scenario;
  }
  scenario.name = one_line(file.stem().string());
  scenario.file = file;
  scenario.text = std::move(text);
  scenario.files = std::move(document.files);
  if (scenario.campaign) scenario.campaign->text = scenario.text;
  return scenario;
}

Scenario build(ScenarioSpec spec, const Registry& registry) {
  Scenario scenario{std::move(spec)};
  scenario.registry = std::make_shared<const Registry>(registry);
  for (const GoalOptions& of : scenario.goal_options) {
    const auto track = std::make_shared<GoalTrack>(scenario.team.model(of.robot), of.own, of.speed);
    scenario.goals.push_back({of.robot, track});
    scenario.team.set_reference(AgentId{of.robot}, GoalTrack::reference(track));
  }
  return scenario;
}

Scenario parse_scenario(std::string text, const std::filesystem::path& file, const Registry& registry,
                        const ScenarioChanges& changes) {
  return build(parse_spec(std::move(text), file, registry, changes), registry);
}

Scenario read_scenario(const std::filesystem::path& file, const Registry& registry,
                       const std::vector<std::string>& set) {
  return parse_scenario(read_text(file), file, registry, {.files = {}, .set = set});
}

const RobotVehicle* vehicle_of(const ScenarioSpec& scenario, BodyId body) {
  const auto& vehicles = scenario.vehicles;
  const auto found = std::find_if(vehicles.begin(), vehicles.end(),
                                  [&](const RobotVehicle& vehicle) { return vehicle.robot == body; });
  return found != vehicles.end() ? &*found : nullptr;
}

PlantOptions plant_options(const ScenarioSpec& scenario) {
  PlantOptions options{.seed = scenario.simulation.seed,
                       .disturbances = scenario.simulation.disturbances,
                       .period = scenario.horizon.dt,
                       .motions = {},
                       .downwash = scenario.downwash};
  for (const UncooperativeBody& uncooperative : scenario.uncooperative) {
    if (uncooperative.motion) options.motions.push_back({uncooperative.body, *uncooperative.motion});
    options.speed_max.push_back(uncooperative.speed_max);
  }
  return options;
}

PlantOptions plant_options(const Scenario& scenario) {
  PlantOptions options = plant_options(static_cast<const ScenarioSpec&>(scenario));
  options.pool = scenario.pool;
  return options;
}

bool plans_apart(const ScenarioSpec& scenario) { return scenario.partition && scenario.partition->apart(); }

bool changes_in_flight(const Scenario& scenario) {
  return scenario.tuned != nullptr || changes_in_flight(static_cast<const ScenarioSpec&>(scenario));
}

bool changes_in_flight(const ScenarioSpec& spec) {
  const auto& presence = spec.presence;
  return !spec.script.empty() ||
         std::find(presence.begin(), presence.end(), Presence::absent) != presence.end();
}

std::string summary(const ScenarioSpec& scenario) {
  const Team& team = scenario.team;
  const Horizon& horizon = scenario.horizon;
  const Simulation& simulation = scenario.simulation;
  std::string text;
  const auto line = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
    text += '\n';
  };
  line("scenario    {}", scenario.name);
  line("horizon     {} s, {} stages, period {} s", horizon.T, horizon.N, horizon.dt);
  line("solver      {}", scenario.solver.name);
  if (scenario.world != "model")
    line("world       {}{}{}", scenario.world, scenario.model ? " with " + scenario.model->name : "",
         scenario.downwash.scale > 0 ? fmt::format(", downwash {}", scenario.downwash.scale) : "");
  line("simulation  {} s, {:.0f} updates, seed {}", simulation.duration,
       std::round(simulation.duration / horizon.dt), simulation.seed);
  line("team        {} states, {} inputs", team.nx(), team.nu());
  for (const Agent& agent : team.agents()) {
    const bool present =
        scenario.presence[static_cast<std::size_t>(team.find(agent.name).index)] != Presence::absent;
    line("agent       {}: {}, {} states, {} inputs{}", agent.name, agent.model.name(), agent.model.nx(),
         agent.model.nu(), present ? "" : ", not there at first");
    if (!agent.rate_max.empty())
      line("rates       {}: inputs move by at most {} 1/s", agent.name, fmt::join(agent.rate_max, ", "));
    if (!agent.R_rate.empty())
      line("rates       {}: of inputs cost {} s^2", agent.name, fmt::join(agent.R_rate, ", "));
  }
  for (const RobotCompensation& of : scenario.compensations) {
    line("compensate  {}: commands act after {} s{}{}", team.name(of.robot), of.command_delay,
         of.disturbance_time > 0 ? fmt::format(", disturbance estimated over {} s", of.disturbance_time) : "",
         of.feed_forward == FeedForwardFrom::reference ? ", u* follows from its reference" : "");
  }
  for (const RobotVehicle& vehicle : scenario.vehicles) {
    line("vehicle     {}: {}", team.name(vehicle.robot), describe(vehicle));
    if (norm(simulation.disturbances.wind) == 0) continue;
    const Vec3<double> air = vehicle.vehicle.air(simulation.disturbances.wind);
    line("vehicle     {}: feels the wind as air at [{:.2f}, {:.2f}, {:.2f}] m/s", team.name(vehicle.robot),
         air.x, air.y, air.z);
  }
  if (scenario.partition) text += describe(*scenario.partition);
  if (scenario.links) line("{}", scenario.links->describe(team));
  text += camera_words(scenario) + localization_words(scenario);
  for (const UncooperativeBody& uncooperative : scenario.uncooperative) {
    const auto& targets = scenario.targets;
    const bool target = std::find(targets.begin(), targets.end(), uncooperative.body) != targets.end();
    line("{:12}{}", target ? "target" : "obstacle", describe(uncooperative, team));
  }
  for (const Coupling& coupling : team.couplings()) {
    std::string feeling;
    for (const AgentId id : coupling.felt_by)
      feeling += fmt::format("{}{}", feeling.empty() ? "" : ", ", team.name(id));
    const std::string past = coupling.has_third() ? fmt::format(" past {}", team.name(coupling.third)) : "";
    line("couple      {} {} between {} and {}{}, felt by {}", coupling.term.weight,
         coupling.term.potential.name(), team.name(coupling.between.first),
         team.name(coupling.between.second), past, feeling);
  }
  for (const Swarm& swarm : team.swarms()) {
    line("keep_apart  {} {} between pairs of {} robots within {} m, at most {} at one time",
         swarm.term.weight, swarm.term.potential.name(), swarm.agents.size(), swarm.radius, swarm.capacity);
  }
  for (const Constraint& constraint : team.constraints())
    line("constrain   {} {} of {}", constraint.term.weight, constraint.term.potential.name(),
         team.name(constraint.agent));
  for (const BarrierTerm& term : team.barriers())
    line("constrain   limit {} of {}, mu {}, delta {}", term.barrier.limit.name(), team.name(term.agent),
         term.barrier.mu, term.barrier.delta);
  for (const TeamEvent& event : scenario.script.events) line("event       {}", describe(event, team));
  if (scenario.safety) text += describe(*scenario.safety);
  for (const CertifiedView& view : scenario.certified_views) text += describe(view, team);
  return text + describe(simulation, team);
}

}  // namespace sightline
