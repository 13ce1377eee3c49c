#include "sightline/server/websocket.hpp"

#include <array>
#include <boost/beast/websocket/detail/hybi13.hpp>

namespace sightline {
namespace {

bool is_known(unsigned op) { return op <= 2 || (op >= 8 && op <= 10); }

}  // namespace

std::string websocket_accept(std::string_view key) {
  boost::beast::websocket::detail::sec_ws_accept_type accept;
  boost::beast::websocket::detail::make_sec_ws_accept(accept, {key.data(), key.size()});
  return {accept.data(), accept.size()};
}

bool is_websocket_key(std::string_view key) {
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  return key.size() == 24 && key.find_first_not_of(letters) == 22 && key.ends_with("==");
}

std::string websocket_frame(WebsocketOp op, std::string_view payload) {
  std::string frame;
  frame += static_cast<char>(0x80U | static_cast<unsigned>(op));
  const std::size_t n = payload.size();
  const auto bytes = [&](int count) {
    for (int shift = 8 * (count - 1); shift >= 0; shift -= 8)
      frame += static_cast<char>(n >> static_cast<unsigned>(shift));
  };
  if (n < 126) {
    bytes(1);
  } else if (n < 65536) {
    frame += static_cast<char>(126);
    bytes(2);
  } else {
    frame += static_cast<char>(127);
    bytes(8);
  }
  frame += payload;
  return frame;
}

std::string websocket_close(WebsocketClose why) {
  const auto code = static_cast<unsigned>(why);
  const std::array<char, 2> payload = {static_cast<char>(code >> 8U), static_cast<char>(code & 0xffU)};
  return websocket_frame(WebsocketOp::close, {payload.data(), payload.size()});
}

std::optional<WebsocketReader::Frame> WebsocketReader::next() {
  const auto at = [&](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(bytes_[i])); };
  if (fault_ || bytes_.size() < 2) return std::nullopt;
  const unsigned op = at(0) & 0x0fU, stated = at(1) & 0x7fU;
  // Faults: reserved bits, unknown opcodes, unmasked frames, control frames in fragments or above
  // 125 bytes.
  const bool control = op >= 8;
  if ((at(0) & 0x70U) != 0 || !is_known(op) || (at(1) & 0x80U) == 0 ||
      (control && ((at(0) & 0x80U) == 0 || stated > 125))) {
    fault_ = WebsocketClose::not_the_protocol;
    return std::nullopt;
  }
  const std::size_t more = stated == 126 ? 2 : stated == 127 ? 8 : 0, head = 2 + more + 4;
  if (bytes_.size() < 2 + more) return std::nullopt;
  std::uint64_t length = more == 0 ? stated : 0;
  for (std::size_t i = 0; i < more; ++i) length = (length << 8U) | at(2 + i);
  if (length > limit_) {
    fault_ = WebsocketClose::too_long;
    return std::nullopt;
  }
  if (bytes_.size() < head + length) return std::nullopt;
  Frame frame{static_cast<WebsocketOp>(op), bytes_.substr(head, length), (at(0) & 0x80U) != 0};
  for (std::size_t i = 0; i < length; ++i)
    frame.payload[i] = static_cast<char>(frame.payload[i] ^ bytes_[head - 4 + i % 4]);
  bytes_.erase(0, head + length);
  return frame;
}

}  // namespace sightline
