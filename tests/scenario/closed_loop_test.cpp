#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "sightline/registry.hpp"
#include "sightline/robots.hpp"
#include "sightline/scenario.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/sample_sink.hpp"

namespace sightline {
namespace {

/// All that a sample holds of simulated time, as bytes.
void append(std::string& bytes, const Sample& sample) {
  const auto add = [&](const void* from, std::size_t size) {
    bytes.append(static_cast<const char*>(from), size);
  };
  for (const auto* list : {&sample.x, &sample.measured, &sample.u, &sample.raw_u})
    add(list->data(), list->size() * sizeof(double));
  if (sample.has_path) add(sample.path.data(), sample.path.size() * sizeof(double));
  for (const SolverRecord& record : sample.solvers) {
    add(&record.status, sizeof record.status);
    add(&record.residual, sizeof record.residual);
    add(&record.iterations, sizeof record.iterations);
  }
}

/// One sample, used again each period: no ring, no thread.
class Kept final : public test::SampleSink {
 public:
  using SampleSink::SampleSink;
  void publish() noexcept override { append(bytes, sample_); }
  void close() noexcept override { ++closed; }

  std::string bytes;
  int closed = 0;
};

Scenario scenario(const std::string& name, double duration) {
  Scenario read = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/" + name + ".toml");
  read.simulation.duration = duration;
  read.simulation.disturbances.gust_sigma = 0.3;
  read.simulation.disturbances.noise = {0.01, 0.01, 0.01};
  return read;
}

std::string flown(const Scenario& scenario, Solver& solver) {
  const Controllers controllers = {solver};
  SimulatedClock clock;
  Kept sink(sized_sample(scenario.team, controllers));
  const LoopOutcome outcome = ClosedLoop(scenario, *make_world(scenario), controllers, clock, sink).fly();
  EXPECT_TRUE(outcome.finite);
  EXPECT_EQ(outcome.updates, std::llround(scenario.simulation.duration / scenario.horizon.dt));
  EXPECT_EQ(sink.closed, 1);
  return sink.bytes;
}

TEST(ClosedLoop, ASinkWithoutARingSeesTheSamplesOfTheRing) {
  const Scenario flight = scenario("cooperative_localization", 1.0);
  const auto solver = make_solver(flight.solver, flight.team, flight.horizon);
  const Controllers controllers = {*solver};
  SimulatedClock clock;
  SpscQueue<Sample> ring(4, sized_sample(flight.team, controllers));
  const auto world = make_world(flight);
  ClosedLoop loop(flight, *world, controllers, clock, ring);
  std::string bytes;
  std::thread log([&] {
    for (; const Sample* sample = ring.wait(); ring.pop()) append(bytes, *sample);
  });
  EXPECT_EQ(loop.fly().dropped, 0);
  log.join();

  const auto another = make_solver(flight.solver, flight.team, flight.horizon);
  EXPECT_EQ(flown(flight, *another), bytes);
}

/// What changes the team, and how late the sample that says so is [s].
class EventDelays final : public test::SampleSink {
 public:
  using SampleSink::SampleSink;
  void publish() noexcept override {
    for (const Event& event :
         std::span(sample_.events).first(static_cast<std::size_t>(sample_.event_count))) {
      if (event.kind != EventKind::event_in_force) continue;
      ++in_force;
      latest = std::max(latest, sample_.time - event.time);
    }
  }

  int in_force = 0;
  double latest = 0.0;
};

TEST(ClosedLoop, TheFirstSampleOfANewTeamSaysSoHoweverManyEventsItsPeriodHas) {
  constexpr int many = 40;
  std::string text = "[horizon]\nperiod = 0.1\n[simulation]\nduration = 1.0\n";
  for (int i = 0; i < many; ++i)
    text += fmt::format("[agent.r{0}]\nrobot = \"point_mass\"\nstart = {{ p = [{0}.0, 0.0, 1.0] }}\n", i);
  for (int i = 0; i < many; ++i)
    text +=
        fmt::format("[[event]]\nat = 0.4\nretune = {{ agent = \"r{}\", R = [1.0, 1.0, {}.0] }}\n", i, i + 1);
  text += "[[simulation.fault]]\nkind = \"nan\"\nfrom = 0.3\n[safety]\n[safety.supervisor]\n";
  const Scenario flight = parse_scenario(text, "many.toml");
  const Controls controls(flight);
  SimulatedClock clock;
  EventDelays sink(sized_sample(flight.team, controls.controllers(), controls.team_switcher()));
  ClosedLoop(flight, *make_world(flight), controls.controllers(), clock, sink, nullptr,
             controls.team_switcher())
      .fly();
  EXPECT_EQ(sink.in_force, many);
  EXPECT_EQ(sink.latest, 0.0);
}

// Whatever a solver flew before: restarted, it flies as a new one, bit for bit.
TEST(ClosedLoop, ARestartedSolverFliesAsANewOne) {
  for (const std::string name : {"cooperative_localization", "paper_7_1", "paper_7_1_joint"}) {
    for (const std::string_view solver_name : solver_names()) {
      Scenario flight = scenario(name, 1.0);
      flight.solver = solver_named(solver_name);
      Scenario other = flight;
      other.x0[0] = 4.0, other.x0[5] = -2.0, other.x0[3] = -1.0;
      other.simulation.seed = 9;
      const auto fresh = make_solver(flight.solver, flight.team, flight.horizon),
                 used = make_solver(flight.solver, flight.team, flight.horizon);
      flown(other, *used);
      used->restart();
      EXPECT_EQ(flown(flight, *used), flown(flight, *fresh)) << name << " " << solver_name;
    }
  }
}

TEST(ClosedLoop, ASolverThatAScenarioAsksTooMuchOfIsRefusedWithTheNeedAndThoseThatCan) {
  Scenario changing = scenario("handover", 1.0), swarm = scenario("swarm32", 1.0);
  for (const std::string_view name : {"cmscgmres", "cgmres"}) {
    changing.solver = swarm.solver = solver_named(name);
    EXPECT_EQ(
        refusal_of([&] { check_solvers(changing); }),
        fmt::format("the team changes in flight, which the solver {} cannot follow, expected newton_riccati",
                    name));
    EXPECT_EQ(refusal_of([&] { check_solvers(swarm); }),
              fmt::format("the solver {} knows no keep_apart, expected newton_riccati", name));
  }
  changing.solver = swarm.solver = solver_named("newton_riccati");
  EXPECT_NO_THROW(check_solvers(changing));
  EXPECT_NO_THROW(check_solvers(swarm));
  changing.simulation.compare = {"cgmres"};
  EXPECT_NE(refusal_of([&] { check_solvers(changing); }), "") << "what is compared flies the same";
  EXPECT_EQ(built_in_registry().solvers.names_that(&SolverAbilities::changing_teams), "newton_riccati");
}

TEST(ClosedLoop, EachSolverHasTheAbilitiesOfItsEntry) {
  Team one, rated;
  one.add(PointMass{});
  rated.add(PointMass{}, {.R_rate = {1, 1, 1}});
  for (const std::string_view name : solver_names()) {
    const SolverAbilities can = built_in_registry().solvers.named(name).can;
    const auto solver = make_solver(solver_named(name), one, Horizon{});
    EXPECT_EQ(can.changing_teams, solver->team_planner() != nullptr) << name;
    EXPECT_EQ(can.keep_apart, solver->keeps_apart()) << name;
    EXPECT_EQ(can.uncertain_views, solver->uses_uncertainty()) << name;
    EXPECT_EQ(can.input_rates, refusal_of([&] { make_solver(solver_named(name), rated, Horizon{}); }).empty())
        << name;
  }
}

TEST(ClosedLoop, ACostOfRatesIsRefusedBeforeAnythingFliesByASolverThatHasNone) {
  const std::string text =
      "[agent.uav]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\nR_rate = [1, 1, 1, 1]\n";
  Scenario smooth = parse_scenario(text, "smooth.toml");
  EXPECT_EQ(refusal_of([&] { check_solvers(smooth); }), "");
  const std::string sentence =
      "uav has a cost of its inputs' rates, R_rate, expected the solver newton_riccati, which plans with it";
  smooth.simulation.compare = {"cmscgmres"};
  EXPECT_EQ(refusal_of([&] { check_solvers(smooth); }), sentence);
  smooth.simulation.compare = {};
  smooth.solver = solver_named("cgmres");
  EXPECT_EQ(refusal_of([&] { check_solvers(smooth); }), sentence);
}

TEST(ClosedLoop, InSimulatedTimeNoDeadlineActs) {
  SolverChoice choice{.options = NewtonRiccatiOptions{.deadline = 1e-3, .start_steps = 7}};
  lift_deadline(choice);
  EXPECT_EQ(std::get<NewtonRiccatiOptions>(choice.options).deadline, 0.0);
  EXPECT_EQ(std::get<NewtonRiccatiOptions>(choice.options).start_steps, 7);
  SolverChoice without = solver_named("cgmres");
  EXPECT_NO_THROW(lift_deadline(without));
}

TEST(ClosedLoop, AStartThatIsNoStateIsRefused) {
  Scenario flight = scenario("cooperative_localization", 1.0);
  flight.x0[3] = flight.x0[4] = 0.0;
  const auto solver = make_solver(flight.solver, flight.team, flight.horizon);
  const Controllers controllers = {*solver};
  SimulatedClock clock;
  Kept sink(sized_sample(flight.team, controllers));
  EXPECT_THROW(ClosedLoop(flight, *make_world(flight), controllers, clock, sink), std::invalid_argument);
}

TEST(ClosedLoop, FliesInTheWorldThatTheScenarioNames) {
  const std::string text = test::read_file(SIGHTLINE_SOURCE_DIR "/scenarios/paper_7_1.toml");
  int made = 0;
  Registry registry;
  registry.worlds.add("windy", [&made](const Scenario& scenario) -> std::unique_ptr<World> {
    ++made;
    PlantOptions options = plant_options(scenario);
    options.disturbances.wind = {0.5, 0, 0};
    return std::make_unique<ModelWorld>(scenario.team, scenario.x0, options, sensor_options(scenario));
  });
  const auto in = [&](std::string_view kind) {
    Scenario flight =
        parse_scenario(text + "\n[world]\nkind = \"" + std::string(kind) + "\"\n", "t.toml", registry);
    flight.simulation.duration = 1.0;
    const auto solver = make_solver(flight.solver, flight.team, flight.horizon);
    return flown(flight, *solver);
  };
  Scenario plain = parse_scenario(text, "t.toml", registry);
  plain.simulation.duration = 1.0;
  const auto solver = make_solver(plain.solver, plain.team, plain.horizon);
  EXPECT_EQ(in("model"), flown(plain, *solver)) << "the default";
  EXPECT_NE(in("windy"), in("model"));
  EXPECT_EQ(made, 1);
  EXPECT_THROW(in("winy"), ScenarioError);
}

TEST(ClosedLoop, AWorldIsRegisteredOnceByAWord) {
  Registry registry;
  const MakeWorld make = registry.worlds.find("model")->make;
  EXPECT_THROW(registry.worlds.add("model", make), std::invalid_argument);
  EXPECT_THROW(registry.worlds.add("My World", make), std::invalid_argument);
  EXPECT_THROW(registry.worlds.add("nothing", {}), std::invalid_argument);
  EXPECT_EQ(registry.worlds.names().size(), 2U);
}

}  // namespace
}  // namespace sightline
