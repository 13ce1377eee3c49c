/// Topics and messages for the Foxglove clients of a page, from the thread that produces them to
/// the thread that serves them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "sightline/log.hpp"
#include "sightline/server/connection.hpp"
#include "sightline/server/foxglove.hpp"

namespace sightline {

/// Keeps messages of subscribed topics and passes them on in batches. If the waiting batches would
/// exceed `waiting_max`, they are dropped and counted. Two threads use it: a producer and a server.
class FoxgloveFeed final : public MessageSink {
 public:
  static constexpr std::size_t waiting_max = std::size_t{8} << 20;  ///< most bytes of waiting messages [B]

  /// @param name  of the flight
  explicit FoxgloveFeed(std::string name);

  // For the producer's thread.

  SchemaId schema(std::string_view name, std::string_view encoding, std::string_view text) override;
  ChannelId channel(SchemaId schema, std::string_view topic, std::string_view message_encoding,
                    const McapWords& metadata) override;
  void message(ChannelId channel, std::uint32_t sequence, std::uint64_t log_time,
               std::span<const std::byte> bytes) override;
  /// Passes on the messages since the last call as one batch.
  /// @param time  of the batch, the end of its messages [ns]
  void hand_over(std::uint64_t time);
  /// Whether a topic has a subscriber.
  bool is_requested() const;

  // For the server's thread.

  struct Message {
    ChannelId channel{};
    std::uint64_t time = 0;         // [ns]
    std::size_t at = 0, count = 0;  // range in the bytes of its batch
  };
  struct Batch {
    std::uint64_t time = 0;  // [ns]
    std::vector<Message> messages{};
    std::string bytes{};
  };
  /// Readable while batches wait; for poll(2).
  int fd() const { return waiting_.get(); }
  /// Returns the waiting batches, the oldest first.
  std::vector<Batch> take();
  const std::string& name() const { return name_; }
  const std::string& session() const { return session_; }
  /// Channels from the id `from` on, in the order of their ids, which count from 0.
  std::vector<FoxgloveChannel> channels(std::size_t from) const;
  std::size_t channel_count() const;
  /// Adds or removes a subscriber of a channel.
  void subscribed(ChannelId channel);
  void unsubscribed(ChannelId channel);

  /// Messages that were dropped because they were not served in time.
  std::int64_t dropped() const;

 private:
  struct Schema {
    std::string name, encoding, text;
  };

  std::string name_, session_;
  OwnedDescriptor waiting_;
  std::vector<Schema> schemas_;  // of the producer's thread
  Batch open_;

  mutable std::mutex lock_;  // guards the members below
  std::vector<FoxgloveChannel> channels_;
  std::vector<int> subscribers_;  // number for each channel
  int subscriptions_ = 0;
  std::vector<Batch> batches_;
  std::size_t bytes_ = 0;  // of batches_ [B]
  std::int64_t dropped_ = 0;
};

}  // namespace sightline
