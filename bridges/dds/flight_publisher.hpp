/// What others see of a flight: poses, planned paths, markers, /tf, diagnostics and log lines, as rviz, Foxglove and rosbag2 read them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/link_end.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline::dds {

/// What its flyer knows of a robot.
struct RobotShown {
  bool seen = false;
  SeenMotion last{};  ///< where it was seen
  LinkState state = LinkState::waiting;
  LinkReason reason = LinkReason::as_requested;
  LinkFacts facts{};
};

/// The part of a topic's name that stands for a robot: what ROS 2 does not allow in its name becomes _.
std::string topic_part(std::string_view robot);

/// What its topics are published by. Readers of both kinds match.
inline constexpr Quality of_shown = {true, false, 1}, of_transforms = {true, false, 100},
                         of_log_lines = {true, true, 1000};

/// Publishes by a thread of its own, at bounded rates: poses and /tf each 20 ms at most, paths and markers each 0.1 s, diagnostics each
/// second, at most 50 log lines a second.
class FlightPublisher {
 public:
  /// In words, what a robot's link counted; by its thread.
  using Counts = std::function<std::string(std::size_t robot)>;
  /// @throws std::invalid_argument for robots whose topics would have one name, std::runtime_error where a topic cannot be had
  FlightPublisher(const Scenario& scenario, dds_entity_t participant, Counts counts);
  ~FlightPublisher();  ///< Once the last is published.
  FlightPublisher(const FlightPublisher&) = delete;
  FlightPublisher& operator=(const FlightPublisher&) = delete;

  // By the control thread: they allocate nothing and wait for nobody. What finds no room is not shown.
  void show(std::size_t robot, const RobotShown& shown) noexcept;
  void show(const Sample& sample) noexcept;

  /// A sentence for the log; before and after the task, by any thread.
  void say(std::string_view sentence);
  /// Messages so far and the part of a core that they took, in words.
  std::string counts() const;

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sightline::dds
