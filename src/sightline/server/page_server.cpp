#include "sightline/server/page_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <list>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "sightline/server/admission.hpp"
#include "sightline/server/connection.hpp"

namespace sightline {
namespace {

using Time = Connection::Time;

constexpr int look_around_ms = 250;            // longest time without a look at who is too late
constexpr std::chrono::seconds ping_after{5};  // nothing heard of a watcher
constexpr std::chrono::seconds gone_after{20};
constexpr auto too_late = std::chrono::duration<double>(PageServer::patience);

sockaddr_in address_of(const ServeOptions& options) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(options.port);
  if (::inet_pton(AF_INET, options.address.c_str(), &address.sin_addr) != 1)
    throw std::invalid_argument(
        fmt::format("address = {}, expected an IPv4 address of this machine", options.address));
  return address;
}

OwnedDescriptor listening_socket(const ServeOptions& options) {
  const sockaddr_in address = address_of(options);
  OwnedDescriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int on = 1;
  // A server that is started again takes the port of the one before.
  (void)::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(socket.get(), 32) != 0)
    throw std::invalid_argument(
        fmt::format("{}:{} cannot be listened to: {}", options.address, options.port, std::strerror(errno)));
  return socket;
}

std::uint16_t port_of(const OwnedDescriptor& socket) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

bool is_loopback(const ServeOptions& options) { return options.address == "127.0.0.1"; }

std::string upgrade_response(std::string_view key) {
  return fmt::format(
      "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Accept: {}\r\n\r\n",
      websocket_accept(key));
}

}  // namespace

class PageServer::Thread {
 public:
  Thread(const ServeOptions& options, PageFiles files)
      : listener_(listening_socket(options)),
        wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
        port_(port_of(listener_)),
        token_(is_loopback(options) ? "" : random_token()),
        url_(fmt::format("http://{}:{}/{}{}", options.address, port_,
                         token_.empty() ? "" : "?token=", token_)),
        admission_(port_, token_),
        files_(std::move(files)),
        thread_([this] { run(); }) {}
  ~Thread() {
    done_ = true;
    wake();
    thread_.join();
  }

  const std::string& url() const { return url_; }
  std::uint16_t port() const { return port_; }

  void post(std::string_view state) {
    auto frame = std::make_shared<const std::string>(websocket_frame(WebsocketOp::text, state));
    {
      const std::scoped_lock lock(newest_lock_);
      newest_ = std::move(frame);
      ++newest_number_;
    }
    wake();
  }

  ServeCounts counts() const {
    const std::scoped_lock lock(counts_lock_);
    return counts_;
  }

 private:
  void wake() const {
    const std::uint64_t one = 1;
    (void)!::write(wake_.get(), &one, sizeof one);
  }

  void run() {
    std::vector<pollfd> polled;
    while (!done_) {
      polled.clear();
      polled.push_back({wake_.get(), POLLIN, 0});
      polled.push_back({listener_.get(), POLLIN, 0});
      for (const Connection& one : connections_) polled.push_back({one.fd(), one.awaited(), 0});
      (void)::poll(polled.data(), polled.size(), look_around_ms);
      std::uint64_t ignored = 0;
      (void)!::read(wake_.get(), &ignored, sizeof ignored);
      const Time now = std::chrono::steady_clock::now();
      std::size_t i = 2;
      for (Connection& one : connections_) serve(one, polled[i++].revents, now);
      accept_new(now);
      give_newest(now);
      leave_late(now);
      tidy();
    }
  }

  void accept_new(Time now) {
    for (;;) {
      OwnedDescriptor socket(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (socket.get() < 0) return;
      ++now_counts_.connections;
      if (connections_.size() >= connections_max) {
        ++now_counts_.refused;
        continue;
      }
      connections_.emplace_back(std::move(socket), now, message_limit, messages_a_second);
    }
  }

  void serve(Connection& one, short events, Time now) {
    if ((events & (POLLIN | POLLHUP | POLLERR)) != 0) one.receive(now);
    if (one.state() == Connection::State::asking) {
      if (one.head_too_long()) {
        refuse(one, 431, "the request is too long", now);
      } else if (!one.head().empty()) {
        answer(one, now);
      }
    }
    one.send(now);
  }

  void refuse(Connection& one, int status, std::string_view why, Time now) {
    ++now_counts_.refused;
    one.answer(http_response(status, "text/plain; charset=utf-8", fmt::format("sightline: {}\n", why)), now);
  }

  void answer(Connection& one, Time now) {
    const auto request = parse_request(one.head());
    if (!request) return refuse(one, 400, "this is no request", now);
    const auto file = files_.find(request->path);
    const bool open = file != files_.end() && file->second.open;
    if (const std::string_view why = admission_.refusal(*request, open); !why.empty())
      return refuse(one, 403, why, now);
    if (request->method != "GET" && request->method != "HEAD")
      return refuse(one, 405, "this page is read-only", now);
    if (request->path == "/live") return upgrade(one, *request, now);
    if (file == files_.end()) return refuse(one, 404, "there is nothing here", now);
    one.answer(http_response(200, file->second.type, file->second.body, request->method == "GET"), now);
  }

  void upgrade(Connection& one, const HttpRequest& request, Time now) {
    const std::string_view key = request.header("sec-websocket-key");
    if (request.method != "GET" || !request.lists("connection", "upgrade") ||
        !request.lists("upgrade", "websocket") || request.header("sec-websocket-version") != "13" ||
        !is_websocket_key(key))
      return refuse(one, 400, "expected a WebSocket, version 13", now);
    one.watch(upgrade_response(key), now);
  }

  void give_newest(Time now) {
    Connection::Bytes newest;
    std::int64_t number = 0;
    {
      const std::scoped_lock lock(newest_lock_);
      newest = newest_;
      number = newest_number_;
    }
    for (Connection& one : connections_) {
      if (one.state() != Connection::State::watching || one.sends() || one.given() == number) continue;
      if (one.given() > 0) now_counts_.dropped += number - one.given() - 1;
      ++now_counts_.sent;
      one.give(newest, number, now);
      one.send(now);
    }
  }

  void leave_late(Time now) {
    for (Connection& one : connections_) {
      const bool watches = one.state() == Connection::State::watching;
      const bool stuck = (one.sends() || !watches) && now - one.moved() > too_late;
      if (stuck || (watches && now - one.heard() > gone_after)) {
        if (watches) ++now_counts_.closed;
        one.close();
      }
    }
    if (now - pinged_ < ping_after) return;
    pinged_ = now;
    for (Connection& one : connections_)
      if (one.state() == Connection::State::watching && !one.sends()) one.ping(now);
  }

  void tidy() {
    for (const Connection& one : connections_)
      if (one.state() == Connection::State::closed && one.broke_rules()) ++now_counts_.closed;
    connections_.remove_if([](const Connection& one) { return one.state() == Connection::State::closed; });
    now_counts_.watchers = std::count_if(connections_.begin(), connections_.end(), [](const Connection& one) {
      return one.state() == Connection::State::watching;
    });
    const std::scoped_lock lock(counts_lock_);
    counts_ = now_counts_;
  }

  OwnedDescriptor listener_, wake_;
  std::uint16_t port_;
  std::string token_, url_;
  Admission admission_;
  PageFiles files_;

  std::list<Connection> connections_;  // of the thread, as what follows
  ServeCounts now_counts_;
  Time pinged_{};

  mutable std::mutex counts_lock_;
  ServeCounts counts_;
  std::mutex newest_lock_;
  Connection::Bytes newest_;
  std::int64_t newest_number_ = 0;
  std::atomic<bool> done_{false};
  std::thread thread_;  // last: it uses all of it
};

PageServer::PageServer(const ServeOptions& options, PageFiles files)
    : thread_(std::make_unique<Thread>(options, std::move(files))) {}
PageServer::~PageServer() = default;

const std::string& PageServer::url() const { return thread_->url(); }
std::uint16_t PageServer::port() const { return thread_->port(); }
void PageServer::post(std::string_view state) { thread_->post(state); }
ServeCounts PageServer::counts() const { return thread_->counts(); }

}  // namespace sightline
