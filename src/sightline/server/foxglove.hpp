/// Foxglove's WebSocket protocol (foxglove.websocket.v1) for a server that only publishes; works on
/// strings, without sockets.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace sightline {

/// Names of the protocol in Sec-WebSocket-Protocol; the messages used here are equal under both.
inline constexpr std::array<std::string_view, 2> foxglove_protocols = {"foxglove.websocket.v1",
                                                                       "foxglove.sdk.v1"};
/// The first supported protocol in a client's list; empty: none.
/// @param named  "foxglove.sdk.v1, foxglove.websocket.v1"
std::string_view foxglove_protocol(std::string_view named);

/// A topic that clients may subscribe to.
struct FoxgloveChannel {
  std::uint32_t id = 0;
  std::string topic, encoding;                       ///< "/uav0/pose", "cdr"
  std::string schema_name, schema_encoding, schema;  ///< "geometry_msgs/msg/PoseStamped", "ros2msg", its text
};

enum class FoxgloveLevel : std::uint8_t { info = 0, warning = 1, error = 2 };

/// Text messages to a client.
/// @param session  id; a new one invalidates all that was sent before
std::string foxglove_server_info(std::string_view name, std::string_view session);
std::string foxglove_advertise(std::span<const FoxgloveChannel> channels);
std::string foxglove_status(FoxgloveLevel level, std::string_view sentence);

/// Binary messages to a client.
/// @param time  [ns]
std::string foxglove_message(std::uint32_t subscription, std::uint64_t time, std::string_view bytes);
std::string foxglove_time(std::uint64_t time);

/// Requests of a client.
struct FoxgloveSubscribe {
  struct Subscription {
    std::uint32_t id = 0, channel = 0;  ///< id: chosen by the client
  };
  std::vector<Subscription> subscriptions;
};
struct FoxgloveUnsubscribe {
  std::vector<std::uint32_t> ids;  ///< of subscriptions
};
struct FoxgloveRefused {
  std::string why;  ///< a sentence for the client
};
using FoxgloveRequest = std::variant<FoxgloveSubscribe, FoxgloveUnsubscribe, FoxgloveRefused>;

/// Parses a text message of a client; accepts any bytes.
FoxgloveRequest read_foxglove(std::string_view text);

}  // namespace sightline
