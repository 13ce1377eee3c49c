/// What flies robots that are not simulated: a bridge to them, which a program adds to its Registry.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/run/sample.hpp"
#include "sightline/scenario/finding.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/solver/distributed/part_solver.hpp"
#include "sightline/world/world.hpp"

namespace sightline {

/// How often a person asked to end: once, and all land; twice, and they are left to their autopilots.
using Interrupts = std::atomic<int>;
/// Takes a sentence for a person. Between take_off() and land() called by a thread of the bridge, else by its caller's; never by two.
using PrintMessage = std::function<void(std::string_view)>;

enum class Arming {
  real,
  on_call,  ///< not before somebody calls for it, by what the bridge offers others
  dry_run,
};

/// How a flight kept time, while its task was flown. Times in s.
struct LinkTiming {
  struct Delay {
    double median = 0.0, p99 = 0.0, most = 0.0;
  };
  std::int64_t periods = 0, missed = 0;  ///< missed: over before they could begin; of `periods`
  Delay wake{};                          ///< from a period's begin until the loop runs
  Delay arrival{};                       ///< from the stamp of a pose to us; 0 where clocks differ
  double cpu = 0.0;                      ///< of one core, by the whole program
};

/// Robots that are reached over links, as a world. Time 0 is the first measure().
///
/// take_off(), a Loop that flies in it, land(): by one thread. Each call of apply() keeps the robots in flight; where none comes for
/// half a second, autopilots do what they do without a companion.
class LinkedWorld : public World {
 public:
  /// Waits for the robots, checks them, arms them, and brings them to where they hold. Returns too when a person asks to end.
  /// @return false where not all of them hold; faults() says why
  virtual bool take_off(Arming arming, const Interrupts& interrupts, const PrintMessage& print) = 0;
  /// Brings all that fly to the ground. Returns when none is left to care for, in bounded time.
  virtual void land(const Interrupts& interrupts, const PrintMessage& print) = 0;
  /// Whether somebody else than the program's user asks that all land.
  virtual bool requested_to_land() const noexcept = 0;
  /// Shows a period to those who look on. By the thread that flies: allocates nothing, waits for nobody.
  virtual void show(const Sample& sample) noexcept = 0;
  /// Of a part of a team, what carries predictions to the others and back; none where one solver plans all.
  virtual PartExchange* exchange() noexcept { return nullptr; }
  /// After the flight: what made it fail, a sentence each.
  virtual std::vector<std::string> faults() const = 0;
  /// After the flight: what was counted, a line each: messages, and those that were refused.
  virtual std::vector<std::string> counts() const = 0;
  /// After the flight.
  virtual LinkTiming timing() const = 0;
};

/// Stands in for the robots of a fleet, in the place of their links' far ends.
class VehicleSimulators {
 public:
  virtual ~VehicleSimulators() = default;
  /// Until `interrupts` is not zero, or for so long [s].
  /// @param tell  takes what becomes of faults; may be empty
  virtual void run(double duration, const Interrupts& interrupts, const PrintMessage& print) = 0;
  /// Begins a fault of the usual size, or ends the one that there is. Of any thread.
  /// @param robot  from 0, in the order of the fleet's links
  /// @return what became of it, a sentence
  virtual std::string toggle(std::size_t robot, LinkFaultKind kind) = 0;
  /// After it: what each of them was told and did, a line each.
  virtual std::vector<std::string> counts() const = 0;
};

/// Where a robot says that it is, in G.
struct RobotPose {
  std::string robot;
  bool known = false;    ///< it has said so
  Vec3<double> p{};      ///< [m]
  double heading = 0.0;  ///< [rad]
  double age = 0.0;      ///< [s]
};

/// Listens to the robots of a fleet before a flight. It sends nothing that one of them could obey.
class FleetDoctor {
 public:
  virtual ~FleetDoctor() = default;
  /// Of what was heard in the last 10 s.
  virtual std::vector<Finding> findings() = 0;
  virtual std::vector<RobotPose> poses() = 0;
};

class Bridge {
 public:
  virtual ~Bridge() = default;
  /// @throws std::invalid_argument for a scenario that it cannot fly, std::runtime_error where the network cannot be had
  virtual std::unique_ptr<LinkedWorld> connect(const Scenario& scenario) const = 0;
  virtual std::unique_ptr<VehicleSimulators> vehicle_simulator(const Scenario& scenario) const = 0;
  virtual std::unique_ptr<FleetDoctor> examine(const Scenario& scenario) const = 0;
};

}  // namespace sightline
