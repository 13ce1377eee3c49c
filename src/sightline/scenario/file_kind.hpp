/// What a file is that is no scenario: a log, a calibration, a table, by its first bytes.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace sightline {

/// Bytes that file_kind() needs, of a file that is longer.
inline constexpr std::size_t file_head = 4096;

/// @param what      "a PX4 ULog"; empty where nothing is recognised
/// @param expected  what stands in its place, "a scenario file (TOML)"; with what to do
/// @param is_text   of a kind that is text, so that it may be TOML nevertheless
struct FileKind {
  std::string_view what{}, expected{};
  bool is_text = false;
};

/// The kind of what begins like this.
FileKind file_kind(std::string_view head);

/// "this is a PX4 ULog, expected a scenario file (TOML); ..."; empty where nothing is recognised.
std::string kind_sentence(const FileKind& kind);

/// The log in the folder of a run, FOLDER/run.mcap.
/// @throws std::invalid_argument with a sentence where there is none; of a file, with what that is
std::filesystem::path log_of(const std::filesystem::path& folder);

}  // namespace sightline
