/// Server side of WebSocket (RFC 6455): handshake key, frames to a client, and bounded frames from
/// it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sightline {

enum class WebsocketOp : std::uint8_t {
  continuation = 0x0,
  text = 0x1,
  binary = 0x2,
  close = 0x8,
  ping = 0x9,
  pong = 0xA
};

/// Reason to close a connection.
enum class WebsocketClose : std::uint16_t {
  normal = 1000,
  going_away = 1001,
  not_the_protocol = 1002,
  against_the_rules = 1008,
  too_long = 1009
};

/// Value of Sec-WebSocket-Accept for a key. The caller must check its length and alphabet.
std::string websocket_accept(std::string_view key);
/// Whether a key is 16 bytes in base64.
bool is_websocket_key(std::string_view key);

/// A complete message to a client, in one frame.
std::string websocket_frame(WebsocketOp op, std::string_view payload);
std::string websocket_close(WebsocketClose why);

/// Splits the bytes of a client into frames; bounds each payload by `limit` bytes.
class WebsocketReader {
 public:
  struct Frame {
    WebsocketOp op{};
    std::string payload{};
    bool last = true;  ///< whether it ends its message
  };
  /// @param limit  longest payload [B], at least 125, that of a control frame
  explicit WebsocketReader(std::size_t limit) : limit_(limit) {}
  void set_limit(std::size_t limit) { limit_ = limit; }

  void take(std::string_view bytes) { bytes_ += bytes; }
  /// The next complete frame; none if bytes are missing or a fault occurred.
  std::optional<Frame> next();
  /// The fault that stopped the reader; none: it can continue.
  std::optional<WebsocketClose> fault() const { return fault_; }

 private:
  std::size_t limit_;
  std::string bytes_;
  std::optional<WebsocketClose> fault_{};
};

}  // namespace sightline
