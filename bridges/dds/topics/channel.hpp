/// DDS readers and writers for one message type each, with ROS 2 topic names and qualities of
/// service.
#pragma once

#include <dds/dds.h>

#include <atomic>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bridges/dds/topics/message_type.hpp"

struct ddsi_serdata;

namespace sightline::dds {

struct Quality {
  bool reliable = false, transient_local = false;
  int depth = 1;
};
inline constexpr Quality of_sensors = {};                     // best effort, newest message only
inline constexpr Quality of_px4_output = {false, true, 1};    // as PX4's uXRCE-DDS client writes
inline constexpr Quality of_ros_commands = {true, false, 1};  // matches reliable and best-effort readers
inline constexpr Quality of_services = {true, false, 10};

/// Participant and publish mode. With PublishMode::off no DDS writer is created, so other programs
/// discover none and nothing is sent.
enum class PublishMode { on, off };
struct Port {
  dds_entity_t participant;
  PublishMode publish = PublishMode::on;

  Port(dds_entity_t of, PublishMode publish_mode = PublishMode::on)
      : participant(of), publish(publish_mode) {}
  operator dds_entity_t() const { return participant; }
};

/// The string field of a message; empty if the pointer is null.
inline std::string_view text_in(const char* text) noexcept { return text != nullptr ? text : ""; }

/// Owner of a Cyclone DDS entity: a topic, a reader or a writer. The destructor waits for the
/// entity's listeners to return.
class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t made) : made_(made) {}
  ~Entity() {
    if (made_ > 0) dds_delete(made_);
  }
  Entity(Entity&& other) noexcept : made_(std::exchange(other.made_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(made_, other.made_);
    return *this;
  }

  dds_entity_t get() const noexcept { return made_; }  ///< 0: no entity; < 0: the dds_return_t error code

 private:
  dds_entity_t made_ = 0;
};

/// A writer or reader discovered in the domain; topic and type names are those on the wire.
struct SeenWriter {
  std::string topic, type;
  dds_guid_t guid{};
};

/// All writers (or readers) that are alive in the domain; look() may be called at any rate. Single
/// thread.
class WriterList {
 public:
  /// @param of  DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION lists the readers instead of the writers
  /// @throws std::runtime_error if the built-in topic cannot be read
  explicit WriterList(dds_entity_t participant, dds_entity_t of = DDS_BUILTIN_TOPIC_DCPSPUBLICATION);
  std::vector<SeenWriter> look();

 private:
  Entity reader_;
  std::vector<void*> samples_;
  std::vector<dds_sample_info_t> infos_;
};

/// Writer of messages of one IDL type.
class RawWriter {
 public:
  /// @param topic  ROS name, "/a/b"; a name without a leading / is used as it is on the wire
  /// @throws std::runtime_error with the topic
  RawWriter(Port at, const dds_topic_descriptor_t& type, const std::string& topic, Quality quality);
  RawWriter(const RawWriter&) = delete;
  RawWriter& operator=(const RawWriter&) = delete;

  /// Sends a message; a reader that does not keep up loses it. Messages up to 256 bytes need no
  /// allocation.
  bool write(const void* message) noexcept {
    return entity_.get() > 0 && dds_write(entity_.get(), message) == DDS_RETCODE_OK;
  }
  /// Number of matched readers.
  int matched() const noexcept;
  /// Whether a reader receives this topic. With PublishMode::off: whether a reader of this topic
  /// and type exists.
  bool received(std::span<const SeenWriter> readers) const;
  /// Monotonic time at which the last reader matched [ns]; 0: none yet. Any thread may call it.
  std::int64_t reader_came() const noexcept { return reader_came_; }
  dds_entity_t entity() const noexcept { return entity_.get(); }
  /// Number of `writers` on this topic other than this one.
  int rivals(std::span<const SeenWriter> writers) const;
  const std::string& topic() const { return topic_; }
  const std::string& type() const { return type_; }  ///< on the wire

 private:
  std::string topic_, type_;
  std::atomic<std::int64_t> reader_came_{0};
  Entity of_topic_, entity_;  // none with PublishMode::off; entity_ is destroyed first
};

template <class M>
class Writer : public RawWriter {
 public:
  using RawWriter::RawWriter;
  bool operator()(const M& message) noexcept { return write(&message); }
};

/// Metadata of a received message.
struct Arrival {
  std::int64_t monotonic = 0;  ///< time of arrival, monotonic clock [ns]
  std::uint64_t writer = 0;    ///< identifier of the writer, unique per writer
  std::size_t size = 0;        ///< of the message on the wire [bytes], padded to a multiple of 4
};

/// Counters of a reader. Any thread may read them.
struct ReaderCounts {
  std::atomic<std::int64_t> received{0};
  std::atomic<std::int64_t> too_short{0}, too_long{0};  ///< messages of another release
  std::atomic<std::int64_t> unreadable{0};              ///< right size, but not of the type
  std::atomic<std::int64_t> foreign{0};                 ///< from a second writer, with Writers::first
  std::atomic<std::uint32_t> wrong_size{0};             ///< last wrong size [bytes]
};

/// Largest payload of messages with strings and sequences; larger ones are rejected before
/// deserialisation [bytes].
inline constexpr std::size_t payload_max = 1 << 20;

enum class Writers { all, first };

/// Reads in the receive thread and accepts only messages of the expected size. Cyclone DDS itself
/// drops messages that are too short, but delivers those that are too long with wrong fields.
class RawReader {
 public:
  using Take = std::function<void(const void* message, const Arrival&)>;
  /// @param payload  size on the wire [bytes]; none: any size up to payload_max
  /// @param take     called in the receive thread
  /// @throws std::runtime_error with the topic
  RawReader(dds_entity_t participant, const dds_topic_descriptor_t& type, const std::string& topic,
            Quality quality, std::optional<std::size_t> payload, Writers writers, Take take);
  RawReader(const RawReader&) = delete;
  RawReader& operator=(const RawReader&) = delete;

  const ReaderCounts& counts() const { return counts_; }
  /// Number of writers that have matched so far, including those that left. Any thread may call it.
  int writers_came() const noexcept { return writers_came_; }
  const std::string& topic() const { return topic_; }
  std::string type() const { return wire_type(type_.m_typename); }
  /// Number of writers that are matched now.
  int matched() const noexcept;

 private:
  static void on_data(dds_entity_t reader, void* self);
  static void on_writer(dds_entity_t reader, dds_subscription_matched_status_t status, void* self);
  void take(const ddsi_serdata* data, std::uint64_t writer);

  std::string topic_;
  const dds_topic_descriptor_t& type_;
  std::optional<std::size_t> payload_;
  Writers writers_;
  Take take_;
  ReaderCounts counts_;
  std::atomic<int> writers_came_{0};
  std::uint64_t first_writer_ = 0;
  std::vector<std::uint64_t> scratch_;  // storage for one message
  Entity of_topic_, entity_;            // last member: destroyed before the members that its listener fills
};

template <class M>
RawReader::Take taking(std::function<void(const M&, const Arrival&)> take) {
  return [take = std::move(take)](const void* message, const Arrival& arrival) {
    take(*static_cast<const M*>(message), arrival);
  };
}

}  // namespace sightline::dds
