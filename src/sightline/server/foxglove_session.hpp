/// One client that speaks Foxglove's protocol: what it has subscribed to, and what it is told.
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

/// Of the thread that serves.
class FoxgloveSession {
 public:
  static constexpr std::size_t message_limit = std::size_t{64} << 10;  ///< of the client [B]
  static constexpr int messages_a_second = 1000;  ///< of the client: a viewer subscribes topic by topic
  static constexpr std::size_t waiting_max = std::size_t{4} << 20;  ///< that the client has not taken [B]

  /// Greets: serverInfo, and all topics. Both outlive this.
  FoxgloveSession(FoxgloveFeed& feed, Connection& to);
  ~FoxgloveSession();
  FoxgloveSession(const FoxgloveSession&) = delete;
  FoxgloveSession& operator=(const FoxgloveSession&) = delete;

  /// Takes a message of the client: subscribes, unsubscribes, or says why not.
  void receive(const WebsocketReader::Frame& message);
  /// Tells of topics that are new, of the messages that it has subscribed to, and the time. What does not fit behind what it has not
  /// taken is left out.
  void tell(const std::vector<FoxgloveFeed::Batch>& batches);

  std::int64_t sent() const { return sent_; }  ///< Messages of topics.
  std::int64_t dropped() const { return dropped_; }

 private:
  void advertise();
  void subscribe(const FoxgloveSubscribe& request);
  void unsubscribe(const FoxgloveUnsubscribe& request);
  void say(FoxgloveLevel level, std::string_view sentence);
  bool put(WebsocketOp op, std::string_view message);

  FoxgloveFeed& feed_;
  Connection& to_;
  std::size_t advertised_ = 0;
  std::map<std::uint32_t, std::uint32_t> subscription_of_;  // of channels
  std::map<std::uint32_t, std::uint32_t> channel_of_;       // of subscriptions
  std::int64_t sent_ = 0, dropped_ = 0, reported_dropped_ = 0;
};

}  // namespace sightline
