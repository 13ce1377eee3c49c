/// Adds telemetry to a world: robots report their motion, and bodies broadcast their poses.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/parameter.hpp"
#include "sightline/world/motion_sensor.hpp"
#include "sightline/world/sensing_world.hpp"

namespace sightline {

/// Radio over which bodies with known poses broadcast them.
struct Radio {
  static constexpr std::string_view name = "radio";

  double rate = 100.0;
  std::array<double, 2> latency = {0.0, 0.0};
  double dropout = 0.0;
  double position_sigma = 0.01;
  double heading_sigma = 0.01;
  double velocity_sigma = 0.03;

  static constexpr auto parameters() {
    using R = Radio;
    return std::tuple{
        parameter("rate", &R::rate, "Hz", {0.1, 1000, "0.1 to 1000"},
                  "messages; each is sent at the first period that it is due at"),
        parameter("latency", &R::latency, "s", {0, 1, "0 to 1"},
                  "from sending to arrival: drawn evenly between the two"),
        parameter("dropout", &R::dropout, "", {0, 1, "0 to 1"}, "part of the messages that is lost"),
        parameter("position_sigma", &R::position_sigma, "m", above_zero, "of the position, each axis"),
        parameter("heading_sigma", &R::heading_sigma, "rad", above_zero, "of the heading"),
        parameter("velocity_sigma", &R::velocity_sigma, "m/s", from_zero, "of the velocity, each axis")};
  }

  bool operator==(const Radio&) const = default;
  /// @throws std::invalid_argument naming a number out of its range
  void check() const;
};

/// A robot that reports its motion.
struct MovingRobot {
  BodyId robot{};
  FilterOptions errors{};  ///< of its autopilot's sensors
};

struct TelemetryOptions {
  std::uint64_t seed = 1;
  std::vector<MovingRobot> robots{};
  std::vector<BodyId> broadcasters{};  ///< bodies that broadcast their poses
  Radio radio{};
};

/// Decorator that adds telemetry to any world that provides the true states. In each measure() a
/// robot's autopilot reports its motion since the previous call (MotionSensor). A broadcasting body
/// sends its measured pose, plus the errors of the radio, at the first period at which a message is
/// due. The message arrives at the first measure() after its latency.
///
/// An absent body sends nothing, and its pending messages are dropped when it leaves.
class TelemetryWorld final : public SensingWorld {
 public:
  /// @throws std::invalid_argument for options out of range, and for a world that already provides
  /// telemetry
  TelemetryWorld(std::unique_ptr<World> world, const TelemetryOptions& options);

  MeasuredMost measured_max() const noexcept override;
  void set_presence(std::span<const Presence> presence) noexcept override;
  Measured measure(double t) noexcept override;

 private:
  struct Robot {
    BodyId body{};
    MotionSensor sensor;
    bool there = true, moves = false;  // moves: p and R are those of the last measure()
    Vec3<double> p{};
    Mat<3, 3> R = identity<3>();
  };
  struct Sender {
    BodyId body{};
    bool there = true;
    std::int64_t next = 0;         // number of the next message, due at next / rate
    std::optional<double> last{};  // stamp of the last message
    RandomStream chance;
  };
  struct Message {
    double arrival = 0.0;
    BodyBroadcast what{};
  };

  void move(Robot& robot, double t, const Measured& now) noexcept;
  void send(Sender& sender, double t, const Measured& now) noexcept;
  void deliver(double t) noexcept;

  Radio radio_;
  std::vector<Robot> robots_;
  std::vector<Sender> senders_;
  std::vector<RobotMotion> motions_;
  UnderWay<Message> messages_;
  std::vector<BodyBroadcast> arrived_;
  double last_ = 0.0;  // time of the last measure() [s]
};

}  // namespace sightline
