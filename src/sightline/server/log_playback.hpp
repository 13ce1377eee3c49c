/// The topics of a log and those of SceneTopics, played to Foxglove's clients of its page.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/service_thread.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/server/foxglove_feed.hpp"
#include "sightline/server/scene_topics.hpp"

namespace sightline {

/// Plays a log as fast as it was flown, by a thread of its own: from the begin once somebody subscribes, again and again while somebody
/// does.
class LogPlayback {
 public:
  static constexpr double rest = 1.0;  ///< at the end, before it begins again [s]

  /// @param scenario  that was flown
  /// @throws std::runtime_error with a sentence that names the file where it cannot be read
  LogPlayback(std::filesystem::path log, const Scenario& scenario);
  ~LogPlayback();
  LogPlayback(const LogPlayback&) = delete;
  LogPlayback& operator=(const LogPlayback&) = delete;

  FoxgloveFeed& feed() { return feed_; }

 private:
  void run();
  void play();
  /// Sleeps. @return whether it goes on
  bool wait(double seconds) const;

  std::filesystem::path log_;
  FoxgloveFeed feed_;
  std::map<std::string, ChannelId, std::less<>> channels_;
  std::vector<std::string> names_;  // of the bodies
  SceneTopics drawn_;
  std::atomic<bool> done_{false};
  ServiceThread thread_{"the playback of the log"};  // last: it uses all of it
};

}  // namespace sightline
