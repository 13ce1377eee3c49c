/// HTTP and WebSocket server of a page; sends the newest state to all watchers.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

class FoxgloveFeed;
struct HttpRequest;

/// Content of a path.
struct PageFile {
  std::string type;  ///< "text/html; charset=utf-8"
  std::string body;
  bool open = false;  ///< contains nothing of a flight and needs no token
  /// Produces the body for each request, in the server's thread; none: `body` is used.
  std::function<std::string(const HttpRequest&)> made{};
};
using PageFiles = std::map<std::string, PageFile, std::less<>>;

struct ServeOptions {
  /// IPv4 address of the interface; any other than 127.0.0.1 requires a token.
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0: a free port
  /// Origins of other pages that may subscribe to topics, "https://app.foxglove.dev"; empty: only
  /// this page and clients without an Origin.
  std::vector<std::string> origins{};
  std::string token{};  ///< used if the address requires one; empty: a new one
};

/// Counts of clients and messages.
struct ServeCounts {
  std::int64_t connections = 0, refused = 0;  ///< refused: for an invalid request, or at the limit
                                              ///< of connections
  std::int64_t watchers = 0;                  ///< connected now
  std::int64_t sent = 0,
               dropped = 0;  ///< states; dropped: replaced by a newer one before a watcher accepted them
  std::int64_t closed = 0;   ///< watchers that exceeded a limit, or did not respond in time
  std::int64_t messages = 0, messages_dropped = 0;  ///< of topics, one for each subscriber
  std::int64_t unrequested = 0;                     ///< messages of watchers to a server without a handler
};

/// Handles a message of a watcher. Runs in the server's thread and must return quickly.
using OnWatcherMessage = std::function<void(std::string_view)>;

/// An HTTP and WebSocket server with one thread and non-blocking sockets, so that no client delays
/// another. Without a handler, client messages are rate-checked, counted and discarded.
///
///   /            a PageFile
///   /live        a WebSocket: the newest state at once, then each posted state, as a text message
///   /            a WebSocket with Foxglove's protocol: topics
///
/// Bounds: `connections_max` at a time, heads of 8 KiB, `message_limit` and `messages_a_second` of
/// a watcher. A client that does not complete its request, or accepts no output, is closed after
/// `patience`.
class PageServer {
 public:
  static constexpr std::size_t connections_max = 48;
  static constexpr std::size_t message_limit = 1024;  // [B]
  static constexpr int messages_a_second = 20;
  static constexpr double patience = 5.0;  // [s]

  /// Binds and listens at once.
  /// @param topics  for Foxglove; must outlive this object; null: no topics
  /// @param receive  handles the messages of watchers; none: the server is read-only
  /// @throws std::invalid_argument for an address that is not of this machine, a port in use, or an
  ///   invalid origin; names it
  PageServer(const ServeOptions& options, PageFiles files, FoxgloveFeed* topics = nullptr,
             OnWatcherMessage receive = {});
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /// Address for a browser, with the token if there is one.
  const std::string& url() const;
  std::uint16_t port() const;
  /// The required token; empty: none is required.
  const std::string& token() const;

  /// Adds or replaces the file of a path. For any thread.
  void put(std::string_view path, PageFile file);
  /// Publishes the newest state. For any thread; does not wait for clients.
  void post(std::string_view state);

  ServeCounts counts() const;

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sightline
