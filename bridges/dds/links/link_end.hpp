/// Local end of the link to one robot, independent of its protocol.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/links/inertial_samples.hpp"
#include "bridges/dds/links/link_machine.hpp"
#include "bridges/dds/links/robot_state.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/pose_subscriber.hpp"
#include "bridges/dds/topics/surroundings.hpp"

namespace sightline::dds {

/// look(), facts() and send() run on the control thread: they do not allocate, lock, throw or
/// print. The other functions may.
class LinkEnd {
 public:
  virtual ~LinkEnd() = default;

  /// Copies the newest motion. @return false if there is none yet
  virtual bool look(SeenMotion& seen) noexcept = 0;
  virtual LinkFacts facts(Nanoseconds now) noexcept = 0;
  /// Sends `output`; `command` applies to Setpoint::task.
  virtual void send(const LinkOutput& output, const Command& command, Nanoseconds now) noexcept = 0;

  /// Updates the knowledge of other writers; a few times per second, on one thread.
  virtual void watch(std::span<const SeenWriter> writers) = 0;
  /// Findings before a flight: the topics the robot is flown by, and the reasons that prevent
  /// arming. Runs on the examining thread; may allocate.
  virtual void examine(const Surroundings& around, FindingList& to) = 0;
  /// Ends the readers and writers that only examine() and reply() need; called before the task.
  virtual void stop_examining() {}
  /// The robot's reply to a request since the last call, as text; empty: none. Control thread, not
  /// during the task; allocates.
  virtual std::string reply() { return {}; }
  /// Subscriber of the robot's pose and motion.
  virtual PoseSubscriber& subscriber() noexcept = 0;
  /// Its inertial measurements; null unless EndSetup requires them and the kind of link has them.
  virtual InertialSamples* inertial() noexcept { return nullptr; }
  /// Geodetic origin of its local frame, if the robot reports one.
  virtual std::optional<GeoPoint> reference() const { return std::nullopt; }
  /// How far its stamps are behind its clock, as it reports [s]; 0 if unknown. Examining thread.
  virtual double stamps_behind() const noexcept { return 0.0; }
  /// Counts of received and rejected messages, as text.
  virtual std::string counts() const = 0;
};

/// What the end of a link is made from: `end` of its kind. `end` throws std::invalid_argument if the
/// link does not support the model, std::runtime_error if a topic cannot be created.
struct EndSetup {
  Port at;
  const Link& link;
  std::string_view name;  ///< of the robot
  const Model& model;
  const FleetNetwork& network;
  double height = -std::numeric_limits<double>::infinity();  ///< where the task begins, in G [m]
  bool inertial = false;                                     ///< its estimator requires inertial measurements
  double period = 0.01;                                      ///< control period [s]
};
inline std::unique_ptr<LinkEnd> made_end(const EndSetup& setup) {
  return std::visit([&](const auto& kind) { return kind.end(setup); }, setup.link.kind);
}

}  // namespace sightline::dds
