/// What the stages of a control loop pass on within a period. Each stage is an object with
///
///   void run(Period& period) noexcept;
///
/// that reads what the stages before it have written. No stage allocates, locks, throws or prints.
#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/loop.hpp"
#include "sightline/world.hpp"

namespace sightline::stages {

struct Period {
  Period(const World& world, const LoopOptions& options, std::vector<Presence> present)
      : count_allocations(options.allocations),
        measured(world.team(), world.start()),
        presence(std::move(present)),
        u(size(world.team().nu())),
        planned_at(size(world.team().bodies())),
        gate(world.team(), options.period) {}

  void emit(const Event& event) noexcept {
    if (events.size() < events.capacity()) events.push_back(event);
  }
  std::int64_t allocations() const noexcept { return count_allocations != nullptr ? count_allocations() : 0; }

  std::int64_t (*count_allocations)() noexcept;
  std::int64_t k = 0;        // number of the period
  double t = 0.0;            // its begin [s]
  Sample* sample = nullptr;  // its record

  Measured seen{};                                // as measured, then as localized
  std::chrono::steady_clock::time_point began{};  // after the measurement
  std::int64_t allocated = 0;                     // the same
  ValidStates measured;                           // of `seen`
  const ValidStates* estimate = &measured;        // at the last update
  const ValidStates* met = &measured;             // where the commands take effect
  double lead = 0.0;                              // longest time from a command to its effect [s]
  std::span<const double> added{};                // offset to the inputs of all robots (nu)
  std::span<const Vec2<double>> added_lean{};     // tilt of each body due to `added`
  std::vector<Presence> presence;                 // of each body
  std::vector<double> u;                          // inputs of all robots (nu), without `added`
  std::vector<double> planned_at;                 // of each body: time of its last good plan [s]
  CommandGate gate;
  std::vector<Event> events{};  // not yet in a sample
  LoopOutcome outcome{};
};

}  // namespace sightline::stages
