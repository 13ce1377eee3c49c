/// What a server says in Foxglove's protocol, message by message.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "sightline/server/websocket.hpp"
#include "tests/support/page_client.hpp"

namespace sightline::test {

class FoxgloveEars {
 public:
  struct Heard {
    WebsocketOp op{};
    std::string payload{};
    /// Of a binary message with a topic's message.
    bool is_message() const { return op == WebsocketOp::binary && payload.size() >= 13 && payload[0] == 1; }
    std::uint32_t subscription() const { return static_cast<std::uint32_t>(number(1, 4)); }
    std::uint64_t time() const { return number(5, 8); }  // [ns]
    std::string bytes() const { return payload.substr(13); }
    nlohmann::json json() const { return nlohmann::json::parse(payload); }

   private:
    std::uint64_t number(std::size_t at, std::size_t count) const {
      std::uint64_t value = 0;
      for (std::size_t i = count; i-- > 0;)
        value = (value << 8U) | static_cast<unsigned char>(payload.at(at + i));
      return value;
    }
  };

  void take(std::string_view bytes) { bytes_ += bytes; }
  /// The next whole message of what was taken.
  std::optional<Heard> next() {
    const auto at = [&](std::size_t i) {
      return static_cast<std::uint64_t>(static_cast<unsigned char>(bytes_[i]));
    };
    if (bytes_.size() < 2) return std::nullopt;
    const std::size_t more = at(1) == 126 ? 2 : at(1) == 127 ? 8 : 0;
    if (bytes_.size() < 2 + more) return std::nullopt;
    std::uint64_t length = more == 0 ? at(1) : 0;
    for (std::size_t i = 0; i < more; ++i) length = (length << 8U) | at(2 + i);
    if (bytes_.size() < 2 + more + length) return std::nullopt;
    Heard received{static_cast<WebsocketOp>(at(0) & 0x0fU), bytes_.substr(2 + more, length)};
    bytes_.erase(0, 2 + more + length);
    return received;
  }
  /// The next message of a client, within so long [s].
  std::optional<Heard> next(PageClient& client, double seconds = 5.0) {
    for (;;) {
      if (auto received = next()) return received;
      const std::string bytes = client.hear_some(seconds);
      if (bytes.empty()) return std::nullopt;
      take(bytes);
    }
  }
  /// The next of its kind in JSON, {"op": ..}; null: none came.
  nlohmann::json next_op(PageClient& client, std::string_view op, double seconds = 5.0) {
    while (const auto received = next(client, seconds))
      if (received->op == WebsocketOp::text)
        if (auto json = received->json(); json["op"] == op) return json;
    return nullptr;
  }

 private:
  std::string bytes_;
};

/// Subscribes to a channel under an id.
inline std::string subscribe_frame(std::uint32_t id, std::uint32_t channel) {
  return PageClient::masked(
      1, fmt::format(R"({{"op":"subscribe","subscriptions":[{{"id":{},"channelId":{}}}]}})", id, channel));
}

/// The id of a topic in an advertisement; none: it is not there.
inline std::optional<std::uint32_t> advertised(const nlohmann::json& advertise, std::string_view topic) {
  for (const auto& channel : advertise.at("channels"))
    if (channel.at("topic") == topic) return channel.at("id").get<std::uint32_t>();
  return std::nullopt;
}

}  // namespace sightline::test
