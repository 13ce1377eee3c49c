/// Publishes a flight as topics: poses, planned paths, markers, /tf, diagnostics and log lines, for
/// rviz, Foxglove and rosbag2.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "bridges/dds/links/link_end.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"

namespace sightline::dds {

/// The flyer's knowledge of one robot.
struct RobotShown {
  bool seen = false;
  SeenMotion last{};  ///< newest measured motion
  LinkState state = LinkState::waiting;
  LinkReason reason = LinkReason::as_requested;
  LinkFacts facts{};
};

/// Topic name part for a robot: - becomes _, and a name that is empty or begins with a digit gets
/// the prefix _.
std::string topic_part(std::string_view robot);

/// Qualities of service of the topics; they match reliable and best-effort readers.
inline constexpr Quality of_shown = {true, false, 1}, of_transforms = {true, false, 100},
                         of_log_lines = {true, true, 1000};

/// Publishes on its own thread at bounded rates: poses and /tf at most every 20 ms, paths and
/// markers every 0.1 s, diagnostics every second, at most 50 log lines per second.
class FlightPublisher {
 public:
  /// Returns the message counts of a robot's link as text; called on the publishing thread.
  using Counts = std::function<std::string(std::size_t robot)>;
  /// @throws std::invalid_argument if two robots have equal topic names, std::runtime_error if a
  ///   topic cannot be created
  FlightPublisher(const Scenario& scenario, dds_entity_t participant, Counts counts);
  ~FlightPublisher();  ///< Waits until the last message is published.
  FlightPublisher(const FlightPublisher&) = delete;
  FlightPublisher& operator=(const FlightPublisher&) = delete;

  // Control thread only: no allocation, no waiting. If the queue is full, a Sample is dropped.
  void show(std::size_t robot, const RobotShown& shown) noexcept;
  void show(const Sample& sample) noexcept;

  /// Adds a log line; any thread, before and after the task.
  void add_sentence(std::string_view sentence);
  /// Message counts and the average load [cores], as text.
  std::string counts() const;

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sightline::dds
