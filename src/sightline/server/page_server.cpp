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
#include <vector>

#include "sightline/base.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/server/admission.hpp"
#include "sightline/server/connection.hpp"
#include "sightline/server/foxglove.hpp"
#include "sightline/server/foxglove_feed.hpp"
#include "sightline/server/foxglove_session.hpp"

namespace sightline {
namespace {

using Time = Connection::Time;

constexpr int look_around_ms = 250;                 // longest time between checks for late clients
constexpr std::chrono::milliseconds full_for{100};  // delay before the next accept when the process
                                                    // has no free descriptor
constexpr std::chrono::seconds ping_after{5};       // without input of a watcher
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
  // A restarted server can reuse the port of the previous one.
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

std::string upgrade_response(std::string_view key, std::string_view protocol) {
  return fmt::format(
      "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "{}{}{}Sec-WebSocket-Accept: {}\r\n\r\n",
      protocol.empty() ? "" : "Sec-WebSocket-Protocol: ", protocol, protocol.empty() ? "" : "\r\n",
      websocket_accept(key));
}

const std::vector<std::string>& checked_origins(const ServeOptions& options) {
  for (const std::string& origin : options.origins) check_origin(origin);
  return options.origins;
}

}  // namespace

class PageServer::Thread {
 public:
  Thread(const ServeOptions& options, PageFiles files, FoxgloveFeed* topics, OnWatcherMessage receive)
      : topics_(topics),
        listener_(listening_socket(options)),
        wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
        port_(port_of(listener_)),
        token_(is_loopback(options)    ? ""
               : options.token.empty() ? random_token()
                                       : options.token),
        url_(fmt::format("http://{}:{}/{}{}", options.address, port_,
                         token_.empty() ? "" : "?token=", token_)),
        admission_(port_, token_, checked_origins(options)),
        receive_(std::move(receive)) {
    for (auto& file : files) put(file.first, std::move(file.second));
    thread_.start([this] { run(); }, [this] { leave_all(); });
  }
  ~Thread() {
    done_ = true;
    wake();
    thread_.join();
  }

  const std::string& url() const { return url_; }
  std::uint16_t port() const { return port_; }
  const std::string& token() const { return token_; }

  void put(std::string_view path, PageFile file) {
    auto kept = std::make_shared<const PageFile>(std::move(file));
    const std::scoped_lock lock(files_lock_);
    files_.insert_or_assign(std::string(path), std::move(kept));
  }

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
      const bool full = std::chrono::steady_clock::now() < accepts_from_;
      polled.push_back({full ? -1 : listener_.get(), POLLIN, 0});
      polled.push_back({topics_ != nullptr ? topics_->fd() : -1, POLLIN, 0});
      for (const Connection& one : connections_) polled.push_back({one.fd(), one.awaited(), 0});
      (void)::poll(polled.data(), polled.size(), full ? static_cast<int>(full_for.count()) : look_around_ms);
      std::uint64_t ignored = 0;
      (void)!::read(wake_.get(), &ignored, sizeof ignored);
      const Time now = std::chrono::steady_clock::now();
      std::size_t i = 3;
      for (Connection& one : connections_) serve(one, polled[i++].revents, now);
      accept_new(now);
      give_newest(now);
      report_topics(now);
      leave_late(now);
      tidy();
    }
  }

  /// Stops serving after a failure of the thread; the rest of the process continues.
  void leave_all() noexcept {
    sessions_.clear();
    connections_.clear();
    listener_ = OwnedDescriptor();
  }

  void accept_new(Time now) {
    while (now >= accepts_from_) {
      OwnedDescriptor socket(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (socket.get() < 0 && (errno == EINTR || errno == ECONNABORTED)) continue;
      if (socket.get() < 0) {
        // Without a free descriptor the connection stays pending: accepting at once would fail
        // again.
        if (errno != EAGAIN && errno != EWOULDBLOCK) accepts_from_ = now + full_for;
        return;
      }
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
    if (one.state() == Connection::State::requesting) {
      if (one.head_too_long()) {
        refuse(one, 431, "the request is too long", now);
      } else if (!one.head().empty()) {
        answer(one, now);
      }
    }
    const auto speaker = sessions_.find(&one);
    for (const WebsocketReader::Frame& message : one.take_messages())
      if (speaker != sessions_.end())
        speaker->second.receive(message);
      else if (receive_)
        receive(one, message.payload);
      else
        ++now_counts_.unrequested;
    one.send(now);
  }

  /// A handler's failure must not stop the server: it closes the connection of the sender.
  void receive(Connection& one, std::string_view message) {
    try {
      receive_(message);
    } catch (const std::exception&) {
      ++now_counts_.refused;
      one.close();
    }
  }

  void refuse(Connection& one, int status, std::string_view why, Time now) {
    ++now_counts_.refused;
    one.answer(http_response(status, "text/plain; charset=utf-8", fmt::format("sightline: {}\n", why)), now);
  }

  void answer(Connection& one, Time now) {
    const auto request = parse_request(one.head());
    if (!request) return refuse(one, 400, "this is no request", now);
    const std::shared_ptr<const PageFile> file = file_at(request->path);
    const bool open = file != nullptr && file->open;
    const std::string_view protocol = foxglove_protocol(request->header("sec-websocket-protocol"));
    const bool topics = topics_ != nullptr && !protocol.empty() && request->path == "/";
    const auto requested = topics ? Admission::Requested::topics
                           : open ? Admission::Requested::open_file
                                  : Admission::Requested::flight;
    if (const std::string_view why = admission_.refusal(*request, requested); !why.empty())
      return refuse(one, 403, why, now);
    if (request->method != "GET" && request->method != "HEAD")
      return refuse(one, 405, "this page is read-only", now);
    if (request->path == "/live") return upgrade(one, *request, "", now);
    if (topics) return upgrade(one, *request, protocol, now);
    if (file == nullptr) return refuse(one, 404, "there is nothing here", now);
    try {
      one.answer(http_response(200, file->type, file->made ? file->made(*request) : file->body,
                               request->method == "GET"),
                 now);
    } catch (const std::exception& error) {
      refuse(one, 500, fmt::format("this could not be made: {}", sentence_of(error)), now);
    }
  }

  /// Null if the path has no file. The shared pointer allows put() to replace a file in use.
  std::shared_ptr<const PageFile> file_at(std::string_view path) {
    const std::scoped_lock lock(files_lock_);
    const auto file = files_.find(path);
    return file != files_.end() ? file->second : nullptr;
  }

  void upgrade(Connection& one, const HttpRequest& request, std::string_view protocol, Time now) {
    const std::string_view key = request.header("sec-websocket-key");
    if (request.method != "GET" || !request.lists("connection", "upgrade") ||
        !request.lists("upgrade", "websocket") || request.header("sec-websocket-version") != "13" ||
        !is_websocket_key(key))
      return refuse(one, 400, "expected a WebSocket, version 13", now);
    one.watch(upgrade_response(key, protocol), now);
    if (protocol.empty()) return;
    one.allow(FoxgloveSession::message_limit, FoxgloveSession::messages_a_second);
    sessions_.try_emplace(&one, *topics_, one);
  }

  void report_topics(Time now) {
    if (topics_ == nullptr) return;
    const std::vector<FoxgloveFeed::Batch> batches = topics_->take();
    for (auto& [connection, session] : sessions_) {
      session.send(batches);
      connection->send(now);
    }
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
      if (one.state() != Connection::State::watching || one.sends() || one.given() == number ||
          sessions_.contains(&one))
        continue;
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
      if (stuck || (watches && now - one.received() > gone_after)) {
        if (watches) ++now_counts_.closed;
        one.close();
      }
    }
    if (now - pinged_ < ping_after) return;
    pinged_ = now;
    for (Connection& one : connections_)
      if (one.state() == Connection::State::watching && (!one.sends() || sessions_.contains(&one)))
        one.ping(now);
  }

  void tidy() {
    for (const Connection& one : connections_)
      if (one.state() == Connection::State::closed && one.broke_rules()) ++now_counts_.closed;
    now_counts_.messages = left_messages_, now_counts_.messages_dropped = left_dropped_;
    if (topics_ != nullptr) now_counts_.messages_dropped += topics_->dropped();
    for (auto at = sessions_.begin(); at != sessions_.end();) {
      const auto& [connection, session] = *at;
      now_counts_.messages += session.sent(), now_counts_.messages_dropped += session.dropped();
      if (connection->state() != Connection::State::closed) {
        ++at;
        continue;
      }
      left_messages_ += session.sent(), left_dropped_ += session.dropped();
      at = sessions_.erase(at);
    }
    connections_.remove_if([](const Connection& one) { return one.state() == Connection::State::closed; });
    now_counts_.watchers = std::count_if(connections_.begin(), connections_.end(), [](const Connection& one) {
      return one.state() == Connection::State::watching;
    });
    const std::scoped_lock lock(counts_lock_);
    counts_ = now_counts_;
  }

  FoxgloveFeed* topics_;
  OwnedDescriptor listener_, wake_;
  std::uint16_t port_;
  std::string token_, url_;
  Admission admission_;
  std::mutex files_lock_;
  std::map<std::string, std::shared_ptr<const PageFile>, std::less<>> files_;
  OnWatcherMessage receive_;

  std::list<Connection> connections_;                  // of the thread, like the members below
  std::map<Connection*, FoxgloveSession> sessions_;    // of clients with Foxglove's protocol
  std::int64_t left_messages_ = 0, left_dropped_ = 0;  // of closed sessions
  ServeCounts now_counts_;
  Time pinged_{}, accepts_from_{};

  mutable std::mutex counts_lock_;
  ServeCounts counts_;
  std::mutex newest_lock_;
  Connection::Bytes newest_;
  std::int64_t newest_number_ = 0;
  std::atomic<bool> done_{false};
  ServiceThread thread_{"the page's server"};  // last: it uses all other members
};

PageServer::PageServer(const ServeOptions& options, PageFiles files, FoxgloveFeed* topics,
                       OnWatcherMessage receive)
    : thread_(std::make_unique<Thread>(options, std::move(files), topics, std::move(receive))) {}
PageServer::~PageServer() = default;

const std::string& PageServer::url() const { return thread_->url(); }
std::uint16_t PageServer::port() const { return thread_->port(); }
const std::string& PageServer::token() const { return thread_->token(); }
void PageServer::put(std::string_view path, PageFile file) { thread_->put(path, std::move(file)); }
void PageServer::post(std::string_view state) { thread_->post(state); }
ServeCounts PageServer::counts() const { return thread_->counts(); }

}  // namespace sightline
