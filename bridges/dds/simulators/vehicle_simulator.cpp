#include "bridges/dds/simulators/vehicle_simulator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bridges/dds/links/px4_release.hpp"
#include "sightline/base.hpp"
#include "sightline/base/now.hpp"
#include "sightline/scenario/starts.hpp"

namespace sightline::dds {
namespace {

constexpr double lowest_takeoff = 0.5;  // [m]

// Messages go through FaultyWriter, poses through Faults::distorted(). The owner applies restarts and a
// wrong release.
std::unique_ptr<VehicleSimulator> made_simulator(dds_entity_t participant, const Scenario& scenario,
                                                 const Link& link, double ground_time, Faults& faults) {
  const Team& team = scenario.team;
  const Model& model = team.model(link.robot);
  const Sight<double> start = sight_at_start(scenario, link.robot);
  const Vec3<double> below = {start.p.x, start.p.y, 0.0};
  SimulatorSetup setup = {.participant = participant,
                          .robot = link.robot,
                          .name = team.name(link.robot),
                          .model = model,
                          .origin = link.origin,
                          .sends_poses = !link.poses.by_others(),
                          .start = start,
                          .below = below,
                          .heading = std::atan2(start.d.y, start.d.x),
                          .altitude = std::max(lowest_takeoff, start.p.z),
                          .ground_time = ground_time,
                          .faults = faults};
  // A vision-localized robot has an odometry frame at its start pose: the flyer must not know the
  // position.
  if (link.poses.estimated()) setup.origin = {model.rolls() ? start.p : below, setup.heading};
  if (const RobotVehicle* const one = vehicle_of(scenario, link.robot)) setup.rotors = one->vehicle;
  return std::visit([&](const auto& kind) { return kind.simulator(setup); }, link.kind);
}

}  // namespace

DdsVehicleSimulators::DdsVehicleSimulators(const Scenario& scenario, std::shared_ptr<Domain> domain,
                                           double ground_time)
    : scenario_(scenario),
      domain_(std::move(domain)),
      ground_time_(ground_time),
      poses_(domain_->participant(), scenario_) {
  for (const Link& link : fleet_of(scenario_).links) {
    Robot& robot = robots_.emplace_back(link, std::string(scenario_.team.name(link.robot)),
                                        scenario_.simulation.seed + robots_.size());
    for (const LinkFault& fault : fleet_of(scenario_).faults)
      if (fault.robot == link.robot) plan_.push_back({fault, &robot});
  }
  std::vector<Faults*> faults;
  for (Robot& robot : robots_) faults.push_back(&robot.faults);
  cameras_ = std::make_unique<SimulatedCameras>(domain_->participant(), scenario_, faults);
  follow_plan(0, {});  // faults that are active from the start
  for (Robot& robot : robots_) make(robot);
}

void DdsVehicleSimulators::make(Robot& robot) {
  using K = LinkFaultKind;
  (void)robot.faults.changed(K::restart), (void)robot.faults.changed(K::wrong_release);
  Link link = robot.link;
  if (auto* px4 = std::get_if<Px4Link>(&link.kind); px4 != nullptr && robot.faults.on(K::wrong_release)) {
    const int wanted = static_cast<int>(robot.faults.size(K::wrong_release));
    const int own = px4_first + static_cast<int>(px4->release);
    const int next = own < px4_last ? own + 1 : px4_first;
    px4->release = static_cast<Px4Release>((wanted >= px4_first ? wanted : next) - px4_first);
  }
  robot.vehicle_simulator =
      made_simulator(domain_->participant(), scenario_, link, ground_time_, robot.faults);
}

void DdsVehicleSimulators::follow_plan(std::int64_t number, const PrintMessage& print) {
  const double t = static_cast<double>(number) * VehicleSimulator::period;
  constexpr double same = 1e-6;  // [s]
  for (Planned& one : plan_) {
    if (one.now == Planned::after) continue;
    double from = one.fault.at;
    if (one.fault.since == FaultClock::flight) {
      if (!one.robot->steered_from) continue;
      from += static_cast<double>(*one.robot->steered_from) * VehicleSimulator::period;
    }
    if (one.now == Planned::before && t > from - same) {
      one.now = Planned::during;
      one.robot->faults.begin(one.fault.kind, one.fault.size);
      if (print) print(fmt::format("{}: {} begins", one.robot->name, text_of(one.fault.kind).name));
    }
    if (one.now == Planned::during && t > from + one.fault.duration - same) {
      one.now = Planned::after;
      one.robot->faults.end(one.fault.kind);
      if (print) print(fmt::format("{}: {} ends", one.robot->name, text_of(one.fault.kind).name));
    }
  }
}

void DdsVehicleSimulators::step(Robot& robot, std::int64_t number) {
  using K = LinkFaultKind;
  const bool restarts = robot.faults.changed(K::restart) && robot.faults.on(K::restart),
             reflashed = robot.faults.changed(K::wrong_release);
  if ((restarts || reflashed) && robot.vehicle_simulator) {
    robot.earlier.push_back(robot.vehicle_simulator->counts());
    robot.vehicle_simulator.reset();
    robot.begins_anew =
        number + (restarts ? std::llround(robot.faults.size(K::restart) / VehicleSimulator::period) : 0);
  }
  if (restarts) robot.faults.end(K::restart);
  if (!robot.vehicle_simulator && number >= robot.begins_anew) make(robot);
  if (robot.vehicle_simulator) {
    robot.vehicle_simulator->step(number);
    if (!robot.steered_from && robot.vehicle_simulator->is_steered()) robot.steered_from = number;
  }
  robot.faults.pass_on();
}

void DdsVehicleSimulators::run(double duration, const Interrupts& interrupts, const PrintMessage& print) {
  const std::int64_t period = to_nanoseconds(VehicleSimulator::period);
  const std::int64_t flown = to_nanoseconds(scenario_.horizon.dt);
  const std::int64_t steps = std::llround(std::min(duration, 1e9) / VehicleSimulator::period);
  // Steps lie between the flyer's period starts, so that no race decides which pose a period uses.
  const std::int64_t begin = next_multiple(monotonic_now(), flown) + std::min(period, flown) / 2;
  for (std::int64_t k = 0; k < steps && interrupts == 0; ++k) {
    sleep_until(begin + k * period);
    follow_plan(k, print);
    for (Robot& robot : robots_) step(robot, k);
    motions_.clear();
    places_.clear();
    for (Robot& robot : robots_) {
      if (robot.vehicle_simulator) robot.at = robot.vehicle_simulator->motion();
      const bool by_others = robot.link.poses.by_others();
      places_.push_back(robot.at);
      motions_.push_back(by_others ? robot.faults.distorted(robot.at) : robot.at);
    }
    poses_.step(VehicleSimulator::period, motions_);
    cameras_->step(k, places_, poses_.states());
  }
}

std::string DdsVehicleSimulators::toggle(std::size_t robot, LinkFaultKind kind) {
  const LinkFaultText& text = text_of(kind);
  if (robot >= robots_.size())
    return fmt::format("there is no robot {}, expected 1 to {}", robot + 1, robots_.size());
  Robot& its = robots_[robot];
  if (!can_have(its.link, kind))
    return fmt::format("{}: no robot behind {} has the fault {}", its.name, its.link.kind_name(), text.name);
  const bool begins = !its.faults.on(kind);
  begins ? its.faults.begin(kind) : its.faults.end(kind);
  return fmt::format("{}: {}{} {}", its.name, text.name,
                     begins && !text.size.empty() ? fmt::format(" {}", text.fallback) : "",
                     begins ? "begins" : "ends");
}

std::vector<std::string> DdsVehicleSimulators::counts() const {
  std::vector<std::string> lines;
  for (const Robot& robot : robots_) {
    for (const std::string& words : robot.earlier)
      lines.push_back(fmt::format("{}, before it began anew: {}", robot.name, words));
    const std::string faults = describe(robot.faults.counts());
    lines.push_back(fmt::format("{}: {}{}{}", robot.name,
                                robot.vehicle_simulator ? robot.vehicle_simulator->counts() : "gone",
                                faults.empty() ? "" : "; ", faults));
  }
  for (std::string line : {poses_.counts(), cameras_->counts()})
    if (!line.empty()) lines.push_back(std::move(line));
  return lines;
}

}  // namespace sightline::dds
