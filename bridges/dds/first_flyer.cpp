#include "bridges/dds/first_flyer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/prediction_exchange.hpp"

namespace sightline::dds {
namespace {

constexpr auto acquaintance = std::chrono::seconds(1);

/// Whether only a program that flies the robot publishes this topic.
bool flies(std::string_view topic, const Link& link) {
  const std::string wire = wire_topic("");
  return topic.starts_with(wire) &&
         std::visit([&](const auto& kind) { return kind.is_commanded_on(topic.substr(wire.size())); },
                    link.kind);
}

}  // namespace

void refuse_second_flyer(const Scenario& scenario, const Domain& domain) {
  std::string part;  // prediction topic of our own part
  if (plans_apart(scenario)) part = wire_topic(prediction_topic(scenario.name, scenario.partition->part));
  WriterList list(domain.participant());
  const auto until = std::chrono::steady_clock::now() + acquaintance;
  while (std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const std::vector<SeenWriter> writers = list.look();
    const auto claims = [&](const SeenWriter& writer) { return writer.topic == part; };
    if (std::any_of(writers.begin(), writers.end(), claims))
      throw std::runtime_error(fmt::format(
          "partition.part = \"{}\", which another program plans already, expected one for each part",
          scenario.partition->part));
    for (const Link& link : fleet_of(scenario).links) {
      const auto other = std::find_if(writers.begin(), writers.end(),
                                      [&](const SeenWriter& writer) { return flies(writer.topic, link); });
      if (other != writers.end())
        throw std::runtime_error(
            fmt::format("agent.{}: another program writes {} already, expected one flyer for each robot",
                        scenario.team.name(link.robot), other->topic));
    }
  }
}

}  // namespace sightline::dds
