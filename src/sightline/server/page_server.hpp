/// Serves a page, and the newest state of something to all who look on.
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

/// What stands at a path.
struct PageFile {
  std::string type;  ///< "text/html; charset=utf-8"
  std::string body;
  bool open = false;  ///< holds nothing of a flight, so that no token is asked for
  /// Makes the body anew for each request, in the server's thread; none: it is `body`.
  std::function<std::string(const HttpRequest&)> made{};
};
using PageFiles = std::map<std::string, PageFile, std::less<>>;

struct ServeOptions {
  /// IPv4 address of the interface; another than 127.0.0.1 asks for a token.
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0: a free one
  /// Other pages that may subscribe to topics, "https://app.foxglove.dev"; none: this one, and what is no page.
  std::vector<std::string> origins{};
  std::string token{};  ///< asked for where the address asks for one; empty: a new one
};

/// What became of those who came.
struct ServeCounts {
  std::int64_t connections = 0, refused = 0;  ///< refused: for what they said, or for want of room
  std::int64_t watchers = 0;                  ///< that look on now
  std::int64_t sent = 0,
               dropped = 0;  ///< states; dropped: a newer one was there before a watcher took the last
  std::int64_t closed = 0;   ///< watchers that sent too much, or took nothing for `patience`
  std::int64_t messages = 0, messages_dropped = 0;  ///< of topics, to each that has subscribed
  std::int64_t unrequested = 0;  ///< messages that nobody hears: what is served is read-only
};

/// Takes in what a watcher says; of the server's thread, which it does not keep.
using OnWatcherMessage = std::function<void(std::string_view)>;

/// An HTTP and WebSocket server with one thread, which waits for no client: no socket blocks. Read-only where nobody hears: then what a
/// client sends is looked at for its length and rate alone, and counted.
///
///   /            a PageFile
///   /live        a WebSocket: the newest state at once, then each that is posted, as a text message
///   /            a WebSocket that speaks Foxglove's protocol: topics
///
/// Bounds: `connections_max` at a time, heads of 8 KiB, `message_limit` and `messages_a_second` from a watcher. A client that
/// does not say its request, or takes nothing, is closed after `patience`.
class PageServer {
 public:
  static constexpr std::size_t connections_max = 48;
  static constexpr std::size_t message_limit = 1024;  // [B]
  static constexpr int messages_a_second = 20;
  static constexpr double patience = 5.0;  // [s]

  /// Listens at once.
  /// @param topics  for Foxglove; outlives this; none: there are none
  /// @param hear    the messages of watchers; none: it is read-only
  /// @throws std::invalid_argument for an address that is none of this machine, a port that is taken, or an origin that is none, named
  PageServer(const ServeOptions& options, PageFiles files, FoxgloveFeed* topics = nullptr,
             OnWatcherMessage receive = {});
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /// What to open in a browser, with the token where there is one.
  const std::string& url() const;
  std::uint16_t port() const;
  /// What is asked for beside an address; empty where nothing is.
  const std::string& token() const;

  /// Puts a file in place of what stands there. Of any thread.
  void put(std::string_view path, PageFile file);
  /// Hands over the newest state. Of any thread; waits for no client.
  void post(std::string_view state);

  ServeCounts counts() const;

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sightline
