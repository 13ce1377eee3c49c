/// Vehicle simulators of a fleet, at the far ends of its links.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bridges/dds/domain.hpp"
#include "bridges/dds/fleet/bridge.hpp"
#include "bridges/dds/simulators/faults.hpp"
#include "bridges/dds/simulators/simulated_cameras.hpp"
#include "bridges/dds/simulators/simulated_poses.hpp"
#include "bridges/dds/topics/conversion.hpp"

namespace sightline::dds {

/// One simulated robot: moves, and sends messages as its link's kind requires.
class VehicleSimulator {
 public:
  static constexpr double period = 0.01;  // [s]

  virtual ~VehicleSimulator() = default;
  /// Advances by one period, and sends the messages due at this period number.
  virtual void step(std::int64_t number) = 0;
  /// Whether it has received commands.
  virtual bool is_steered() const = 0;
  virtual Motion motion() const = 0;  ///< in G
  /// Counts of its commands and state, as text.
  virtual std::string counts() const = 0;
};

/// What a simulator is made from: `simulator` of the kind of its link.
struct SimulatorSetup {
  dds_entity_t participant;
  BodyId robot;
  std::string_view name;  ///< of the robot
  const Model& model;
  LinkOrigin origin;
  bool sends_poses;     ///< the robot itself: no other system measures it
  Sight<double> start;  ///< in G
  Vec3<double> below;   ///< the point of the ground below `start` [m]
  double heading;       ///< at the start [rad]
  double altitude;      ///< of its take-off [m]
  double ground_time;   ///< factor of the times on the ground, armed; 1: those of its autopilot
  std::optional<Vehicle> rotors{};
  Faults& faults;  ///< of this robot; must outlive it
};

/// Simulators of all links, stepped by one thread.
class DdsVehicleSimulators final : public VehicleSimulators {
 public:
  /// @param ground_time  factor of the times that vehicles stand armed before they take off and after
  ///   they landed, 0 to 1; 1: as their autopilots do
  /// @throws std::invalid_argument if a link does not support its robot's model
  DdsVehicleSimulators(const Scenario& scenario, std::shared_ptr<Domain> domain, double ground_time = 1.0);

  void run(double duration, const Interrupts& interrupts, const PrintMessage& print) override;
  std::string toggle(std::size_t robot, LinkFaultKind kind) override;
  std::vector<std::string> counts() const override;
  /// The reference is valid until the robot restarts.
  VehicleSimulator& of(std::size_t robot) { return *robots_[robot].vehicle_simulator; }
  Faults& faults(std::size_t robot) { return robots_[robot].faults; }

 private:
  struct Robot {
    Robot(const Link& reached, std::string called, std::uint64_t seed)
        : link(reached), name(std::move(called)), faults(seed) {}

    Link link;
    std::string name;
    Faults faults;
    std::unique_ptr<VehicleSimulator> vehicle_simulator;  // null until the robot restarts
    Motion at{};                                          // current or last motion
    std::vector<std::string> earlier;                     // counts of the instances before each restart
    std::int64_t begins_anew = 0;                         // period number of the restart
    std::optional<std::int64_t> steered_from;             // period number of the first command
  };
  struct Planned {
    LinkFault fault;
    Robot* robot;
    enum { before, during, after } now = before;
  };

  void step(Robot& robot, std::int64_t number);
  void follow_plan(std::int64_t number, const PrintMessage& print);
  void make(Robot& robot);

  Scenario scenario_;
  std::shared_ptr<Domain> domain_;
  double ground_time_;
  std::deque<Robot> robots_;
  std::vector<Planned> plan_;
  std::vector<Motion> motions_;  // of each robot, as external sources report it
  std::vector<Motion> places_;   // true motion of each robot
  SimulatedPoses poses_;
  std::unique_ptr<SimulatedCameras> cameras_;  // last member: its writers end before the faults they use
};

}  // namespace sightline::dds
