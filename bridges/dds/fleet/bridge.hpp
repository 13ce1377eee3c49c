/// Interface of a bridge to robots that are not simulated; a program adds a bridge to its Registry.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/dds/fleet/finding.hpp"
#include "bridges/dds/fleet/link_fault.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"
#include "sightline/solver/distributed/part_solver.hpp"
#include "sightline/world.hpp"

namespace sightline {

/// Number of interrupts by the user: at 1 all robots land, at 2 control passes to their autopilots.
using Interrupts = std::atomic<int>;
/// Receives a sentence for the user. Called by a thread of the bridge between take_off() and
/// land(), otherwise by the caller's thread; never by two threads at once.
using PrintMessage = std::function<void(std::string_view)>;

enum class Arming {
  real,
  on_call,  ///< arms only after a call of the interface that the bridge offers to other programs
  dry_run,
};

/// Timing of a flight while its task was flown. Times in s.
struct LinkTiming {
  struct Delay {
    double median = 0.0, p99 = 0.0, most = 0.0;
  };
  std::int64_t periods = 0, missed = 0;  ///< missed: ended before they could begin; of `periods`
  Delay wake{};                          ///< from the begin of a period until the loop runs
  Delay arrival{};   ///< of a pose beyond that of the fastest, by the followed clock of its robot
  double cpu = 0.0;  ///< load of the whole program, in cores
};

/// A world of robots that are reached over links. Time 0 is the first measure().
///
/// One thread calls take_off(), runs a Loop in this world, then calls land(). Each call of apply()
/// keeps the robots in flight. Without a call for 0.5 s, each autopilot takes its action for a lost
/// companion computer.
class LinkedWorld : public World {
 public:
  /// Waits for the robots, checks and arms them, and brings them to their hold positions. Returns
  /// early when the user interrupts.
  /// @return false unless all robots hold; faults() gives the reasons
  virtual bool take_off(Arming arming, const Interrupts& interrupts, const PrintMessage& print) = 0;
  /// Brings all flying robots to the ground. Returns in bounded time, when no robot needs control
  /// any more.
  virtual void land(const Interrupts& interrupts, const PrintMessage& print) = 0;
  /// Whether another program than the user's requests that all robots land.
  virtual bool requested_to_land() const noexcept = 0;
  /// Publishes a period to observers. Called by the flight thread: neither allocates nor blocks.
  virtual void show(const Sample& sample) noexcept = 0;
  /// Carries the predictions of one part of a team to the other parts and back; null if one solver
  /// plans the whole team.
  virtual PartExchange* exchange() noexcept { return nullptr; }
  /// After the flight: the faults that made it fail, one sentence each.
  virtual std::vector<std::string> faults() const = 0;
  /// After the flight: the counters, one line each, of messages and of rejected messages.
  virtual std::vector<std::string> counts() const = 0;
  /// After the flight: its timing.
  virtual LinkTiming timing() const = 0;
};

/// Simulates the robots of a fleet at the far ends of their links.
class VehicleSimulators {
 public:
  virtual ~VehicleSimulators() = default;
  /// Runs until `interrupts` is not zero, or for `duration` [s].
  /// @param print  receives a sentence for each fault that begins or ends; may be empty
  virtual void run(double duration, const Interrupts& interrupts, const PrintMessage& print) = 0;
  /// Begins a fault of the default size, or ends the active one. Thread-safe.
  /// @param robot  from 0, in the order of the fleet's links
  /// @return the effect, one sentence
  virtual std::string toggle(std::size_t robot, LinkFaultKind kind) = 0;
  /// After the run: the messages received and the actions taken, one line for each robot.
  virtual std::vector<std::string> counts() const = 0;
};

/// Pose that a robot reports, in G.
struct RobotPose {
  std::string robot;
  bool known = false;    ///< the robot has reported a pose
  Vec3<double> p{};      ///< [m]
  double heading = 0.0;  ///< [rad]
  double age = 0.0;      ///< [s]
};

/// Monitors the robots of a fleet before a flight. Sends nothing that a robot could act on.
class FleetDoctor {
 public:
  virtual ~FleetDoctor() = default;
  /// Findings from the messages of the last 10 s.
  virtual std::vector<Finding> findings() = 0;
  virtual std::vector<RobotPose> poses() = 0;
};

class Bridge {
 public:
  virtual ~Bridge() = default;
  /// @throws std::invalid_argument for a scenario that the bridge cannot fly, std::runtime_error if
  /// the network is not available
  virtual std::unique_ptr<LinkedWorld> connect(const Scenario& scenario) const = 0;
  virtual std::unique_ptr<VehicleSimulators> vehicle_simulator(const Scenario& scenario) const = 0;
  virtual std::unique_ptr<FleetDoctor> examine(const Scenario& scenario) const = 0;
};

}  // namespace sightline
