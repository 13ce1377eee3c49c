#include "sightline/scenario/file_kind.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <system_error>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/readers/packed_file.hpp"

namespace sightline {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view
    of_bag = "a scenario file (TOML); identify and the file of a path read the motion in a bag",
    scenario_file = "a scenario file (TOML)",
    of_vehicle = "a scenario file (TOML); sightline import makes [agent.NAME.vehicle] of it",
    no_log =
        "a scenario file (TOML); logs are read from the folder of a run, as run "
        "and fly write it";

struct Magic {
  std::string_view begins;
  FileKind kind;
};

constexpr std::string_view mcap_magic = "\x89MCAP0\r\n"sv;

constexpr std::array magics = {
    Magic{"ULog\x01\x12\x35"sv,
          {"a PX4 ULog", "a scenario file (TOML); identify reads it, and so does the file of a path", false,
           RecordingKind::ulog}},
    Magic{"\xa3\x95\x80"sv, {"a dataflash log of ArduPilot", no_log}},
    Magic{"#ROSBAG V"sv, {"a bag of ROS 1", no_log}},
    Magic{"SQLite format 3\0"sv,
          {"an SQLite database, as a rosbag2 .db3 or the table of a campaign",
           "a scenario file (TOML); campaign --resume takes the folder of a campaign, and ros2 bag convert "
           "with storage_id: mcap makes a bag that identify reads"}},
    Magic{"\x89HDF\r\n"sv, {"an HDF5 file", no_log}},
    Magic{"\x1f\x8b"sv, {"a gzip archive", scenario_file}},
    Magic{"PK\x03\x04"sv, {"a zip archive", scenario_file}},
    Magic{"\x28\xb5\x2f\xfd"sv, {"a zstd archive", scenario_file}},
    Magic{"\xfd\x37zXZ"sv, {"an xz archive", scenario_file}},
    Magic{"%PDF-"sv, {"a PDF", scenario_file}},
    Magic{"\x89PNG"sv, {"a PNG picture", scenario_file}},
    Magic{"\xff\xd8\xff"sv, {"a JPEG picture", scenario_file}},
    Magic{"\x7f\x45LF"sv, {"a program (ELF)", scenario_file}},
};

/// Elements of XML.
constexpr std::array elements = {
    Magic{
        "<mujoco"sv,
        {"an MJCF",
         "a scenario file (TOML), whose [world] names a model of MuJoCo by model = \"...\"; sightline import "
         "makes [agent.NAME.vehicle] of it",
         true}},
    Magic{"<sdf"sv, {"an SDF", of_vehicle, true}},
    Magic{"<robot"sv, {"a URDF", of_vehicle, true}},
};

/// A log of sightline or of another program; the header names the library that wrote it.
FileKind mcap_kind(std::string_view head) {
  if (head.substr(0, 256).find("sightline") != std::string_view::npos)
    return {"the log of a run", "a scenario file (TOML), or the folder that the log lies in", false,
            RecordingKind::run};
  return {"an MCAP recording, as of rosbag2", of_bag, false, RecordingKind::bag};
}

std::string_view trimmed_left(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
  return line;
}

/// Lines that are neither empty nor a comment. The last one may be incomplete.
std::vector<std::string_view> lines_of(std::string_view head) {
  if (head.starts_with("\xef\xbb\xbf")) head.remove_prefix(3);
  std::vector<std::string_view> lines;
  while (!head.empty()) {
    const std::size_t end = std::min(head.find('\n'), head.size());
    std::string_view line = head.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    const std::string_view words = trimmed_left(line);
    if (!words.empty() && !words.starts_with('#')) lines.push_back(line);
    head.remove_prefix(std::min(end + 1, head.size()));
  }
  return lines;
}

/// The key of a YAML mapping, "robots" of "robots:" and of "robots: ..."; empty if the line has
/// none.
std::string_view yaml_key(std::string_view line) {
  line = trimmed_left(line);
  if (line.starts_with("- ")) line = trimmed_left(line.substr(2));
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || (colon + 1 < line.size() && line[colon + 1] != ' ')) return {};
  const std::string_view key = line.substr(0, colon);
  return key.find_first_of(" =[]{},\"'") == std::string_view::npos ? key : std::string_view();
}

struct YamlKind {
  std::array<std::string_view, 3> keys;  // any of these
  FileKind kind;
};

constexpr std::array yaml_kinds = {
    YamlKind{{"robot_types", "firmware_params", "initial_position"},
             {"a crazyflies.yaml of Crazyswarm2",
              "a scenario file (TOML); sightline import makes a fleet file of it", true}},
    YamlKind{{"camera_matrix", "distortion_coeffs", "distortion_coefficients"},
             {"the calibration of a camera (YAML)",
              "a scenario file (TOML); sightline import makes [agent.NAME.camera] of it", true}},
    YamlKind{{"standalone_tags", "tag_bundles", "tag_family"},
             {"the tags of apriltag_ros (YAML)",
              "a scenario file (TOML); sightline import makes [target.NAME.tags] of it", true}},
    YamlKind{{"rosbag2_bagfile_information", "relative_file_paths", "storage_identifier"},
             {"the metadata of a rosbag2 (YAML)", of_bag, true}},
};

FileKind yaml_kind(const std::vector<std::string_view>& lines) {
  for (const YamlKind& one : yaml_kinds) {
    const bool has = std::any_of(lines.begin(), lines.end(), [&](std::string_view line) {
      const std::string_view key = yaml_key(line);
      return !key.empty() && std::find(one.keys.begin(), one.keys.end(), key) != one.keys.end();
    });
    if (!has) continue;
    FileKind kind = one.kind;
    kind.is_yaml = true;
    return kind;
  }
  const std::string_view first = lines.front();
  const bool begins = first.starts_with("---") || first.starts_with("%YAML") || first.starts_with("- ");
  if (begins || !yaml_key(first).empty())
    return {.what = "YAML", .expected = scenario_file, .is_text = true, .is_yaml = true};
  return {};
}

/// Whether two rows have equally many columns, by one of the usual separators.
bool is_table(std::string_view first, std::string_view second) {
  return std::any_of(std::begin(",;\t"), std::end(",;\t") - 1, [&](char mark) {
    const auto columns = std::count(first.begin(), first.end(), mark);
    return columns > 0 && columns == std::count(second.begin(), second.end(), mark);
  });
}

FileKind text_kind(std::string_view head) {
  const std::vector<std::string_view> lines = lines_of(head);
  if (lines.empty()) return {};
  const std::string_view first = trimmed_left(lines.front());
  if (first.starts_with('{')) return {"JSON", scenario_file, true};
  if (first.starts_with('<')) {
    for (const Magic& element : elements)
      if (head.find(element.begins) != std::string_view::npos) return element.kind;
    return {"XML", scenario_file, true};
  }
  if (first.starts_with("QGC WPL")) return {"a list of waypoints of QGroundControl", scenario_file, true};
  // In TOML, a line in [ ] is a header, not a row of a table.
  if (lines.size() > 1 && first.find('=') == std::string_view::npos && !first.starts_with('[') &&
      is_table(lines[0], lines[1]))
    return {
        "a table of values (CSV)",
        "a scenario file (TOML), in which a path is written as reference = { waypoints = { times = [...], p "
        "= [[x, y, z], ...] } }",
        true, RecordingKind::table};
  return yaml_kind(lines);
}

}  // namespace

std::string FileKind::shown() const {
  return packed_by.empty() ? std::string(what) : fmt::format("{}, packed by {}", what, packed_by);
}

FileKind file_kind(std::string_view head) {
  if (head.starts_with(mcap_magic)) return mcap_kind(head);
  for (const Magic& magic : magics)
    if (head.starts_with(magic.begins)) return magic.kind;
  if (head.find('\0') != std::string_view::npos) return {};
  return text_kind(head.substr(0, file_head));
}

FileKind kind_at(const std::filesystem::path& place) {
  std::error_code ignored;
  const auto has = [&](const char* file) { return std::filesystem::is_regular_file(place / file, ignored); };
  if (std::filesystem::is_directory(place, ignored)) {
    if (has("run.mcap")) return {"the folder of a run", scenario_file, false, RecordingKind::run};
    if (has("metadata.yaml")) return {"the folder of a rosbag2", of_bag, false, RecordingKind::bag};
    return {};
  }
  if (!std::filesystem::is_regular_file(place, ignored)) return {};
  const FileHead head = read_head(place, file_head);
  FileKind kind = file_kind(head.bytes);
  kind.packed_by = head.packed_by;
  // Of an archive of anything else it is known that it is one.
  if (kind.what.empty() && !head.packed_by.empty())
    kind = {head.packed_by == "zstd" ? "a zstd archive" : "a gzip archive", scenario_file};
  return kind;
}

std::string kind_sentence(const FileKind& kind) {
  return kind.what.empty() ? std::string()
                           : fmt::format("this is {}, expected {}", kind.shown(), kind.expected);
}

std::filesystem::path log_of(const std::filesystem::path& folder) {
  std::error_code ignored;
  std::filesystem::path log = folder / "run.mcap";
  if (std::filesystem::is_regular_file(log, ignored)) return log;
  const FileKind kind = kind_at(folder);
  if (kind.what.empty() && std::filesystem::is_regular_file(folder, ignored))
    throw_invalid("{}: this is a file, expected the folder of a run", folder.native());
  if (kind.what.empty()) throw_invalid("{}: no run.mcap, expected the folder of a run", folder.native());
  throw_invalid("{}: this is {}, expected the folder of a run", folder.native(), kind.shown());
}

}  // namespace sightline
