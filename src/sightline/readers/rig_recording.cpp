#include "sightline/readers/rig_recording.hpp"

#include <fmt/format.h>

#include <cmath>
#include <span>

#include "sightline/readers/number_table.hpp"
#include "sightline/readers/recorded_motion.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

constexpr NumberColumn stamp_column{"t", "s", {-1e10, 1e10, "-1e10 to 1e10"}};
constexpr NumberColumn id_column{"id", "", {0, rig_tag_id_max, "0 to 1000000"}};
constexpr NumberColumn corner_column{"corner", "px", {-1e5, 1e5, "-100000 to 100000"}};
constexpr NumberColumn place_column{"position", "m", {-1e5, 1e5, "-100000 to 100000"}};
constexpr NumberColumn turn_column{"quaternion", "", {-1.1, 1.1, "-1.1 to 1.1"}};
constexpr std::size_t head = 3, fields_of_tag = 12, fields_of_pose = 10, fields_with_velocity = 16;

}  // namespace

RigRows parse_rig_rows(const std::string& file, std::string_view text) {
  RigRows rows;
  NumberTable table(file, text);
  std::optional<double> first;
  while (table.next()) {
    const std::span<const std::string_view> fields = table.fields();
    const bool tag = fields[0] == "tag";
    if (!tag && fields[0] != "odom")
      table.refuse(fmt::format("row {}, expected tag or odom", printable(fields[0])));
    const std::size_t count = fields.size();
    if (tag && count != fields_of_tag)
      table.refuse(fmt::format("{} fields, expected 12: tag, topic, t, id, 8 coordinates of corners", count));
    if (!tag && count != fields_of_pose && count != fields_with_velocity)
      table.refuse(
          fmt::format("{} fields, expected 10 or 16: odom, topic, t, position, quaternion (x, y, z, w), "
                      "perhaps 6 numbers of velocity",
                      count));
    const double t = table.number(2, stamp_column);
    if (!first) first = t;
    if (!(std::abs(t - *first) <= rig_recording_max))
      table.refuse(fmt::format("t = {:.3f} s, expected within {:.0f} s of the first, {:.3f} s", t,
                               rig_recording_max, *first));
    std::string topic(fields[1]);
    if (tag) {
      const double id = table.number(head, id_column);
      if (id != std::floor(id)) table.refuse(fmt::format("id = {}, expected an integer", fields[head]));
      RigRows::TagRow row{.topic = std::move(topic), .t = t, .id = static_cast<int>(id), .corners = {}};
      for (std::size_t k = 0; k < 4; ++k)
        row.corners[k] = {table.number(head + 1 + 2 * k, corner_column),
                          table.number(head + 2 + 2 * k, corner_column)};
      rows.tags.push_back(std::move(row));
      continue;
    }
    std::array<double, 7> n{};
    for (std::size_t k = 0; k < n.size(); ++k)
      n[k] = table.number(head + k, k < 3 ? place_column : turn_column);
    const double length = std::sqrt(n[3] * n[3] + n[4] * n[4] + n[5] * n[5] + n[6] * n[6]);
    if (!(std::abs(length - 1) < 0.01))
      table.refuse(fmt::format("|quaternion| = {:.3g}, expected 1", length));
    const RigidPose pose = {{n[0], n[1], n[2]}, *recorded_attitude({n[6], n[3], n[4], n[5]})};
    rows.poses.push_back({std::move(topic), {t, pose}});
  }
  return rows;
}

}  // namespace sightline
