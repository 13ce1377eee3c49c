#include "sightline/import/import.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "sightline/import/kinds.hpp"
#include "sightline/import/yaml_value.hpp"
#include "sightline/scenario/file_kind.hpp"

namespace sightline {
namespace {

constexpr std::string_view known_kinds =
    "a crazyflies.yaml of Crazyswarm2, the calibration of a camera by ROS (or a bag with it) or kalibr, the "
    "tags of apriltag_ros or TagSLAM, or the SDF, URDF or MJCF of a multirotor";

bool is_camchain(const YamlValue& document) {
  const auto all = document.entries("a mapping");
  return std::any_of(all.begin(), all.end(), [](const auto& entry) {
    return entry.second.find("camera_model").has_value() && entry.second.find("intrinsics").has_value();
  });
}

/// Whether a robot gets what the file says, by the name in the options.
void check_agent(const ImportOptions& options, const std::string& file) {
  if (!options.agent.empty() && !is_robot_name(options.agent))
    throw ScenarioError(file, 0,
                        fmt::format("--agent = {}, expected letters, digits, _ and -", options.agent));
}

}  // namespace

std::optional<YamlValue> node_parameters(const YamlValue& document) {
  for (const auto& [node, value] : document.entries("a mapping"))
    if (const auto parameters = value.find("ros__parameters")) return parameters;
  return std::nullopt;
}

bool is_robot_name(std::string_view name) {
  return !name.empty() && name.size() <= name_size_max &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return c < 128 && (std::isalnum(c) != 0 || c == '_' || c == '-');
         });
}

Imported import_texts(std::span<const ImportFile> files, const ImportOptions& options) {
  if (files.empty()) throw ScenarioError("import", 0, "no file, expected one");
  const ImportFile& first = files.front();
  const FileKind kind = file_kind(std::string_view(first.text).substr(0, file_head));
  const auto no_kind = [&] {
    return ScenarioError(first.name, 1,
                         kind.what.empty() ? fmt::format("expected {}", known_kinds)
                                           : fmt::format("this is {}, expected {}", kind.what, known_kinds));
  };
  const std::size_t begin = first.text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  if (begin == std::string::npos) throw no_kind();
  check_agent(options, first.name);
  if (first.text[begin] == '<') return import_vehicle(files, options);
  const YamlValue document = [&] {
    try {
      return YamlValue(first.text, first.name);
    } catch (const ScenarioError&) {
      if (!kind.is_yaml && !kind.what.empty()) throw no_kind();
      throw;
    }
  }();
  const bool is_fleet = document.find("robots").has_value();
  const std::size_t most = is_fleet ? 2 : 1;
  if (files.size() > most)
    throw ScenarioError(
        files[most].name, 0,
        is_fleet ? "expected crazyflies.yaml, and at most its server.yaml" : "expected one file");
  if (is_fleet) {
    if (files.size() == 1) return import_crazyflies(document, first.name, nullptr);
    const YamlValue second(files[1].text, files[1].name);
    const std::optional<YamlValue> server = node_parameters(second);
    if (!server)
      throw ScenarioError(files[1].name, 1,
                          "expected a server.yaml of Crazyswarm2, with ros__parameters of its server");
    return import_crazyflies(document, first.name, &*server);
  }
  if (document.find("camera_matrix")) return import_camera_info(document, first.name, options);
  if (is_camchain(document)) return import_camchain(document, first.name, options);
  const std::optional<YamlValue> node = node_parameters(document);
  const bool has_tags =
      document.find("standalone_tags") || document.find("bodies") || (node && node->find("tag"));
  if (has_tags) return import_tags(document, first.name, options);
  throw no_kind();
}

Imported import_files(std::span<const std::filesystem::path> files, const ImportOptions& options) {
  if (!files.empty()) {
    const FileKind kind = kind_at(files[0]);
    if (kind.is_bag()) {
      if (files.size() > 1) throw ScenarioError(files[1].native(), 0, "expected one bag");
      check_agent(options, files[0].native());
      return import_bag(files[0], options);
    }
    // The reader of a text reports the line at which it is no such file.
    if (!kind.what.empty() && (!kind.is_text || !kind.packed_by.empty()))
      throw ScenarioError(files[0].native(), 1,
                          fmt::format("this is {}, expected {}", kind.shown(), known_kinds));
  }
  std::vector<ImportFile> texts;
  for (const std::filesystem::path& file : files) texts.push_back({file.native(), read_import_text(file)});
  return import_texts(texts, options);
}

std::string file_name(const std::string& file) {
  return one_line(std::filesystem::path(file).filename().native());
}

std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string toml_numbers(std::span<const double> values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + toml_number(value);
  return text + "]";
}

}  // namespace sightline
