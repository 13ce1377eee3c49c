/// Vehicles that are stood in for and their flyer, in one program.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "bridges/dds/dds_world.hpp"
#include "bridges/dds/simulators/px4_vehicle.hpp"
#include "cli/allocations.hpp"
#include "cli/linked_sink.hpp"
#include "sightline/scenario.hpp"
#include "tests/dds/own_domain.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline::dds {

using Fields = std::vector<std::string>;
using Kind = LinkFaultKind;

/// Robots in a row, 3 m apart, of these releases. From number `absent` on they are absent at first.
inline Scenario row_of(const Fields& releases, double duration, const std::string& more = "",
                       const std::string& kind = "model", const std::string& barrier = "on",
                       std::size_t absent = 1000) {
  std::string text = fmt::format(
      "[fleet]\ndomain = {}\n[world]\nkind = \"{}\"\n[simulation]\nduration = {}\n"
      "[safety]\nbarrier = \"{}\"\nfloor = 0.2\nposition_sigma = 0.01\nheading_sigma = "
      "0.01\n[safety.supervisor]\nfresh = 0.05\n",
      test::own_domain(), kind, duration, barrier);
  for (std::size_t i = 0; i < releases.size(); ++i) {
    text += fmt::format(
        "[agent.uav{0}]\nrobot = \"multirotor\"\nstart = {{ p = [{1}, 0.0, 0.6], heading = 1.0 }}\nQ = [1.5, "
        "1.5, 1.6, 0, 0, 0, 0]\n"
        "reference = {{ circle = {{ centre = [{1}, 0.0, 0.8], radius = 0.3, rate = 0.5 }} }}\n{3}"
        "[agent.uav{0}.link]\nkind = \"px4\"\nrelease = \"{2}\"\nnamespace = \"/px4_{0}\"\n"
        "origin = {{ p = [{1}, 0.1, 0.2], heading = 0.4 }}\n",
        i, 3.0 * static_cast<double>(i), releases[i], i < absent ? "" : "present = false\n");
  }
  return test::scenario_of(text + more);
}

/// A rover of ROS 2 alone, whose odometry is in this frame.
inline Scenario rover_in(const std::string& frame) {
  return test::scenario_of(fmt::format(
      "[fleet]\ndomain = {}\n[agent.r]\nrobot = \"unicycle\"\nstart = {{ p = [0, 0, 0] }}\n"
      "[agent.r.link]\nkind = \"ros2\"\nodometry = \"/r/odom\"\ncmd_vel = \"/r/cmd_vel\"\nframe = \"{}\"\n",
      test::own_domain(), frame));
}

struct NullSink final : Sink<Sample> {
  explicit NullSink(Sample prototype) : sample(std::move(prototype)) {}
  Sample* claim() noexcept override { return &sample; }
  void publish() noexcept override {
    for (int i = 0; i < sample.event_count; ++i)
      occurred.at(static_cast<std::size_t>(sample.events[static_cast<std::size_t>(i)].kind)) += 1;
  }
  void close() noexcept override {}
  Sample sample;
  std::array<int, event_kinds> occurred{};
};

/// Simulated vehicles have published all of their states, and accept set-points, sooner than a
/// vehicle.
inline LinkTimes of_vehicle_simulators(LinkTimes times) {
  times.listened = 0.8;
  times.received = 0.3;
  return times;
}

/// Vehicles and their flyer, on one domain of this program.
class Rig {
 public:
  explicit Rig(const Scenario& flown, const LinkTimes& times = {}) : Rig(flown, flown, times) {}
  Rig(const Scenario& flown, const Scenario& vehicles, const LinkTimes& times)
      : scenario(flown),
        domain(std::make_shared<Domain>(fleet_of(flown).network)),
        vehicle_simulators(vehicles, domain, 0.05),
        stepping([this] { vehicle_simulators.run(1e9, stepped, {}); }),
        world(std::make_unique<DdsWorld>(scenario, domain, of_vehicle_simulators(times))) {}
  ~Rig() {
    world.reset();
    stepped = 1;
    stepping.join();
  }

  bool take_off(Arming arming = Arming::real) {
    return world->take_off(arming, interrupts,
                           [this](std::string_view sentence) { reported.emplace_back(sentence); });
  }
  void land() {
    world->land(interrupts, [this](std::string_view sentence) { reported.emplace_back(sentence); });
  }
  /// Takes off, flies the task, lands; meanwhile `happens` after so long of the task [s].
  LoopOutcome fly(double after = 0, const std::function<void()>& occurs = {}, Arming arming = Arming::real) {
    const Controls controls(scenario);
    SteadyClock clock;
    switcher = controls.team_switcher();
    NullSink sink(sized_sample(*world, controls.controllers(), switcher));
    cli::LinkedSink shown(sink, *world, stop);
    ClosedLoop loop(scenario, *world, controls.controllers(), clock, shown, cli::allocations, switcher,
                    &stop);
    LoopOutcome outcome;
    if (!take_off(arming)) return outcome;
    std::thread other([&] {
      std::this_thread::sleep_for(std::chrono::duration<double>(after));
      if (occurs) occurs();
    });
    outcome = loop.fly();
    other.join();
    occurred = sink.occurred;
    last = sink.sample;
    if (dynamic_cast<Px4Vehicle*>(&vehicle_simulators.of(0)) != nullptr) after_task = counts_of(0);
    land();
    return outcome;
  }

  template <class S>
  S& as(std::size_t i) {
    return dynamic_cast<S&>(vehicle_simulators.of(i));
  }
  Px4Vehicle& vehicle(std::size_t i) { return dynamic_cast<Px4Vehicle&>(vehicle_simulators.of(i)); }
  Faults& faults(std::size_t i) { return vehicle_simulators.faults(i); }
  Px4VehicleCounts counts_of(std::size_t i) { return vehicle(i).reported(); }
  /// The first line of the flyer's counts that has these words; empty: none.
  std::string counted(std::string_view words) const {
    for (const std::string& line : world->counts())
      if (line.find(words) != std::string::npos) return line;
    return {};
  }
  LinkState state(int i) const { return world->state(BodyId{i}); }

  Scenario scenario;
  Interrupts interrupts{0}, stepped{0};
  std::atomic<bool> stop{false};
  std::shared_ptr<Domain> domain;
  DdsVehicleSimulators vehicle_simulators;
  std::thread stepping;
  std::unique_ptr<DdsWorld> world;
  Fields reported;
  int count(EventKind kind) const { return occurred.at(static_cast<std::size_t>(kind)); }

  std::array<int, event_kinds> occurred{};  // events of the task, by kind
  TeamSwitcher* switcher = nullptr;         // of the task, while it is flown
  Px4VehicleCounts after_task;
  Sample last;  // of the task
};

/// What a flyer says that must not take off, and is given up after so long [s].
inline Fields not_ready(const Scenario& scenario, const std::shared_ptr<Domain>& domain, double seconds) {
  DdsWorld world(scenario, domain, {.ready = seconds});
  Fields reported;
  const Interrupts none{0};
  EXPECT_FALSE(world.take_off(Arming::real, none, [&](std::string_view s) { reported.emplace_back(s); }));
  return reported;
}

/// Of each vehicle: few requests, never a set-point where it takes none, all numbers fit.
inline void expect_well_treated(Rig& rig) {
  for (std::size_t i = 0; i < fleet_of(rig.scenario).links.size(); ++i) {
    const Px4VehicleCounts n = rig.counts_of(i);
    EXPECT_LE(std::max(n.arm_requests, n.offboard_requests), LinkTimes{}.attempts) << i;
    EXPECT_EQ(n.setpoints_outside, 0) << i;
    EXPECT_EQ(n.bad_setpoints, 0) << i;
  }
}

}  // namespace sightline::dds
