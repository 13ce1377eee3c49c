/// Plays the topics of a log, and those of SceneTopics, to the Foxglove clients of its page.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/scenario.hpp"
#include "sightline/server/foxglove_feed.hpp"
#include "sightline/server/scene_topics.hpp"

namespace sightline {

/// Plays a log in real time, in a thread of its own: from the beginning at the first subscription,
/// and repeatedly while a topic has a subscriber.
class LogPlayback {
 public:
  static constexpr double rest = 1.0;  ///< pause at the end before it repeats [s]

  /// @param scenario  of the flight
  /// @throws std::runtime_error with the name of the file, if it cannot be read
  LogPlayback(std::filesystem::path log, const Scenario& scenario);
  ~LogPlayback();
  LogPlayback(const LogPlayback&) = delete;
  LogPlayback& operator=(const LogPlayback&) = delete;

  FoxgloveFeed& feed() { return feed_; }

 private:
  void run();
  void play();
  /// Sleeps. @return whether the playback continues
  bool wait(double seconds) const;

  std::filesystem::path log_;
  FoxgloveFeed feed_;
  std::map<std::string, ChannelId, std::less<>> channels_;
  std::vector<std::string> names_;  // of the bodies
  SceneTopics drawn_;
  std::atomic<bool> done_{false};
  ServiceThread thread_{"the playback of the log"};  // last: it uses all other members
};

}  // namespace sightline
