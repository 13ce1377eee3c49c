/// Reader of recordings in the MCAP format (mcap.dev): logs of runs, and bags of ROS 2.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// Constants of the MCAP specification, and our own limits.
namespace mcap {

inline constexpr std::string_view magic = "\x89MCAP0\r\n";               // first and last bytes of every file
inline constexpr std::uint64_t record_head = 9;                          // kind and length of a record [B]
inline constexpr std::uint64_t record_limit = std::uint64_t{128} << 20;  // upper bound on our records [B]

/// Kinds of records.
enum RecordKind : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema_record = 0x03,
  channel_record = 0x04,
  message_record = 0x05,
  chunk_record = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  statistics = 0x0B,
  metadata_record = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F,
};

using Span = std::span<const std::byte>;

/// Continues a CRC-32 over more bytes; `crc` is that of the preceding bytes.
std::uint32_t crc32_of(std::uint32_t crc, Span bytes);

}  // namespace mcap

/// Key-value pairs that MCAP attaches to channels and metadata; sorted, so equal content gives
/// equal bytes.
using McapWords = std::map<std::string, std::string>;

/// One message of a log; the views are valid only during the visit.
struct McapMessage {
  std::string_view topic;
  std::string_view schema;    ///< name of the schema, "geometry_msgs/msg/PoseStamped"
  std::string_view encoding;  ///< "cdr" or "json"
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;  ///< [ns]
  std::span<const std::byte> bytes;
};

/// Reads a log of McapWriter, complete or truncated anywhere, without trusting its bytes.
///
/// The constructor scans the records and reads header and metadata. visit() reads everything and
/// checks every CRC. A log without its end (a killed run) is read up to its last complete chunk,
/// and truncated() is true. Any other fault gives a sentence in error() that names the byte offset.
class McapReader {
 public:
  explicit McapReader(const std::filesystem::path& path);
  ~McapReader();
  McapReader(const McapReader&) = delete;
  McapReader& operator=(const McapReader&) = delete;

  /// Passes every message to the visitor in file order, up to the first fault; a chunk is passed
  /// only if its CRC matches.
  /// @return ok()
  bool visit(const std::function<void(const McapMessage&)>& visitor);
  /// Passes the messages that were appended to a growing log since the last call, or since visit().
  /// An incomplete chunk is passed by a later call.
  /// @return ok()
  bool read_on(const std::function<void(const McapMessage&)>& visitor);

  bool ok() const { return error_.empty(); }           ///< True while no fault was found.
  const std::string& error() const { return error_; }  ///< The first fault, a sentence; empty if none.
  bool truncated() const { return truncated_; }        ///< True if the end of the log is missing.
  const std::string& profile() const { return profile_; }
  const std::string& library() const { return library_; }
  const std::map<std::string, McapWords>& metadata() const { return metadata_; }  ///< Pairs by name.

  /// A topic and the format of its messages.
  struct Topic {
    std::string topic, encoding;  ///< "cdr" or "json"
    std::string schema, schema_encoding,
        schema_text;  ///< "geometry_msgs/msg/PoseStamped", "ros2msg", its definition
  };
  /// Topics outside of chunks, where McapWriter writes them; in file order.
  std::vector<Topic> topics();

 private:
  struct Record {
    std::uint8_t kind = 0;
    std::uint64_t at = 0;      // offset of the record in the file [B]
    std::uint64_t length = 0;  // of its content [B]
  };
  struct Schema {
    std::string name, encoding, text;
  };

  void fail(std::uint64_t at, std::string_view what);
  bool fetch(std::uint64_t at, std::uint64_t count, std::span<const std::byte>& bytes);
  bool look_at_end();
  bool walk(const std::function<void(const McapMessage&)>& visitor);
  bool next(std::uint64_t& position, Record& record);
  void end_of_records(std::uint64_t position, std::string_view what);
  bool finish(std::uint64_t position);
  bool read_words(const Record& record, std::span<const std::byte> content);
  bool read_records(std::uint64_t at, std::span<const std::byte> records,
                    const std::function<void(const McapMessage&)>& visitor);
  bool read_chunk(const Record& record, std::span<const std::byte> content,
                  const std::function<void(const McapMessage&)>& visitor);
  bool read_record(std::uint64_t at, std::uint8_t kind, std::span<const std::byte> content,
                   const std::function<void(const McapMessage&)>& visitor);

  std::string path_, error_, profile_, library_;
  int file_ = -1;
  std::uint64_t size_ = 0;  // size of the file [B]
  bool truncated_ = false;
  bool sealed_ = false;  // the file ends in the closing magic
  // Read position of the messages: the next record; the CRC of the data section, then of the
  // summary.
  std::uint64_t position_ = 0;
  std::uint32_t crc_ = 0;
  bool in_summary_ = false, footed_ = false;
  std::map<std::string, McapWords> metadata_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Topic> channels_;
  std::vector<std::byte> window_;  // last part of the file that was read
  std::uint64_t window_at_ = 0;
  std::vector<std::byte> chunk_;  // last chunk that was read, uncompressed
};

}  // namespace sightline
