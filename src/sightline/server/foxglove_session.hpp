/// Session of one client of Foxglove's protocol: its subscriptions and the messages to it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "sightline/server/connection.hpp"
#include "sightline/server/foxglove_feed.hpp"
#include "sightline/server/websocket.hpp"

namespace sightline {

/// Used only by the server's thread.
class FoxgloveSession {
 public:
  static constexpr std::size_t message_limit = std::size_t{64} << 10;  ///< of a message of the client [B]
  static constexpr int messages_a_second = 1000;  ///< of the client; a viewer subscribes topic by topic
  static constexpr std::size_t waiting_max = std::size_t{4} << 20;  ///< output that is not sent yet [B]

  /// Sends serverInfo and all topics. Both arguments must outlive this object.
  FoxgloveSession(FoxgloveFeed& feed, Connection& to);
  ~FoxgloveSession();
  FoxgloveSession(const FoxgloveSession&) = delete;
  FoxgloveSession& operator=(const FoxgloveSession&) = delete;

  /// Handles a message of the client: subscribes, unsubscribes, or sends the reason of a refusal.
  void receive(const WebsocketReader::Frame& message);
  /// Sends new topics, the messages of subscribed topics, and the time. Drops what would exceed
  /// `waiting_max`.
  void send(const std::vector<FoxgloveFeed::Batch>& batches);

  std::int64_t sent() const { return sent_; }  ///< messages of topics
  std::int64_t dropped() const { return dropped_; }

 private:
  void advertise();
  void subscribe(const FoxgloveSubscribe& request);
  void unsubscribe(const FoxgloveUnsubscribe& request);
  void send_status(FoxgloveLevel level, std::string_view sentence);
  bool put(WebsocketOp op, std::string_view message);

  FoxgloveFeed& feed_;
  Connection& to_;
  std::size_t advertised_ = 0;
  std::map<std::uint32_t, std::uint32_t> subscription_of_;  // by channel
  std::map<std::uint32_t, std::uint32_t> channel_of_;       // by subscription
  std::int64_t sent_ = 0, dropped_ = 0, reported_dropped_ = 0;
};

}  // namespace sightline
