/// World input from bodies that others observe: targets, obstacles, and robots of other parts of
/// the team.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/links/link_end.hpp"
#include "bridges/dds/topics/pose_subscriber.hpp"
#include "sightline/scenario.hpp"

namespace sightline::dds {

/// All observed bodies of a fleet that have a link. Only the control thread calls measure() and
/// are_seen().
class SeenBodies {
 public:
  /// @throws std::runtime_error if a topic cannot be created
  SeenBodies(const Scenario& scenario, dds_entity_t participant);

  /// Writes each body's state and stamp into the team's; the stamp is minus infinity before its
  /// first pose.
  /// @param origin  time 0 of the stamps, of the monotonic clock
  void measure(Nanoseconds origin, std::span<double> measured, std::span<double> stamps) noexcept;
  /// Before a flight: whether each body has recent poses from one writer, in its frame.
  bool are_seen(Nanoseconds now) noexcept;

  /// Adds the findings about each body.
  void examine(const Scenario& scenario, std::vector<Finding>& to) const;
  /// Adds counts of received and rejected messages, one line per body.
  void counts(std::vector<std::string>& to) const;

 private:
  struct Body {
    std::string name;
    std::size_t index, x;  // index in the team; offset of the state
    PosesFrom from;
    SeenVelocity velocity;
    std::unique_ptr<PoseSubscriber> poses;
    std::unique_ptr<LinkEnd> robot{};  // robot of another part: its link, receive only; `poses` is then null

    PoseSubscriber& subscriber() const { return robot ? robot->subscriber() : *poses; }
  };
  std::vector<Body> bodies_;
};

}  // namespace sightline::dds
