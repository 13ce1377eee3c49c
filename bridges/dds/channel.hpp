/// Writers and readers of one message each, under the names and with the qualities of service that ROS 2 has.
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

#include "bridges/dds/message_type.hpp"

struct ddsi_serdata;

namespace sightline::dds {

struct Quality {
  bool reliable = false, transient_local = false;
  int depth = 1;
};
inline constexpr Quality of_sensors = {};                     // whatever comes, the newest
inline constexpr Quality of_px4_output = {false, true, 1};    // what a client of PX4 writes by
inline constexpr Quality of_ros_commands = {true, false, 1};  // matches readers of both kinds
inline constexpr Quality of_services = {true, false, 10};

/// Where what is ours lives in a domain, and whether it writes there. Who is silent cannot send, and nobody sees a writer of his.
enum class PublishMode { on, off };
struct Port {
  dds_entity_t participant;
  PublishMode publish = PublishMode::on;

  Port(dds_entity_t of, PublishMode publish_mode = PublishMode::on)
      : participant(of), publish(publish_mode) {}
  operator dds_entity_t() const { return participant; }
};

/// A text of a message; empty where the message has none.
inline std::string_view text_in(const char* text) noexcept { return text != nullptr ? text : ""; }

/// An entity of Cyclone DDS: a topic, a reader, a writer. Its end waits for its listeners.
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

  dds_entity_t get() const noexcept { return made_; }  ///< 0: none; below: a dds_return_t that says why not

 private:
  dds_entity_t made_ = 0;
};

/// A writer or a reader of the domain, with the names of its topic and of its type as on the wire.
struct SeenWriter {
  std::string topic, type;
  dds_guid_t guid{};
};

/// All of them that are alive, asked as often as one likes. One thread.
class WriterList {
 public:
  /// @param of  of readers, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION
  /// @throws std::runtime_error where nobody says
  explicit WriterList(dds_entity_t participant, dds_entity_t of = DDS_BUILTIN_TOPIC_DCPSPUBLICATION);
  std::vector<SeenWriter> look();

 private:
  Entity reader_;
  std::vector<void*> samples_;
  std::vector<dds_sample_info_t> infos_;
};

/// A writer of messages of a type of IDL.
class RawWriter {
 public:
  /// @param topic  of ROS, "/a/b"; as on the wire where it does not begin with /
  /// @throws std::runtime_error with the topic
  RawWriter(Port at, const dds_topic_descriptor_t& type, const std::string& topic, Quality quality);
  RawWriter(const RawWriter&) = delete;
  RawWriter& operator=(const RawWriter&) = delete;

  /// Sends; a reader that does not keep up misses it. Nothing is allocated for messages up to 256 bytes.
  bool write(const void* message) noexcept {
    return entity_.get() > 0 && dds_write(entity_.get(), message) == DDS_RETCODE_OK;
  }
  /// Readers that there are.
  int matched() const noexcept;
  /// Whether somebody reads it; of a silent one, whether somebody would, by its topic and type.
  bool received(std::span<const SeenWriter> readers) const;
  /// When the last of them came, of the monotonic clock [ns]; 0: never. Of any thread.
  std::int64_t reader_came() const noexcept { return reader_came_; }
  dds_entity_t entity() const noexcept { return entity_.get(); }
  /// Of these, those of the same topic that are not ours.
  int rivals(std::span<const SeenWriter> writers) const;
  const std::string& topic() const { return topic_; }
  const std::string& type() const { return type_; }  ///< as on the wire

 private:
  std::string topic_, type_;
  std::atomic<std::int64_t> reader_came_{0};
  Entity of_topic_, entity_;  // of a silent one: none; the last first
};

template <class M>
class Writer : public RawWriter {
 public:
  using RawWriter::RawWriter;
  bool operator()(const M& message) noexcept { return write(&message); }
};

/// What is known of a message besides what it says.
struct Arrival {
  std::int64_t monotonic = 0;  ///< when it came [ns]
  std::uint64_t writer = 0;    ///< a number of its own for each
  std::size_t size = 0;        ///< of the message on the wire [bytes], filled up to a multiple of 4
};

/// What a reader met. Read by any thread.
struct ReaderCounts {
  std::atomic<std::int64_t> received{0};
  std::atomic<std::int64_t> too_short{0}, too_long{0};  ///< of another release
  std::atomic<std::int64_t> unreadable{0};              ///< of the right size, and not its type
  std::atomic<std::int64_t> foreign{0};                 ///< of a second writer, where one is kept
  std::atomic<std::uint32_t> wrong_size{0};             ///< the last of these [bytes]
};

/// Of messages that hold strings and lists; larger ones are refused before they are unpacked [bytes].
inline constexpr std::size_t payload_max = 1 << 20;

enum class Writers { all, first };

/// Reads in the thread that receives, whole messages of the right size alone: Cyclone DDS drops those that are too short and
/// delivers those that are too long with wrong fields.
class RawReader {
 public:
  using Take = std::function<void(const void* message, const Arrival&)>;
  /// @param payload  its size on the wire [bytes]; none: any up to payload_max
  /// @param take     called in the thread that receives
  /// @throws std::runtime_error with the topic
  RawReader(dds_entity_t participant, const dds_topic_descriptor_t& type, const std::string& topic,
            Quality quality, std::optional<std::size_t> payload, Writers writers, Take take);
  RawReader(const RawReader&) = delete;
  RawReader& operator=(const RawReader&) = delete;

  const ReaderCounts& counts() const { return counts_; }
  /// Writers that came so far, those that left included. Of any thread.
  int writers_came() const noexcept { return writers_came_; }
  const std::string& topic() const { return topic_; }
  std::string type() const { return wire_type(type_.m_typename); }
  /// Writers that there are.
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
  std::vector<std::uint64_t> scratch_;  // one message
  Entity of_topic_, entity_;            // last: what it fills outlives it
};

template <class M>
RawReader::Take taking(std::function<void(const M&, const Arrival&)> take) {
  return [take = std::move(take)](const void* message, const Arrival& arrival) {
    take(*static_cast<const M*>(message), arrival);
  };
}

}  // namespace sightline::dds
