/// Targets and obstacles that others see, and robots of other parts of the team, as a part of the world.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/link_end.hpp"
#include "bridges/dds/pose_subscriber.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline::dds {

/// All of a fleet that have a link. measure() and are_seen() are the control thread's.
class SeenBodies {
 public:
  /// @throws std::runtime_error where a topic cannot be had
  SeenBodies(const Scenario& scenario, dds_entity_t participant);

  /// Writes state and stamp of each into those of the team; the stamp of one that was never seen is minus infinity.
  /// @param origin  time 0 of the stamps, of the monotonic clock
  void measure(Nanoseconds origin, std::span<double> measured, std::span<double> stamps) noexcept;
  /// Whether poses of each are there before a flight, young, of one writer and in their frame.
  bool are_seen(Nanoseconds now) noexcept;

  /// Adds what is found of each.
  void examine(std::vector<Finding>& to) const;
  /// Adds what was received and refused, a line each.
  void counts(std::vector<std::string>& to) const;

 private:
  struct Body {
    std::string name;
    std::size_t index, x;  // its place in the team, where its state begins
    PosesFrom from;
    SeenVelocity velocity;
    std::unique_ptr<PoseSubscriber> poses;
    std::unique_ptr<LinkEnd> robot{};  // of another part: its link, to which we listen; then `poses` is none

    PoseSubscriber& subscriber() const { return robot ? robot->subscriber() : *poses; }
  };
  std::vector<Body> bodies_;
};

}  // namespace sightline::dds
