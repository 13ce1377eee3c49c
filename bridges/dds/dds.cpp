#include <stdexcept>

#include "bridges/dds/doctor.hpp"
#include "bridges/dds/first_flyer.hpp"
#include "bridges/dds/simulators/vehicle_simulator.hpp"
#include "sightline/command_line.hpp"
#include "sightline/registry.hpp"
#include "sightline/run/realtime.hpp"

namespace sightline {
namespace dds {
namespace {

constexpr int fleet_receive_priority = 15;  // below the control thread's

std::shared_ptr<Domain> domain_of(const Scenario& scenario, std::optional<int> priority, Identity who) {
  return std::make_shared<Domain>(fleet_of(scenario).network, priority, who);
}

class DdsBridge final : public Bridge {
 public:
  std::unique_ptr<LinkedWorld> connect(const Scenario& scenario) const override {
    const bool may = may_be_realtime(fleet_receive_priority);
    std::shared_ptr<Domain> domain =
        domain_of(scenario, may ? std::optional(fleet_receive_priority) : std::nullopt, Identity::flyer);
    refuse_second_flyer(scenario, *domain);
    return std::make_unique<DdsWorld>(scenario, std::move(domain));
  }
  std::unique_ptr<VehicleSimulators> vehicle_simulator(const Scenario& scenario) const override {
    return std::make_unique<DdsVehicleSimulators>(scenario,
                                                  domain_of(scenario, std::nullopt, Identity::vehicles));
  }
  std::unique_ptr<FleetDoctor> examine(const Scenario& scenario) const override {
    return std::make_unique<DdsDoctor>(scenario, domain_of(scenario, std::nullopt, Identity::flyer));
  }
};

}  // namespace
}  // namespace dds

void add_dds(Registry& registry) {
  if (registry.bridge != nullptr) throw std::invalid_argument("there is a bridge already, expected one");
  registry = with_links(std::move(registry));
  registry.bridge = std::make_shared<dds::DdsBridge>();
}

}  // namespace sightline

extern "C" void sightline_add_dds(sightline::Registry& registry) { sightline::add_dds(registry); }
