/// WebSocket (RFC 6455) on the server's side: the answer to a key, frames to a client, and frames from it within bounds.
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

/// Why a connection is closed.
enum class WebsocketClose : std::uint16_t {
  normal = 1000,
  going_away = 1001,
  not_the_protocol = 1002,
  against_the_rules = 1008,
  too_long = 1009
};

/// What Sec-WebSocket-Accept says to a key; its length and alphabet are the caller's to check.
std::string websocket_accept(std::string_view key);
/// Whether a key is 16 bytes in base64.
bool is_websocket_key(std::string_view key);

/// A whole message to a client, in one frame.
std::string websocket_frame(WebsocketOp op, std::string_view payload);
std::string websocket_close(WebsocketClose why);

/// Cuts what a client sends into frames. Holds no more than one frame of `limit` bytes.
class WebsocketReader {
 public:
  struct Frame {
    WebsocketOp op{};
    std::string payload{};
    bool last = true;  ///< of its message
  };
  /// @param limit  longest payload [B], at least that of a control frame, 125
  explicit WebsocketReader(std::size_t limit) : limit_(limit) {}
  void set_limit(std::size_t limit) { limit_ = limit; }

  void take(std::string_view bytes) { bytes_ += bytes; }
  /// The next whole frame; none where more is to come, or where it can not go on.
  std::optional<Frame> next();
  /// Why it can not go on; none where it can.
  std::optional<WebsocketClose> fault() const { return fault_; }

 private:
  std::size_t limit_;
  std::string bytes_;
  std::optional<WebsocketClose> fault_{};
};

}  // namespace sightline
