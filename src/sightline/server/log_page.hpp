/// A logged flight, from its folder, finished or still written.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/scenario/scenario.hpp"
#include "sightline/server/page_server.hpp"

namespace sightline {

/// What becomes of a log that is looked at.
enum class LogState {
  growing,   ///< it has no end yet, and some process writes it
  finished,  ///< it has its end
  broken,    ///< it has no end, and it has no publisher: the run was killed
};
std::string_view to_string(LogState state);

/// Makes the moments of a log, and those that come to it later.
///
/// Of each period one, or of a long flight or a large team fewer, evenly, so that no more than `numbers` are said of bodies; of a flight
/// that goes on, as if it came to its scenario's end. Predictions and events are at the first moment that is not before them.
class LogMoments {
 public:
  /// @param scenario  that was flown
  /// @throws std::runtime_error with a sentence that names the file where it cannot be read, or is of another team
  LogMoments(const std::filesystem::path& folder, const Scenario& scenario, std::size_t numbers = 1'000'000);
  ~LogMoments();
  LogMoments(const LogMoments&) = delete;
  LogMoments& operator=(const LogMoments&) = delete;

  /// The moments that came since, in JSON (SceneJson).
  /// @throws as the constructor
  std::vector<std::string> read_on();
  /// As it was found by read_on().
  LogState state() const;
  /// Whether the folder has another log now, since a run began anew.
  bool replaced() const;

 private:
  class Player;
  std::unique_ptr<Player> player_;
};

/// Serves the page of a log: /scene.json, /moments.json (all that are there; `?from=N&most=M`: those from the N-th on), and at /live
/// {session, moments, state, fault} whenever one of them changes: their count, the LogState, and a sentence while the log cannot be read.
/// A thread of its own looks at the log ten times a second; a run that begins anew in the folder is a new session.
class LogPage {
 public:
  /// @param flown   reads from the log the scenario that was flown
  /// @param topics  where there are some: outlives this
  /// @throws as LogMoments, PageServer and `flown`
  LogPage(const std::filesystem::path& folder, std::function<Scenario()> flown,
          const ServeOptions& options = {}, FoxgloveFeed* topics = nullptr);
  ~LogPage();
  LogPage(const LogPage&) = delete;
  LogPage& operator=(const LogPage&) = delete;

  const std::string& url() const;
  std::uint16_t port() const;
  ServeCounts counts() const;

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sightline
