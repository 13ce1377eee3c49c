#include "sightline/server/websocket.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace sightline {
namespace {

using Sha1 = std::array<std::uint32_t, 5>;

constexpr std::string_view base64_letters =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

void add_block(Sha1& h, const unsigned char* block) {
  std::array<std::uint32_t, 80> w{};
  for (std::size_t i = 0; i < 16; ++i)
    for (std::size_t k = 0; k < 4; ++k) w[i] = (w[i] << 8U) | block[4 * i + k];
  for (std::size_t i = 16; i < 80; ++i) w[i] = std::rotl(w[i - 3] ^ w[i - 8] ^ w[i - 14] ^ w[i - 16], 1);
  auto [a, b, c, d, e] = h;
  for (std::size_t i = 0; i < 80; ++i) {
    const auto [f, k] = i < 20   ? std::pair((b & c) | (~b & d), 0x5A827999U)
                        : i < 40 ? std::pair(b ^ c ^ d, 0x6ED9EBA1U)
                        : i < 60 ? std::pair((b & c) | (b & d) | (c & d), 0x8F1BBCDCU)
                                 : std::pair(b ^ c ^ d, 0xCA62C1D6U);
    const std::uint32_t next = std::rotl(a, 5) + f + e + k + w[i];
    e = d, d = c, c = std::rotl(b, 30), b = a, a = next;
  }
  h[0] += a, h[1] += b, h[2] += c, h[3] += d, h[4] += e;
}

/// Not for secrecy: the protocol requires it so that other servers do not accept by chance.
std::string sha1(std::string_view text) {
  std::string padded(text);
  padded += '\x80';
  while (padded.size() % 64 != 56) padded += '\0';
  for (int shift = 56; shift >= 0; shift -= 8)
    padded += static_cast<char>((std::uint64_t{8} * text.size()) >> static_cast<unsigned>(shift));
  Sha1 h = {0x67452301, 0xEFCDAB89, 0x98BADCFE, 0x10325476, 0xC3D2E1F0};
  for (std::size_t at = 0; at < padded.size(); at += 64)
    add_block(h, reinterpret_cast<const unsigned char*>(padded.data()) + at);
  std::string digest;
  for (const std::uint32_t word : h)
    for (int shift = 24; shift >= 0; shift -= 8)
      digest += static_cast<char>(word >> static_cast<unsigned>(shift));
  return digest;
}

std::string base64(std::string_view bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = (group << 8U) | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? base64_letters[(group >> (18U - 6U * k)) & 63U] : '=';
  }
  return text;
}

bool is_known(unsigned op) { return op <= 2 || (op >= 8 && op <= 10); }

}  // namespace

std::string websocket_accept(std::string_view key) {
  return base64(sha1(std::string(key) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"));
}

bool is_websocket_key(std::string_view key) {
  return key.size() == 24 && key.ends_with("==") && std::all_of(key.begin(), key.end() - 2, [](char c) {
           return base64_letters.find(c) != std::string_view::npos;
         });
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
  const unsigned op = at(0) & 0x0fU, said = at(1) & 0x7fU;
  // Faults: reserved bits, unknown opcodes, unmasked frames, control frames in fragments or above
  // 125 bytes.
  const bool control = op >= 8;
  if ((at(0) & 0x70U) != 0 || !is_known(op) || (at(1) & 0x80U) == 0 ||
      (control && ((at(0) & 0x80U) == 0 || said > 125))) {
    fault_ = WebsocketClose::not_the_protocol;
    return std::nullopt;
  }
  const std::size_t more = said == 126 ? 2 : said == 127 ? 8 : 0, head = 2 + more + 4;
  if (bytes_.size() < 2 + more) return std::nullopt;
  std::uint64_t length = more == 0 ? said : 0;
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
