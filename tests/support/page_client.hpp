/// A client of a page on plain sockets, which says exactly what a test wants.
#pragma once

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "tests/support/child.hpp"

namespace sightline::test {

class PageClient {
 public:
  /// @param receive_room  of its kernel buffer [B]; 0: as usual
  explicit PageClient(std::uint16_t port, int receive_room = 0)
      : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), port_(port) {
    if (receive_room > 0) ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_room, sizeof receive_room);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~PageClient() { ::close(fd_); }
  PageClient(const PageClient&) = delete;
  PageClient& operator=(const PageClient&) = delete;

  bool connected() const { return connected_; }
  /// @return whether all of it was taken, within `seconds` for a piece
  bool say(std::string_view bytes, double seconds = 5.0) {
    while (!bytes.empty()) {
      if (!ready(POLLOUT, seconds)) return false;
      const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }
  /// What comes up to `end`, to the end of the stream, or until nothing comes for so long [s]. The
  /// rest is heard next.
  std::string receive(std::string_view end = "", double seconds = 5.0) {
    std::size_t found = std::string::npos;
    while ((end.empty() || (found = rest_.find(end)) == std::string::npos) && ready(POLLIN, seconds)) {
      char bytes[4096];
      const ssize_t n = ::recv(fd_, bytes, sizeof bytes, 0);
      if (n <= 0) {
        ended_ = true;
        break;
      }
      rest_.append(bytes, static_cast<std::size_t>(n));
    }
    const std::size_t length = found == std::string::npos ? rest_.size() : found + end.size();
    std::string received = rest_.substr(0, length);
    rest_.erase(0, length);
    return received;
  }
  /// What is there, at once, or within so long [s]; empty: nothing.
  std::string hear_some(double seconds) {
    if (rest_.empty() && ready(POLLIN, seconds)) {
      std::string bytes(65'536, '\0');
      const ssize_t n = ::recv(fd_, bytes.data(), bytes.size(), 0);
      ended_ = n <= 0;
      rest_.append(bytes, 0, n > 0 ? static_cast<std::size_t>(n) : 0);
    }
    return std::exchange(rest_, {});
  }
  /// Whether the server closed, found by hear().
  bool ended() const { return ended_; }

  /// A request with this first line, the right Host, and more lines.
  std::string request(std::string_view line, std::string_view more = "") {
    say(fmt::format("{} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n{}\r\n", line, port_, more));
    return receive();
  }
  /// Begins to watch. @return the server's head
  std::string watch(std::string_view more = "", std::string_view path = "/live") {
    say(fmt::format(
        "GET {} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nConnection: keep-alive, Upgrade\r\nUpgrade: websocket\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{}\r\n",
        path, port_, more));
    return receive("\r\n\r\n");
  }
  /// Begins to speak Foxglove's protocol. @return the server's head
  std::string ask_for_topics(std::string_view more = "", std::string_view path = "/") {
    return watch(fmt::format("Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n{}", more), path);
  }
  /// A masked frame, as a browser sends it.
  static std::string masked(unsigned op, std::string_view payload) {
    std::string frame{static_cast<char>(0x80U | op)};
    if (payload.size() < 126) {
      frame += static_cast<char>(0x80U | payload.size());
    } else {
      frame += static_cast<char>(0x80U | 127U);
      for (int shift = 56; shift >= 0; shift -= 8)
        frame += static_cast<char>(payload.size() >> static_cast<unsigned>(shift));
    }
    const std::string_view mask = "\x12\x34\x56\x78";
    frame += mask;
    for (std::size_t i = 0; i < payload.size(); ++i) frame += static_cast<char>(payload[i] ^ mask[i % 4]);
    return frame;
  }

 private:
  bool ready(short what, double seconds) const {
    pollfd polled{fd_, what, 0};
    return ::poll(&polled, 1, static_cast<int>(1000 * seconds)) > 0;
  }

  int fd_;
  std::uint16_t port_;
  std::string rest_;  // that came and was not heard
  bool connected_ = false, ended_ = false;
};

}  // namespace sightline::test
