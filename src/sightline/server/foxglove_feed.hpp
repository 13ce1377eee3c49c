/// What Foxglove's clients of a page are told: topics and their messages, from the thread that makes them to the one that serves them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "sightline/record/mcap.hpp"
#include "sightline/server/connection.hpp"
#include "sightline/server/foxglove.hpp"

namespace sightline {

/// Keeps messages of topics that somebody has subscribed to, and hands them over in batches; where those wait too long, the oldest
/// go, and are counted. Two threads: one feeds, one serves.
class FoxgloveFeed final : public MessageSink {
 public:
  static constexpr std::size_t waiting_max = std::size_t{8} << 20;  ///< bytes of messages that wait [B]

  /// @param name  of what is flown
  explicit FoxgloveFeed(std::string name);

  // By the thread that feeds.

  SchemaId schema(std::string_view name, std::string_view encoding, std::string_view text) override;
  ChannelId channel(SchemaId schema, std::string_view topic, std::string_view message_encoding,
                    const McapWords& metadata) override;
  void message(ChannelId channel, std::uint32_t sequence, std::uint64_t log_time,
               std::span<const std::byte> bytes) override;
  /// Hands over what came since the last time.
  /// @param time  up to which it goes [ns]
  void hand_over(std::uint64_t time);
  /// Whether somebody has subscribed to a topic.
  bool is_requested() const;

  // By the thread that serves.

  struct Message {
    ChannelId channel{};
    std::uint64_t time = 0;         // [ns]
    std::size_t at = 0, count = 0;  // in the bytes of its batch
  };
  struct Batch {
    std::uint64_t time = 0;  // [ns]
    std::vector<Message> messages{};
    std::string bytes{};
  };
  /// Readable while batches wait: for poll(2).
  int fd() const { return waiting_.get(); }
  /// The batches that wait, the oldest first.
  std::vector<Batch> take();
  const std::string& name() const { return name_; }
  const std::string& session() const { return session_; }
  /// From this one on, in the order of their ids, which count from 0.
  std::vector<FoxgloveChannel> channels(std::size_t from) const;
  std::size_t channel_count() const;
  /// One more, or one less, subscribes to it.
  void subscribed(ChannelId channel);
  void unsubscribed(ChannelId channel);

  /// Messages that went because nobody served them.
  std::int64_t dropped() const;

 private:
  struct Schema {
    std::string name, encoding, text;
  };

  std::string name_, session_;
  OwnedDescriptor waiting_;
  std::vector<Schema> schemas_;  // of the thread that feeds
  Batch open_;

  mutable std::mutex lock_;  // of what follows
  std::vector<FoxgloveChannel> channels_;
  std::vector<int> subscribers_;  // of each channel
  int subscriptions_ = 0;
  std::vector<Batch> batches_;
  std::size_t bytes_ = 0;  // of them
  std::int64_t dropped_ = 0;
};

}  // namespace sightline
