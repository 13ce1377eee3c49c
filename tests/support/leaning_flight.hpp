/// An observer whose camera leans with its body, and a target that flies a circle fast, both x500
/// in the world "rotors".
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "sightline/judge/planned_view.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/sample_sink.hpp"

namespace sightline::test {

struct LeaningTask {
  std::string_view frame = "body";         ///< of the camera
  double radius = 1.33, speed = 2.0;       ///< of the target's circle [m], [m/s]
  double bearing = 16.0, position = 60.0;  ///< weights: view, the target's place on its circle
  bool estimates = true;                   ///< with disturbance_time
  std::string_view world = "rotors";
  double duration = 20.0;
  Vec3<double> wind{};  ///< [m/s^2]
};

/// cooperative_localization with hover_multirotor and its lags, for vehicles that tilt by up to 0.4
/// rad: b = 4.17 m/s^2.
inline Scenario leaning_scenario(const LeaningTask& task) {
  static const std::string text = [] {
    std::string all = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/cooperative_localization.toml").text;
    return all.erase(all.find("[safety]"), all.find("[simulation]") - all.find("[safety]"));
  }();
  const std::string numbers =
      "{ preset = \"x500\", b_f = 4.17, b_s = 4.17, tau = 0.121, tau_z = 0.231, tau_psi = 0.16 }";
  const std::string zeros = "[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]";
  std::vector<std::string> set = {
      fmt::format("world.kind=\"{}\"", task.world),
      fmt::format("agent.uav0.sensor.frame=\"{}\"", task.frame),
      fmt::format("couple[0].weight={}", task.bearing),
      fmt::format("agent.uav1.reference.circle.rate={}", task.speed / task.radius),
      fmt::format("agent.uav1.reference.circle.radius={}", task.radius),
      "agent.uav1.reference.circle.centre=[0.0, 0.0, 1.5]",
      fmt::format("agent.uav1.start.p=[{}, 0.0, 1.5]", task.radius),
      "agent.uav0.start.p=[-1.5, 0.0, 2.0]",
      "agent.uav0.reference.state=" + zeros,
      "agent.uav0.Q=" + zeros,
      fmt::format("agent.uav1.Q=[{0}, {0}, {0}, 1, 1, 0, 0, 0, 0, 0, 0]", task.position)};
  for (const char* const uav : {"uav0", "uav1"}) {
    const auto of = [&](std::string_view key, std::string_view value) {
      set.push_back(fmt::format("agent.{}.{}={}", uav, key, value));
    };
    of("robot", "\"hover_multirotor\"");
    of("parameters", numbers);
    of("Q_f", zeros);
    if (task.world != "model") of("command_delay", "0.036");
    if (task.estimates) of("disturbance_time", "0.5");
    if (task.world != "model") of("vehicle.tilt_max", "0.4");
  }
  Scenario scenario = parse_scenario(text, "leaning.toml", built_in_registry(), {.set = set});
  scenario.simulation.duration = task.duration;
  scenario.simulation.settle = 6.0;
  scenario.simulation.disturbances.wind = task.wind;
  return scenario;
}

/// Hands each sample to a Summary.
class Judged final : public SampleSink {
 public:
  Judged(const Scenario& judged, Sample prototype) : SampleSink(std::move(prototype)), summary(judged, 1) {}
  void publish() noexcept override {
    summary.add(sample_);
    x.insert(x.end(), sample_.x.begin(), sample_.x.end());
  }

  Summary summary;
  std::vector<double> x;  // of all samples
};

/// What a flight of a scenario is, as another one judges it.
inline Judged fly_judged(const Scenario& scenario, const Scenario& judged) {
  const Controls controls(scenario);
  const auto world = make_world(scenario);
  SimulatedClock clock;
  Sample prototype = sized_sample(*world, controls.controllers());
  make_room_for_plans(judged, prototype);
  Judged flight(judged, std::move(prototype));
  ClosedLoop(scenario, *world, controls.controllers(), clock, flight).fly();
  return flight;
}

/// What a flight under `planned` is by the true camera, which is fixed to the body however it was
/// planned.
inline Judged fly_leaning(const LeaningTask& planned) {
  LeaningTask seen = planned;
  seen.frame = "body";
  return fly_judged(leaning_scenario(planned), leaning_scenario(seen));
}

}  // namespace sightline::test
