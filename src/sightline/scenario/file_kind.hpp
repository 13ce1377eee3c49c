/// Recognises files that are not scenarios (logs, calibrations, tables) by their first bytes.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace sightline {

/// Number of leading bytes that file_kind() needs [bytes].
inline constexpr std::size_t file_head = 4096;

/// Recordings that a command may read.
enum class RecordingKind { none, ulog, bag, table, run };  // run: our own log, or its folder

/// Result of file_kind().
/// @param what      "a PX4 ULog"; empty if the kind is unknown
/// @param expected  the expected file, "a scenario file (TOML)", and what to do
/// @param is_text   a text format, so that the file may be TOML nevertheless
/// @param recording  what reads it
/// @param is_yaml    YAML, in which a table is a word
/// @param packed_by  "gzip" or "zstd", if `what` is in an archive; else empty
struct FileKind {
  std::string_view what{}, expected{};
  bool is_text = false;
  RecordingKind recording = RecordingKind::none;
  std::string_view packed_by{};
  bool is_yaml = false;

  /// Whether RosBag reads it.
  bool is_bag() const {
    return packed_by.empty() && (recording == RecordingKind::bag || recording == RecordingKind::run);
  }
  /// "a PX4 ULog, packed by zstd"
  std::string shown() const;
};

/// Kind of a file that begins with `head`; of one that is packed, what is in it.
FileKind file_kind(std::string_view head);

/// Kind of a file or of a folder (of a run, of a rosbag2); `what` is empty if it is unknown or cannot be
/// read.
FileKind kind_at(const std::filesystem::path& place);

/// "this is a PX4 ULog, expected a scenario file (TOML); ..."; empty if the kind is unknown.
std::string kind_sentence(const FileKind& kind);

/// Path of the log in the folder of a run, FOLDER/run.mcap.
/// @throws std::invalid_argument if the folder has no log; for a file, the sentence names its kind
std::filesystem::path log_of(const std::filesystem::path& folder);

}  // namespace sightline
