/// Page of a logged flight, from its folder; the log may be complete or still growing.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/scenario.hpp"
#include "sightline/server/page_server.hpp"

namespace sightline {

/// State of a log.
enum class LogState {
  growing,   ///< it has no end record, and a process is writing it
  finished,  ///< it has an end record
  broken,    ///< it has no end record and no writer: the run was killed
};
std::string_view to_string(LogState state);

/// Converts a log into moments, also as it grows.
///
/// There is one moment for each period; for a long flight or a large team fewer, evenly spaced,
/// with about `numbers` numbers of bodies in total. A growing log counts as if it reached its
/// scenario's duration. Predictions and events belong to the first moment that is not before them.
class LogMoments {
 public:
  /// @param scenario  of the flight
  /// @throws std::runtime_error with the name of the file, if it cannot be read or is of another
  ///   team
  LogMoments(const std::filesystem::path& folder, const Scenario& scenario, std::size_t numbers = 1'000'000);
  ~LogMoments();
  LogMoments(const LogMoments&) = delete;
  LogMoments& operator=(const LogMoments&) = delete;

  /// New moments since the last call, as JSON (SceneJson).
  /// @throws as the constructor
  std::vector<std::string> read_on();
  /// State of the log at the last read_on().
  LogState state() const;
  /// Whether the folder has another log now, because a run began anew.
  bool replaced() const;

 private:
  class Player;
  std::unique_ptr<Player> player_;
};

/// Serves the page of a log: /scene.json and /moments.json (all moments; `?from=N&most=M`: at most
/// M from number N on). /live sends {session, moments, state, fault} at each change: the count of
/// moments, the LogState, and a sentence while the log cannot be read. A thread reads the log ten
/// times a second; a new run in the folder is a new session.
class LogPage {
 public:
  /// @param flown  reads the scenario of the flight from the log
  /// @param topics  if not null, must outlive this object
  /// @throws as LogMoments, PageServer and `flown`
  LogPage(const std::filesystem::path& folder, std::function<Scenario()> flown,
          const ServeOptions& options = {}, FoxgloveFeed* topics = nullptr);
  ~LogPage();
  LogPage(const LogPage&) = delete;
  LogPage& operator=(const LogPage&) = delete;

  /// Adds or replaces the file of a path. For any thread.
  void put(std::string_view path, PageFile file);

  const std::string& url() const;
  std::uint16_t port() const;
  ServeCounts counts() const;

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sightline
