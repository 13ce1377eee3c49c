/// Scenarios of one multirotor that is to be identified, and flights of a task to judge what was
/// found.
#pragma once

#include <fmt/format.h>

#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include "sightline/analysis/identification/identify.hpp"
#include "sightline/robots.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/sample_sink.hpp"

namespace sightline::test {

/// The noise of motion capture and a filter behind it: 5 mm, 0.01 rad, 0.03 m/s.
inline constexpr std::string_view usual_noise =
    "noise = { position = 0.005, heading = 0.01, velocity = 0.03 }";

/// A multirotor alone, called uav.
/// @param robot  its keys: robot = ..., parameters = ...
/// @param nx     of that robot
/// @param rest   tables that follow
inline Scenario alone(const std::string& robot, int nx, const std::string& disturbance = "",
                      const std::string& rest = "") {
  std::string Q;
  for (int i = 0; i < nx; ++i) Q += i == 0 ? "1.0" : ", 1.0";
  return parse_scenario(
      fmt::format(
          "[agent.uav]\n{}\nstart = {{ p = [0.0, 0.0, 3.0], heading = 0.4 }}\nQ = [{}]\nR = [1.0, 1.0, "
          "1.0, 1.0]\n[simulation]\nduration = 10.0\n[simulation.disturbance]\n{}\n{}",
          robot, Q, disturbance, rest),
      "alone.toml");
}

/// One of the presets of vehicles, which a multirotor of (24) plans.
inline Scenario vehicle(std::string_view preset, std::string_view noise = usual_noise) {
  return alone("robot = \"multirotor\"", 7, std::string(noise),
               fmt::format("[world]\nkind = \"rotors\"\n[agent.uav.vehicle]\npreset = \"{}\"\n", preset));
}

inline AgentId uav(const Scenario& scenario) { return identified_robot(scenario.team, "uav"); }

/// The excitation of that robot, identified.
inline Identification identified(const Scenario& scenario, const ExcitationOptions& options = {}) {
  return identify(fly_excitation(scenario, uav(scenario), options), options.kind);
}

inline double number(const FittedModel& model, std::string_view key) {
  for (const FoundNumber& one : model.found) {
    if (one.number.key == key) return one.value;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// A world that writes down how one of its robots is commanded and moves.
class WrittenDown final : public World {
 public:
  WrittenDown(World& world, AgentId robot, double period)
      : world_(world), robot_(robot), motion_(motion_of(world.team(), robot, period)) {}

  const Team& team() const noexcept override { return world_.team(); }
  std::span<const double> start() const noexcept override { return world_.start(); }
  void set_presence(std::span<const Presence> presence) noexcept override { world_.set_presence(presence); }
  Measured measure(double t) noexcept override { return now_ = world_.measure(t); }
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override {
    const std::size_t x = size(team().state_offset(robot_)), from = size(team().input_offset(robot_));
    motion_.add(team().model(robot_), &now_.measured[x], t - now_.stamps[at(robot_)], &now_.truth[x],
                {u[from], u[from + 1], u[from + 2], u[from + 3]});
    return world_.apply(t, estimated, u, period, periods);
  }
  const FlownMotion& motion() const { return motion_; }

 private:
  World& world_;
  AgentId robot_;
  FlownMotion motion_;
  Measured now_;
};

/// How a robot of cooperative_localization flies its task as a vehicle.
inline FlownMotion task_flight(std::string_view preset, const std::string& robot, double seconds) {
  std::ostringstream text;
  text << std::ifstream(SIGHTLINE_SOURCE_DIR "/scenarios/cooperative_localization.toml").rdbuf();
  const std::string scene = fmt::format(
      "{}\n[world]\nkind = \"rotors\"\n[agent.uav0.vehicle]\npreset = \"{}\"\n[agent.uav1.vehicle]\npreset = "
      "\"{}\"\n",
      std::regex_replace(text.str(), std::regex("\nduration = 60.0"),
                         fmt::format("\nduration = {}", seconds)),
      preset, preset);
  const Scenario scenario = parse_scenario(scene, "task.toml");
  const Controls controls(scenario);
  const auto world = make_world(scenario);
  WrittenDown written(*world, identified_robot(scenario.team, robot), scenario.horizon.dt);
  SimulatedClock clock;
  SampleSink sink(sized_sample(written, controls.controllers()));
  ClosedLoop loop(scenario, written, controls.controllers(), clock, sink);
  (void)loop.fly();
  return written.motion();
}

/// On another flight, in calm air.
inline PredictionError judged_on(const FlownMotion& motion, const FittedModel& model) {
  ModelNumbers numbers = model.numbers;
  numbers.w_x = numbers.w_y = 0.0;
  return prediction_error(motion, {0, motion.size()}, model.structure, numbers);
}

}  // namespace sightline::test
