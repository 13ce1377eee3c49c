#include "bridges/dds/stand_in.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "bridges/dds/px4_vehicle.hpp"
#include "bridges/dds/ros2_rover.hpp"
#include "sightline/base/index.hpp"

namespace sightline::dds {
namespace {

constexpr double lowest_takeoff = 0.5;  // [m]

}  // namespace

std::unique_ptr<StandIn> made_stand_in(dds_entity_t participant, const Scenario& scenario, const Link& link) {
  const Team& team = scenario.team;
  const std::vector<double> rest(size(team.model(link.robot).nu()));
  const Sight<double> start =
      team.model(link.robot).sight(&scenario.x0[size(team.state_offset(link.robot))], rest.data());
  if (const auto* ros2 = std::get_if<Ros2Link>(&link.kind)) {
    const std::span<const std::string_view> states = team.model(link.robot).states();
    return std::make_unique<Ros2Rover>(
        participant, *ros2,
        Ros2Rover::Setup{.origin = link.origin,
                         .start = {start.p, upright(start.d), {}, 0.0},
                         .sideward = std::find(states.begin(), states.end(), "v_s") != states.end()});
  }
  const auto* px4 = std::get_if<Px4Link>(&link.kind);
  if (px4 == nullptr)
    throw std::invalid_argument(
        fmt::format("agent.{}.link.kind = {}, which nothing stands in for yet, expected px4 or ros2",
                    team.name(link.robot), link.kind_name()));
  Px4Vehicle::Setup setup{.origin = link.origin,
                          .p = {start.p.x, start.p.y, 0.0},
                          .heading = std::atan2(start.d.y, start.d.x),
                          .altitude = std::max(lowest_takeoff, start.p.z),
                          .system = static_cast<std::uint8_t>(
                              px4->target_system > 0 ? px4->target_system : 1 + link.robot.index % 255)};
  for (const RobotVehicle& vehicle : scenario.vehicles)
    if (vehicle.robot == link.robot) setup.rotors = vehicle.vehicle;
  return std::make_unique<Px4Vehicle>(participant, *px4, setup);
}

DdsStandIns::DdsStandIns(const Scenario& scenario, std::shared_ptr<Domain> domain)
    : domain_(std::move(domain)) {
  if (!scenario.fleet)
    throw std::invalid_argument("fleet is missing, expected a [fleet] that says how the robots are reached");
  for (const Link& link : scenario.fleet->links) {
    names_.emplace_back(scenario.team.name(link.robot));
    stand_ins_.push_back(made_stand_in(domain_->participant(), scenario, link));
  }
}

void DdsStandIns::run(double duration, const Interrupts& interrupts, const TellPerson&) {
  using Time = std::chrono::steady_clock;
  const auto step = std::chrono::microseconds(std::llround(1e6 * StandIn::period));
  const std::int64_t steps = std::llround(std::min(duration, 1e9) / StandIn::period);
  const Time::time_point begin = Time::now();
  for (std::int64_t k = 0; k < steps && interrupts == 0; ++k) {
    std::this_thread::sleep_until(begin + k * step);
    for (const auto& stand_in : stand_ins_) stand_in->step(k);
  }
}

std::vector<std::string> DdsStandIns::counts() const {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < names_.size(); ++i)
    lines.push_back(fmt::format("{}: {}", names_[i], stand_ins_[i]->counts()));
  return lines;
}

}  // namespace sightline::dds
