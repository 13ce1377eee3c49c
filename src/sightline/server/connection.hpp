/// Connection to one client of a page: a non-blocking socket with its input and output buffers.
#pragma once

#include <poll.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/server/websocket.hpp"

namespace sightline {

/// A file descriptor that closes on destruction.
class OwnedDescriptor {
 public:
  explicit OwnedDescriptor(int fd = -1) : fd_(fd) {}
  ~OwnedDescriptor();
  OwnedDescriptor(OwnedDescriptor&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  OwnedDescriptor& operator=(OwnedDescriptor&& other) noexcept;

  int get() const { return fd_; }

 private:
  int fd_;
};

class Connection {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Bytes = std::shared_ptr<const std::string>;

  enum class State {
    requesting,  ///< its request is incomplete
    answering,   ///< closed after the answer is sent
    watching,    ///< a WebSocket
    closed
  };

  /// @param message_limit  longest message of a watcher [B]
  /// @param messages_a_second  most messages of a watcher per second; the limit of bytes per
  ///   second is 20 * message_limit
  Connection(OwnedDescriptor socket, Time now, std::size_t message_limit, int messages_a_second);

  State state() const { return state_; }
  int fd() const { return socket_.get(); }
  bool sends() const { return out_ != nullptr; }
  /// Events for poll(2). After its request, an answered client may send no more.
  short awaited() const {
    return static_cast<short>((state_ == State::answering ? 0 : POLLIN) | (sends() ? POLLOUT : 0));
  }
  /// Time of the last output, or of the state that has been waiting since.
  Time moved() const { return moved_; }
  Time received() const { return received_; }

  /// Reads once from the socket; the end of the stream closes the connection.
  void receive(Time now);
  /// Head of the request once it is complete; empty before.
  std::string_view head() const;
  bool head_too_long() const;

  /// Sends the bytes, then closes.
  void answer(std::string bytes, Time now);
  /// Sends the bytes and becomes a watcher.
  void watch(std::string bytes, Time now);
  /// Replaces the limits of the constructor.
  void allow(std::size_t message_limit, int messages_a_second);
  /// Complete messages of a watcher from the last receive(); each is returned once.
  std::vector<WebsocketReader::Frame> take_messages() { return std::exchange(whole_, {}); }
  /// Appends frames for a watcher to the output that is not sent yet.
  void add(std::string_view frames) { behind_ += frames; }
  /// Output that is not sent yet [B].
  std::size_t waiting() const { return behind_.size() + (sends() ? out_->size() - sent_ : 0); }
  /// Starts to send a state to a watcher; requires that sends() is false.
  void give(Bytes state, std::int64_t number, Time now);
  /// Number of the last state of give().
  std::int64_t given() const { return given_; }
  /// Sends a ping to a watcher.
  void ping(Time now);
  /// Sends as much as the socket accepts.
  void send(Time now);
  void close() { state_ = State::closed; }
  /// Whether a watcher was closed because it violated the protocol or its limits.
  bool broke_rules() const { return broke_rules_; }

 private:
  void read_frames(Time now);
  std::optional<WebsocketClose> take_frame(WebsocketReader::Frame frame);

  OwnedDescriptor socket_;
  State state_ = State::requesting;
  std::string in_;  // of a request
  WebsocketReader frames_;
  std::optional<WebsocketReader::Frame> begun_{};  // a message in fragments
  std::vector<WebsocketReader::Frame> whole_{};
  std::size_t message_limit_, bytes_ = 0;
  int messages_a_second_, messages_ = 0;
  Time second_, moved_, received_;
  Bytes out_;
  std::string behind_;  // appended output, sent after out_
  std::size_t sent_ = 0;
  std::int64_t given_ = 0;
  bool broke_rules_ = false;
};

}  // namespace sightline
