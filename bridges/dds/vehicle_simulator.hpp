/// What stands in for the vehicles of a fleet, at the far ends of their links.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bridges/dds/conversion.hpp"
#include "bridges/dds/domain.hpp"
#include "bridges/dds/faults.hpp"
#include "bridges/dds/simulated_cameras.hpp"
#include "bridges/dds/simulated_poses.hpp"
#include "sightline/scenario/bridge.hpp"

namespace sightline::dds {

/// One robot of its own: it moves, and speaks as its link's kind does.
class VehicleSimulator {
 public:
  static constexpr double period = 0.01;  // [s]

  virtual ~VehicleSimulator() = default;
  /// Moves on by a period, and says what it says at that number of periods.
  virtual void step(std::int64_t number) = 0;
  /// Whether somebody steers it.
  virtual bool is_steered() const = 0;
  virtual Motion motion() const = 0;  ///< in G
  /// What it was told and did, in words.
  virtual std::string counts() const = 0;
};

/// @param faults  of this robot; they outlive it. What it says goes out by FaultyWriter, poses as Faults::said() has them; restarts and
///                a wrong release are its owner's
/// @throws std::invalid_argument for a kind that nothing stands in for
std::unique_ptr<VehicleSimulator> made_simulator(dds_entity_t participant, const Scenario& scenario,
                                                 const Link& link, Faults& faults);

/// Those of all links, stepped by one thread.
class DdsVehicleSimulators final : public VehicleSimulators {
 public:
  DdsVehicleSimulators(const Scenario& scenario, std::shared_ptr<Domain> domain);

  void run(double duration, const Interrupts& interrupts, const PrintMessage& print) override;
  std::string toggle(std::size_t robot, LinkFaultKind kind) override;
  std::vector<std::string> counts() const override;
  /// It ends with a restart.
  VehicleSimulator& of(std::size_t robot) { return *robots_[robot].vehicle_simulator; }
  Faults& faults(std::size_t robot) { return robots_[robot].faults; }

 private:
  struct Robot {
    Robot(const Link& reached, std::string called, std::uint64_t seed)
        : link(reached), name(std::move(called)), faults(seed) {}

    Link link;
    std::string name;
    Faults faults;
    std::unique_ptr<VehicleSimulator> vehicle_simulator;  // none: until it begins anew
    Motion at{};                                          // where it is, or was last
    std::vector<std::string> earlier;                     // what those before it did, in words
    std::int64_t begins_anew = 0;                         // at this number of periods
    std::optional<std::int64_t> steered_from;             // the number of periods
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
  std::deque<Robot> robots_;
  std::vector<Planned> plan_;
  std::vector<Motion> motions_;  // of each, as others see it
  std::vector<Motion> places_;   // of each, as it truly is
  SimulatedPoses poses_;
  std::unique_ptr<SimulatedCameras> cameras_;  // last: its writers end before the faults that they ask
};

}  // namespace sightline::dds
