/// One client of a page: a socket that is never waited for, and what is on its way in and out.
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

/// A file descriptor that is closed at the end.
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
    requesting,  ///< its request is not whole
    answering,   ///< closed once the answer is out
    watching,    ///< a WebSocket
    closed
  };

  /// @param message_limit  longest message of a watcher [B]
  /// @param messages_a_second  of a watcher, at most; and of bytes 20 of its longest messages
  Connection(OwnedDescriptor socket, Time now, std::size_t message_limit, int messages_a_second);

  State state() const { return state_; }
  int fd() const { return socket_.get(); }
  bool sends() const { return out_ != nullptr; }
  /// Of poll(2): one that is answered may say no more.
  short awaited() const {
    return static_cast<short>((state_ == State::answering ? 0 : POLLIN) | (sends() ? POLLOUT : 0));
  }
  /// When bytes last moved, or since it takes none.
  Time moved() const { return moved_; }
  Time received() const { return received_; }

  /// Takes in what there is, once; an end of the stream closes it.
  void receive(Time now);
  /// The head of the request once it is whole; empty before.
  std::string_view head() const;
  bool head_too_long() const;

  /// Sends what follows, and closes.
  void answer(std::string bytes, Time now);
  /// Sends what follows, and is a watcher from now on.
  void watch(std::string bytes, Time now);
  /// Other limits than from the start.
  void allow(std::size_t message_limit, int messages_a_second);
  /// Messages of a watcher that came with the last bytes, whole; once.
  std::vector<WebsocketReader::Frame> take_messages() { return std::exchange(whole_, {}); }
  /// More to a watcher, behind what it has not taken yet.
  void add(std::string_view frames) { behind_ += frames; }
  /// That it has not taken yet [B].
  std::size_t waiting() const { return behind_.size() + (sends() ? out_->size() - sent_ : 0); }
  /// A state to a watcher that has taken the one before.
  void give(Bytes state, std::int64_t number, Time now);
  /// Number of the last state that was given.
  std::int64_t given() const { return given_; }
  /// Asks a watcher whether it is there.
  void ping(Time now);
  /// Sends as much as is taken.
  void send(Time now);
  void close() { state_ = State::closed; }
  /// Whether a watcher was closed for what it sent.
  bool broke_rules() const { return broke_rules_; }

 private:
  void read_frames(Time now);
  std::optional<WebsocketClose> take_frame(WebsocketReader::Frame frame);

  OwnedDescriptor socket_;
  State state_ = State::requesting;
  std::string in_;  // of a request
  WebsocketReader frames_;
  std::optional<WebsocketReader::Frame> begun_{};  // a message in parts
  std::vector<WebsocketReader::Frame> whole_{};
  std::size_t message_limit_, bytes_ = 0;
  int messages_a_second_, messages_ = 0;
  Time second_, moved_, received_;
  Bytes out_;
  std::string behind_;  // that waits for out_
  std::size_t sent_ = 0;
  std::int64_t given_ = 0;
  bool broke_rules_ = false;
};

}  // namespace sightline
