/// The link to a multirotor on plain topics of ROS 2: an odometry, a cmd_vel, and what takes it off and lands it.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "bridges/dds/mailbox.hpp"
#include "bridges/dds/ros2_link.hpp"
#include "bridges/dds/service.hpp"
#include "sightline/model/model.hpp"

namespace sightline::dds {

/// What its state says, an Int8.
enum class Ros2State : std::int8_t { landed = 0, flying = 1, taking_off = 2, landing = 3 };

/// A call without words: a message on a topic, or a service.
class Signal {
 public:
  Signal(Port participant, const std::string& name, FlightCalls calls);

  bool there() const noexcept { return service_ ? service_->there() : received_.load(); }
  /// The same of a silent end too, whose writer nobody is matched with.
  bool there(const Surroundings& around) const {
    return service_ ? service_->there() : topic_->received(around.readers);
  }
  void send() noexcept;
  /// None of a topic.
  Answer answer() const noexcept { return service_ ? service_->answer() : Answer::none; }
  void watch(std::span<const SeenWriter> writers);
  int rivals() const noexcept { return rivals_; }
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::unique_ptr<RawWriter> topic_;
  std::unique_ptr<ServiceCaller> service_;
  std::atomic<bool> received_{false};  // by watch()
  std::atomic<int> rivals_{0};
};

/// What flies takes off and lands, and its inputs are what its cmd_vel is in.
/// @throws std::invalid_argument for a robot that this link does not go with
void check_commands(const Ros2Link& link, std::string_view name, const Model& model);

/// It has no arming: it is ours from the request to take off until it stands again. Where it does not say its state, it flies where it
/// is higher than 0.3 m above its start and neither climbs nor sinks, and stands where it rests below 0.15 m.
class Ros2FlyerLinkEnd final : public Ros2LinkEnd {
 public:
  /// @throws std::runtime_error where a topic cannot be had
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

  Mailbox<State> state_;  // filled by the thread that receives

  // Of the control thread.
  State last_state_{};
  Phase phase_ = Phase::ground;
  bool down_ = false;
  double ground_ = 0.0, land_from_ = 0.0;  // heights [m]
  Nanoseconds moved_at_ = 0;               // up or down, last
  int speakers_ = -1;                      // that had come when it was ours; -1: it was not yet

  Signal takeoff_, land_;
  std::unique_ptr<RawReader> reader_;  // last: it ends before what it fills
};

}  // namespace sightline::dds
