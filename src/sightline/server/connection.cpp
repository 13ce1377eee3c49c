#include "sightline/server/connection.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "sightline/server/http.hpp"

namespace sightline {

OwnedDescriptor::~OwnedDescriptor() {
  if (fd_ >= 0) ::close(fd_);
}

OwnedDescriptor& OwnedDescriptor::operator=(OwnedDescriptor&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

Connection::Connection(OwnedDescriptor socket, Time now, std::size_t message_limit, int messages_a_second)
    : socket_(std::move(socket)),
      frames_(message_limit),
      message_limit_(message_limit),
      messages_a_second_(messages_a_second),
      second_(now),
      moved_(now),
      received_(now) {}

void Connection::receive(Time now) {
  std::array<char, 4096> bytes;
  whole_.clear();
  const ssize_t n = ::recv(fd(), bytes.data(), bytes.size(), 0);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (n <= 0) return close();
  received_ = now;
  const std::string_view taken(bytes.data(), static_cast<std::size_t>(n));
  if (state_ == State::requesting && in_.size() <= request_limit) in_ += taken;
  if (state_ != State::watching) return;  // after a request no more bytes are expected
  frames_.take(taken);
  bytes_ += taken.size();
  read_frames(now);
}

std::string_view Connection::head() const {
  const std::size_t end = in_.find("\r\n\r\n");
  if (end == std::string::npos || end > request_limit) return {};
  return std::string_view(in_).substr(0, end);
}

bool Connection::head_too_long() const { return head().empty() && in_.size() > request_limit; }

void Connection::answer(std::string bytes, Time now) {
  state_ = State::answering;
  out_ = std::make_shared<const std::string>(std::move(bytes));
  sent_ = 0;
  moved_ = now;
}

void Connection::watch(std::string bytes, Time now) {
  answer(std::move(bytes), now);
  state_ = State::watching;
  in_.clear();
}

void Connection::allow(std::size_t message_limit, int messages_a_second) {
  frames_.set_limit(message_limit);
  message_limit_ = message_limit;
  messages_a_second_ = messages_a_second;
}

void Connection::give(Bytes state, std::int64_t number, Time now) {
  out_ = std::move(state);
  given_ = number;
  sent_ = 0;
  moved_ = now;
}

void Connection::ping(Time now) {
  behind_ += websocket_frame(WebsocketOp::ping, "");
  send(now);
}

void Connection::send(Time now) {
  while (state_ != State::closed) {
    if (out_ == nullptr) {
      if (behind_.empty()) return;
      out_ = std::make_shared<const std::string>(std::exchange(behind_, {}));
      sent_ = 0;
      moved_ = now;
    }
    const ssize_t n = ::send(fd(), out_->data() + sent_, out_->size() - sent_, MSG_NOSIGNAL);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (n < 0) return close();
    moved_ = now;
    sent_ += static_cast<std::size_t>(n);
    if (sent_ < out_->size()) continue;
    out_.reset();
    if (state_ != State::watching) {
      ::shutdown(fd(), SHUT_WR);  // the answer arrives before the end of the stream
      return close();
    }
  }
}

void Connection::read_frames(Time now) {
  if (now - second_ >= std::chrono::seconds(1)) second_ = now, messages_ = 0, bytes_ = 0;
  const auto end = [&](const std::string& last_frame) {
    // Sent only if the watcher has accepted all output.
    if (out_ == nullptr) (void)::send(fd(), last_frame.data(), last_frame.size(), MSG_NOSIGNAL);
    close();
  };
  const auto refuse = [&](WebsocketClose why) {
    broke_rules_ = true;
    end(websocket_close(why));
  };
  if (bytes_ > 20 * message_limit_) return refuse(WebsocketClose::against_the_rules);
  while (auto frame = frames_.next()) {
    if (++messages_ > messages_a_second_) return refuse(WebsocketClose::against_the_rules);
    if (frame->op == WebsocketOp::close)  // answered with its own code, RFC 6455, 5.5.1
      return end(websocket_frame(WebsocketOp::close, std::string_view(frame->payload).substr(0, 2)));
    if (const auto fault = take_frame(*std::move(frame))) return refuse(*fault);
  }
  if (const auto fault = frames_.fault()) refuse(*fault);
}

/// Assembles a message of its frames. @return the reason of a fault
std::optional<WebsocketClose> Connection::take_frame(WebsocketReader::Frame frame) {
  if (frame.op == WebsocketOp::ping) add(websocket_frame(WebsocketOp::pong, frame.payload));
  if (frame.op == WebsocketOp::ping || frame.op == WebsocketOp::pong) return std::nullopt;
  if ((frame.op == WebsocketOp::continuation) != begun_.has_value()) return WebsocketClose::not_the_protocol;
  if (begun_) {
    if (begun_->payload.size() + frame.payload.size() > message_limit_) return WebsocketClose::too_long;
    begun_->payload += frame.payload;
    begun_->last = frame.last;
  } else {
    begun_ = std::move(frame);
  }
  if (!begun_->last) return std::nullopt;
  whole_.push_back(*std::exchange(begun_, std::nullopt));
  return std::nullopt;
}

}  // namespace sightline
