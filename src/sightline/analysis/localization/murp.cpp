#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <regex>
#include <stdexcept>

#include "sightline/analysis/localization/team_recording.hpp"
#include "sightline/readers/number_table.hpp"

namespace sightline {
namespace {

constexpr int antennas = 6;
constexpr double antenna_radius = 0.32;  // [m]
constexpr Bounds within_world = {-1e4, 1e4, "-10000 to 10000"};
constexpr NumberColumn seconds_column{"t", "s", {-1e10, 1e10, "-1e10 to 1e10"}};

/// Antennas stand on a circle about the middle of an agent, in the plane of its pose: the first
/// 30 degrees to the left of ahead, the others each 60 degrees further.
Vec3<double> antenna(int i) {
  const SinCos<double> e = sincos((30.0 + 60.0 * i) * std::numbers::pi / 180);
  return {antenna_radius * e.cos, antenna_radius * e.sin, 0.0};
}

/// Numbers of the agents in the name of a file.
struct AgentPair {
  int base, target;
};

AgentPair agents_of(const std::string& file) {
  static const std::regex names(R"(base-([0-9]{1,3})_targ-([0-9]{1,3})[^0-9])");
  const std::string name = std::filesystem::path(file).filename().native();
  std::smatch found;
  if (!std::regex_search(name, found, names))
    throw std::invalid_argument(fmt::format("{}: a name without agents, expected base-1_targ-2", file));
  const AgentPair pair{std::stoi(found[1]), std::stoi(found[2])};
  if (pair.base == pair.target) throw std::invalid_argument(fmt::format("{}: one agent, expected two", file));
  return pair;
}

/// Columns of a table, by the names in its first row.
class Header {
 public:
  Header(NumberTable& table, const std::string& file) : table_(table) {
    if (!table.next()) throw std::invalid_argument(fmt::format("{}: no rows, expected a header", file));
    names_.assign(table.fields().begin(), table.fields().end());
  }
  std::size_t operator[](const std::string& name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end()) table_.refuse(fmt::format("no column {}, expected it", name));
    return static_cast<std::size_t>(found - names_.begin());
  }
  std::size_t size() const { return names_.size(); }

 private:
  NumberTable& table_;
  std::vector<std::string> names_;
};

struct AgentColumns {
  AgentColumns(const Header& header, const std::string& prefix)
      : x(header[prefix + "x"]),
        y(header[prefix + "y"]),
        z(header[prefix + "z"]),
        yaw(header[prefix + "yaw"]) {}
  std::size_t x, y, z, yaw;
};

}  // namespace

TeamRecording parse_murp(const RecordingTexts& texts, const std::string& place) {
  std::map<int, int> robot_of_agent;
  std::map<std::pair<int, int>, std::string> files;
  for (const auto& [file, text] : texts) {
    const AgentPair pair = agents_of(file);
    robot_of_agent[pair.base] = robot_of_agent[pair.target] = 0;
    const auto [other, is_new] = files.try_emplace({pair.base, pair.target}, file);
    if (!is_new)
      throw std::invalid_argument(
          fmt::format("{}: the agents of {}, expected one file for each pair", file, other->second));
  }
  if (files.empty() || robot_of_agent.size() > recorded_robots_max)
    throw std::invalid_argument(
        fmt::format("{}: {} agents, expected 2 to {}", place, robot_of_agent.size(), recorded_robots_max));
  TeamRecording recording{.kind = "MURP", .start = infinity, .end = -infinity, .relative = true};
  recording.antennas = antennas;
  for (auto& [agent, robot] : robot_of_agent) {
    robot = static_cast<int>(recording.robots.size());
    recording.robots.push_back({.name = fmt::format("agent{}", agent)});
  }
  // Between ranges the agents turn and drive as they like.
  recording.noise = {.distance_noise = 0, .skid_noise = 0, .curve_noise = 0, .turn_noise = 0};
  TeamNoise& noise = recording.noise;
  noise.speed_scale = noise.turn_scale = noise.turn_loss = noise.clock_offset = noise.sensor_turn = 0.0;
  noise.wheel_turn = noise.range_depth = noise.axis_turn = noise.range_scale = noise.range_offset =
      noise.bearing_scale = 0.0;
  noise.position_walk = 0.15, noise.heading_walk = 0.05;
  noise.yaw_rate_bias = 1.0, noise.yaw_rate_walk = 0.1;
  // The error of a range depends on the angles at which it meets the antennas. Neighbours have much of
  // it in common, so that 36 ranges of 0.1 m tell as much as 9, or as 36 of twice that noise.
  noise.range_noise = 0.2, noise.range_share = 0.0;
  noise.range_error = 0.02, noise.range_error_time = 10.0;
  noise.antenna_error = 0.07;

  std::vector<std::map<double, PlanarPose>> truth(recording.robots.size());
  std::vector<double> heights(recording.robots.size());
  std::vector<std::size_t> rows(recording.robots.size());
  for (const auto& [agents, file] : files) {
    NumberTable table(file, texts.at(file));
    const Header header(table, file);
    const std::size_t t = header["t"];
    const std::array columns = {AgentColumns(header, "A_"), AgentColumns(header, "B_")};
    std::array<std::size_t, antennas * antennas> ranges;
    for (std::size_t i = 0; i < ranges.size(); ++i)
      ranges[i] = header[fmt::format("{}_{}", i / antennas + 1, i % antennas + 1)];
    const std::array robots = {robot_of_agent.at(agents.first), robot_of_agent.at(agents.second)};
    std::optional<double> first;
    while (table.next()) {
      if (table.fields().size() != header.size())
        table.refuse(
            fmt::format("{} fields, expected {}, as in the header", table.fields().size(), header.size()));
      const double now = table.number(t, seconds_column);
      if (!first) first = now;
      if (!(std::abs(now - *first) <= recording_max))
        table.refuse(fmt::format("t = {:.3f} s, expected within {:.0f} s of the first", now, recording_max));
      recording.start = std::min(recording.start, now), recording.end = std::max(recording.end, now);
      for (std::size_t side = 0; side < 2; ++side) {
        const AgentColumns& at = columns[side];
        const auto robot = static_cast<std::size_t>(robots[side]);
        truth[robot][now] = {
            table.number(at.x, {"x", "m", within_world}), table.number(at.y, {"y", "m", within_world}),
            wrap(table.number(at.yaw, {"yaw", "degrees", within_world}) * std::numbers::pi / 180)};
        heights[robot] += table.number(at.z, {"z", "m", within_world});
        ++rows[robot];
      }
      for (std::size_t i = 0; i < ranges.size(); ++i) {
        const std::string_view field = table.fields()[ranges[i]];
        if (field.empty() || field == "nan") continue;
        TeamSighting z{.stamp = now, .observer = robots[0], .subject = robots[1], .of = Sighted::range};
        z.range = table.number(ranges[i], {"range", "m", {1e-3, 1e4, "0.001 to 10000"}});
        z.antenna = static_cast<int>(i) / antennas, z.other_antenna = static_cast<int>(i) % antennas;
        z.sensor = antenna(static_cast<int>(i) / antennas), z.point = antenna(static_cast<int>(i) % antennas);
        recording.sightings.push_back(z);
      }
    }
  }
  if (!(recording.end > recording.start && recording.end - recording.start <= recording_max))
    throw std::invalid_argument(fmt::format("{}: {} ranges, expected some over > 0 to {:.0f} s", place,
                                            recording.sightings.size(), recording_max));
  std::stable_sort(recording.sightings.begin(), recording.sightings.end(),
                   [](const TeamSighting& a, const TeamSighting& b) { return a.stamp < b.stamp; });
  for (std::size_t i = 0; i < recording.robots.size(); ++i) {
    recording.robots[i].height = heights[i] / static_cast<double>(std::max<std::size_t>(rows[i], 1));
    for (const auto& [time, pose] : truth[i]) recording.robots[i].truth.push_back({time, pose});
  }
  return recording;
}

}  // namespace sightline
