/// Link to a multirotor on plain ROS 2 topics: odometry, cmd_vel, take-off and landing calls.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "bridges/dds/links/ros2_link.hpp"
#include "bridges/dds/topics/mailbox.hpp"
#include "bridges/dds/topics/service.hpp"
#include "sightline/model.hpp"

namespace sightline::dds {

/// Values of its state topic, an Int8.
enum class Ros2State : std::int8_t { landed = 0, flying = 1, taking_off = 2, landing = 3 };

/// A call without arguments: a message on a topic, or a service.
class TriggerCall {
 public:
  TriggerCall(Port participant, const std::string& name, FlightCalls calls);

  bool there() const noexcept { return service_ ? service_->there() : received_.load(); }
  /// The same, also valid with PublishMode::off, where no writer is matched.
  bool there(const Surroundings& around) const {
    return service_ ? service_->there() : topic_->received(around.readers);
  }
  void send() noexcept;
  /// Answer::none for a topic.
  Answer answer() const noexcept { return service_ ? service_->answer() : Answer::none; }
  void watch(std::span<const SeenWriter> writers);
  int rivals() const noexcept { return rivals_; }
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::unique_ptr<RawWriter> topic_;
  std::unique_ptr<ServiceCaller> service_;
  std::atomic<bool> received_{false};  // set by watch()
  std::atomic<int> rivals_{0};
};

/// Checks that the link suits the robot: a flying robot needs take-off and landing calls, and
/// inputs of the kind that cmd_vel carries.
/// @throws std::invalid_argument otherwise
void check_commands(const Ros2Link& link, std::string_view name, const Model& model);

/// The link has no arming: the robot is in our control from the take-off request until it stands
/// again.
/// Without a state topic, it flies if it is above 0.3 m over its start and neither climbs nor
/// sinks. It stands if it rests below 0.15 m.
class Ros2FlyerLinkEnd final : public Ros2LinkEnd {
 public:
  /// @throws std::runtime_error if a topic cannot be created
  Ros2FlyerLinkEnd(Port participant, const Link& link);

  LinkFacts facts(Nanoseconds now) noexcept override;
  void send(const LinkOutput& output, const Command& command, Nanoseconds now) noexcept override;
  void watch(std::span<const SeenWriter> writers) override;
  void examine(const Surroundings& around, FindingList& to) override;

 private:
  struct State {
    Nanoseconds arrived = 0;
    std::int8_t is = 0;
  };
  enum class Phase : std::uint8_t { ground, ours, takeoff, setpoints, landing };

  bool says() const noexcept { return reader_ != nullptr; }
  bool is(Ros2State state) const noexcept { return last_state_.is == static_cast<std::int8_t>(state); }

  Mailbox<State> state_;  // filled by the receive thread

  // Control thread only.
  State last_state_{};
  Phase phase_ = Phase::ground;
  bool down_ = false;
  double ground_ = 0.0, land_from_ = 0.0;  // heights [m]
  Nanoseconds moved_at_ = 0;               // last time of vertical motion
  int speakers_ = -1;                      // state writers matched at the arm request; -1: none requested yet

  TriggerCall takeoff_, land_;
  std::unique_ptr<RawReader> reader_;  // last member: destroyed before the members it fills
};

}  // namespace sightline::dds
