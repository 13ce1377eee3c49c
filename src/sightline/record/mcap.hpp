/// Writer and reader of logs in the MCAP format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct ZSTD_CCtx_s;

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

/// Identifier of a schema inside one log.
enum class SchemaId : std::uint16_t {};

/// Identifier of a channel inside one log.
enum class ChannelId : std::uint16_t {};
/// A channel and its message count so far.
struct McapChannel {
  ChannelId id{};
  std::uint32_t sequence = 0;
};

/// Key-value pairs that MCAP attaches to channels and metadata; sorted, so equal content gives
/// equal bytes.
using McapWords = std::map<std::string, std::string>;

/// Destination of log messages: a file or subscribers.
class MessageSink {
 public:
  MessageSink() = default;
  MessageSink(const MessageSink&) = delete;
  MessageSink& operator=(const MessageSink&) = delete;
  virtual ~MessageSink() = default;

  /// Adds a message type.
  /// @param encoding  "ros2msg" or "jsonschema"
  virtual SchemaId schema(std::string_view name, std::string_view encoding, std::string_view text) = 0;

  /// Adds a topic whose messages follow `schema`.
  /// @param message_encoding  "cdr" or "json"
  virtual ChannelId channel(SchemaId schema, std::string_view topic, std::string_view message_encoding,
                            const McapWords& metadata) = 0;

  /// Adds a message; allocates nothing once the buffers have reached their final size.
  /// @param log_time  [ns], also the time of publication
  virtual void message(ChannelId channel, std::uint32_t sequence, std::uint64_t log_time,
                       std::span<const std::byte> bytes) = 0;
};

/// Writes a log in the MCAP format (mcap.dev), which Foxglove, PlotJuggler and McapReader open.
///
/// Messages collect in a chunk. flush() compresses the chunk (zstd) and passes it to the kernel at
/// once by write(2). A killed run loses only the open chunk. Equal calls give equal bytes.
///
/// No disk failure throws. error() keeps the first failure as a sentence, later calls do nothing,
/// and the file is truncated to its last complete chunk. One thread at a time.
class McapWriter final : public MessageSink {
 public:
  /// Opens `path` for writing, truncates it and writes the header.
  /// @param profile  convention of the channels, "ros2"
  /// @param library  name and version of the writing program
  McapWriter(const std::filesystem::path& path, std::string_view profile, std::string_view library);
  ~McapWriter() override;  ///< Closes the log if close() was not called.

  SchemaId schema(std::string_view name, std::string_view encoding, std::string_view text) override;
  ChannelId channel(SchemaId schema, std::string_view topic, std::string_view message_encoding,
                    const McapWords& metadata) override;
  /// Appends to the open chunk; a chunk above 4 MiB closes automatically.
  void message(ChannelId channel, std::uint32_t sequence, std::uint64_t log_time,
               std::span<const std::byte> bytes) override;

  /// Closes the open chunk and writes it; does nothing if it contains no message.
  void flush();

  /// Writes key-value pairs about the whole log, immediately.
  void metadata(std::string_view name, const McapWords& words);

  /// Renames the file to `path`, replacing an existing file; later writes go to the same file.
  void settle(const std::filesystem::path& path);

  /// Writes the open chunk, the summary and the footer, and closes the file.
  void close();

  /// Closes the file after its last complete chunk without summary and footer, as a killed run
  /// leaves it.
  void abandon() noexcept;

  bool ok() const { return error_.empty(); }           ///< True until the first failure.
  const std::string& error() const { return error_; }  ///< The first failure, a sentence; empty if none.
  std::uint64_t bytes_written() const { return position_; }  ///< Length of the intact part of the file [B].

 private:
  using Bytes = std::vector<std::byte>;
  struct Entry {
    std::uint64_t log_time;  // [ns]
    std::uint64_t offset;    // of the message's record in the uncompressed chunk [B]
  };
  struct Channel {
    std::vector<Entry> entries;  // messages of the open chunk
    std::uint64_t messages = 0;  // in the whole log
  };

  void write(const Bytes& bytes);
  void fail(std::string_view what, int error_number);
  void write_chunk_indexes(std::uint64_t data_end_at);
  bool read_back(std::uint64_t at, std::span<std::byte> bytes);
  void write_summary();

  std::string path_;
  std::string error_;
  int file_ = -1;               // -1: closed or failed
  std::uint64_t position_ = 0;  // bytes written
  std::uint64_t sound_ =
      std::numeric_limits<std::uint64_t>::max();  // start of the summary [B], which is valid only if complete
  std::uint32_t crc_ = 0;                         // of the data section, then of the summary section
  std::unique_ptr<ZSTD_CCtx_s, std::size_t (*)(ZSTD_CCtx_s*)> zstd_;

  Bytes chunk_;  // records of the open chunk, uncompressed
  Bytes out_;    // buffer of one write to the kernel
  std::uint64_t chunk_first_ = 0, chunk_last_ = 0, chunk_messages_ = 0;
  std::vector<Channel> channels_;

  // The summary as it grows, one sequence of records per kind.
  Bytes schema_records_, channel_records_, metadata_indexes_;
  std::uint64_t first_ = 0, last_ = 0, messages_ = 0;
  std::uint32_t chunks_ = 0, metadata_count_ = 0;
  std::uint16_t schemas_ = 0;
};

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
