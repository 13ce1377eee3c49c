/// Logs of PX4 in the ULog format (docs.px4.io, "ULog File Format").
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sightline {

/// A log with its topics as columns. Frames and units are PX4's: NED, FRD, SI; times in microseconds
/// since the boot of the autopilot.
///
/// No byte is trusted: each length is compared with the bytes that are there before it is used. A log
/// without its end (a power cut) is read up to the cut, and truncated() is true; any other fault is
/// refused.
class ULog {
 public:
  /// Messages of one instance of a topic, in the order of the file.
  struct Topic {
    std::string name;                 ///< "vehicle_local_position"
    int instance = 0;                 ///< 0 to 255, of several that publish the same topic
    std::vector<std::uint32_t> at{};  ///< where each message begins in the file [bytes]

    std::string shown() const;  ///< name, and the instance unless it is 0: "battery_status[1]"
  };

  /// @param file  name for messages
  /// @throws std::invalid_argument if the bytes are no sound ULog: "x.ulg: byte 4711: ..."
  ULog(std::string bytes, std::string file);

  const std::string& file() const { return file_; }
  bool truncated() const { return truncated_; }
  const std::vector<Topic>& topics() const { return topics_; }
  /// @throws std::invalid_argument for a topic that was not logged, with the nearest name
  const Topic& topic(std::string_view name, int instance = 0) const;
  /// The topic, or null.
  const Topic* find(std::string_view name, int instance = 0) const;

  /// Values of a field, one for each message; elements and nested fields by "q[0]", "esc[1].rpm".
  /// T is double, std::int64_t or std::uint64_t. Numbers of 64 bits are rounded to double.
  /// @throws std::invalid_argument for a field that the topic lacks, with the nearest name, and for
  ///   a type that T does not hold
  template <class T = double>
  std::vector<T> column(const Topic& topic, std::string_view field) const;
  /// Whether the topic has that field.
  bool has(const Topic& topic, std::string_view field) const;
  /// Time stamps of the messages [us].
  std::vector<std::uint64_t> times(const Topic& topic) const {
    return column<std::uint64_t>(topic, "timestamp");
  }

  /// Texts about the system, "ver_hw", one or more for each key.
  const std::map<std::string, std::vector<std::string>, std::less<>>& info() const { return info_; }
  /// Parameters of the firmware; of one that changed in flight, the last value.
  const std::map<std::string, double, std::less<>>& parameters() const { return parameters_; }
  /// Durations in which messages were lost [ms].
  const std::vector<std::uint16_t>& dropouts() const { return dropouts_; }

 private:
  class Parser;
  struct Field {
    std::string type, name;
    std::size_t count = 1;  // of elements
    bool is_array = false;
  };
  struct Format {
    std::vector<Field> fields;
    std::size_t size = 0, least = 0;  // with and without padding at its end [bytes]; 0: not known yet
    bool has_time = false;            // once a subscription asked
  };
  struct Place {
    std::size_t offset = 0;  // in a message [bytes]
    std::size_t type = 0;    // index of a basic type
    bool found = false;
  };

  std::size_t size_of(const Field& field) const;
  Place place_of(std::string_view format, std::string_view path) const;
  std::vector<std::string_view> fields_of(const Topic& topic) const;

  std::string bytes_, file_;
  bool truncated_ = false;
  std::map<std::string, Format, std::less<>> formats_;
  std::vector<Topic> topics_;
  std::map<std::pair<std::string, int>, std::size_t> topic_of_;
  std::map<std::string, std::vector<std::string>, std::less<>> info_;
  std::map<std::string, double, std::less<>> parameters_;
  std::vector<std::uint16_t> dropouts_;
};

/// Reads a log, plain or packed by gzip or zstd.
/// @throws std::invalid_argument as ULog, and if the file cannot be read
ULog read_ulog(const std::filesystem::path& file);

}  // namespace sightline
