#include "bridges/dds/links/link_end.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "bridges/dds/links/crazyswarm_link.hpp"
#include "bridges/dds/links/px4_link.hpp"
#include "bridges/dds/links/ros2_flyer_link.hpp"
#include "bridges/dds/links/ros2_link.hpp"

namespace sightline::dds {

std::unique_ptr<LinkEnd> made_end(const Port& participant, const Link& link, std::string_view name,
                                  const Model& model, const FleetNetwork& network) {
  const bool loopback = network.interfaces == std::vector<std::string>{"lo"};
  if (std::holds_alternative<Px4Link>(link.kind))
    return std::make_unique<Px4LinkEnd>(participant, link, loopback ? Stamps::of_this_machine : Stamps::none);
  if (const auto* ros2 = std::get_if<Ros2Link>(&link.kind)) {
    check_commands(*ros2, name, model);
    if (ros2->flies()) return std::make_unique<Ros2FlyerLinkEnd>(participant, link);
    return std::make_unique<Ros2LinkEnd>(participant, link);
  }
  if (model.rolls())
    throw std::invalid_argument(fmt::format(
        "agent.{}.link.kind = crazyswarm2, behind which a {} does not drive, expected a robot that flies",
        name, model.name()));
  return std::make_unique<CrazyswarmLinkEnd>(participant, link);
}

}  // namespace sightline::dds
