#include "bridges/dds/preflight.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base/now.hpp"

namespace sightline::dds {
namespace {

bool keeps_it_grounded(const Finding& finding) {
  return finding.light == Light::red && keeps_grounded(finding.aspect);
}

}  // namespace

Preflight::Preflight(const Scenario& scenario, std::vector<ExaminedRobot> robots, const SeenBodies& bodies,
                     dds_entity_t participant, double listened)
    : scenario_(scenario),
      examined_(std::move(robots)),
      robots_(examined_.size()),
      bodies_(bodies),
      discovery_(participant),
      listened_(to_nanoseconds(listened)) {}

std::vector<Finding> Preflight::examine() {
  std::vector<Finding> findings = examine_fleet(scenario_, examined_, discovery_.look());
  bodies_.examine(scenario_, findings);
  return findings;
}

void Preflight::clear() {
  const std::vector<Finding> findings = examine();
  const Nanoseconds now = monotonic_now();
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& robot = robots_[i];
    SeenMotion seen;
    if (robot.received == 0 && examined_[i].end->look(seen)) robot.received = now;
    robot.clear = robot.received > 0 && now - robot.received > listened_ &&
                  std::none_of(findings.begin(), findings.end(), [&](const Finding& finding) {
                    const bool concerns = finding.robot.empty() || finding.robot == examined_[i].name;
                    return concerns && keeps_it_grounded(finding);
                  });
  }
}

bool Preflight::all_clear() const {
  return std::all_of(robots_.begin(), robots_.end(), [](const Robot& robot) { return robot.clear; });
}

std::vector<std::string> Preflight::refusals() {
  std::vector<std::string> sentences;
  for (const Finding& finding : examine()) {
    if (keeps_it_grounded(finding))
      sentences.push_back(
          fmt::format("{}: {}", finding.robot.empty() ? "fleet" : finding.robot, finding.sentence));
  }
  return sentences;
}

}  // namespace sightline::dds
