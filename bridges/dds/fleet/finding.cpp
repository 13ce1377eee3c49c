#include "bridges/dds/fleet/finding.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "sightline/scenario/read_camera.hpp"
#include "sightline/scenario/tag_size.hpp"

namespace sightline {
namespace {

struct AspectWords {
  std::string_view word;
  bool keeps_grounded;
};
constexpr std::array<AspectWords, aspects> aspect_words = {
    {{"topics", true}, {"release", true},   {"system", true},   {"frames", true}, {"writers", true},
     {"rate", false},  {"clock", true},     {"latency", false}, {"radio", false}, {"place", true},
     {"camera", true}, {"estimator", true}, {"checks", true},   {"state", true},  {"battery", true},
     {"pilot", false}, {"distance", true},  {"origins", true},  {"tags", false},  {"timing", false}}};
constexpr std::array<std::string_view, 3> light_words = {"green", "unknown", "red"};
constexpr std::array<std::string_view, 3> light_colours = {"\033[32m", "\033[33m", "\033[31m"};
constexpr std::string_view colours_end = "\033[0m";

const AspectWords& words_of(Aspect aspect) { return aspect_words.at(static_cast<std::size_t>(aspect)); }

std::string heading_of(const Finding& finding) {
  if (!finding.robot.empty()) return finding.robot;
  return finding.aspect == Aspect::timing ? "this machine" : "fleet";
}

}  // namespace

std::string_view to_string(Light light) { return light_words.at(static_cast<std::size_t>(light)); }
std::string_view to_string(Aspect aspect) { return words_of(aspect).word; }
bool keeps_grounded(Aspect aspect) { return words_of(aspect).keeps_grounded; }

Light worst(std::span<const Finding> findings) {
  Light all = Light::green;
  for (const Finding& finding : findings) all = std::max(all, finding.light);
  return all;
}

std::string findings_table(std::span<const Finding> findings, bool coloured) {
  std::vector<std::string> headings;
  for (const Finding& finding : findings) {
    std::string heading = heading_of(finding);
    if (std::find(headings.begin(), headings.end(), heading) == headings.end())
      headings.push_back(std::move(heading));
  }
  std::string table;
  for (const std::string& heading : headings) {
    table += heading + "\n";
    for (const Finding& finding : findings) {
      if (heading_of(finding) != heading) continue;
      const auto light = static_cast<std::size_t>(finding.light);
      table += fmt::format("  {}{:<7}{}  {:<9}  {}\n", coloured ? light_colours.at(light) : "",
                           light_words.at(light), coloured ? colours_end : "", to_string(finding.aspect),
                           finding.sentence);
    }
  }
  return table;
}

std::vector<Finding> tag_findings(const Scenario& scenario) {
  std::vector<Finding> findings;
  const std::vector<TagReading> readings = tag_readings(scenario);
  for (const TagReading& one : readings) {
    const std::string_view expected = one.pixels < one.from_ahead      ? "it is not read"
                                      : one.pixels < one.from_any_side ? "it is not read from every side"
                                                                       : "";
    if (expected.empty()) continue;
    findings.push_back(
        {"", Aspect::tags, Light::red,
         fmt::format("{}, below {:.1f} px {}: larger tags, another camera, or nearer",
                     describe(one, scenario.team),
                     one.pixels < one.from_ahead ? one.from_ahead : one.from_any_side, expected)});
  }
  if (!findings.empty() || readings.empty()) return findings;
  const auto smallest =
      std::min_element(readings.begin(), readings.end(), [](const TagReading& a, const TagReading& b) {
        return a.pixels - a.from_any_side < b.pixels - b.from_any_side;
      });
  findings.push_back({"", Aspect::tags, Light::green,
                      fmt::format("{}, enough from every side", describe(*smallest, scenario.team))});
  return findings;
}

}  // namespace sightline
