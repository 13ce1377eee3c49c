/// World of a fleet that is connected by DDS links.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "bridges/dds/domain.hpp"
#include "bridges/dds/fleet/bridge.hpp"
#include "bridges/dds/links/link_end.hpp"
#include "bridges/dds/links/link_telemetry.hpp"
#include "bridges/dds/preflight.hpp"
#include "bridges/dds/topics/flight_publisher.hpp"
#include "bridges/dds/topics/goal_subscriber.hpp"
#include "bridges/dds/topics/prediction_exchange.hpp"
#include "bridges/dds/topics/seen_bodies.hpp"
#include "bridges/dds/topics/services.hpp"
#include "sightline/base.hpp"

namespace sightline::dds {

class DdsWorld final : public LinkedWorld {
 public:
  /// @param domain   of the scenario's [fleet]
  /// @param publish  off: receives only; its sole writers request message layouts of PX4 vehicles
  /// @throws std::invalid_argument if the scenario cannot be flown, std::runtime_error if a topic
  ///   cannot be created
  DdsWorld(const Scenario& scenario, std::shared_ptr<Domain> domain, const LinkTimes& times = {},
           PublishMode publish = PublishMode::on);
  ~DdsWorld() override;

  const Team& team() const noexcept override { return team_; }
  std::span<const double> start() const noexcept override { return start_; }
  MeasuredMost measured_max() const noexcept override { return telemetry_.most(); }
  void set_presence(std::span<const Presence> presence) noexcept override;
  bool absent_robots_stay() const noexcept override { return true; }
  Joining prepare(BodyId robot) noexcept override;
  void call_off(BodyId robot) noexcept override;
  Measured measure(double t) noexcept override;
  bool apply(double t, std::span<const double> estimated, const sightline::Command& u, double period,
             std::int64_t periods) noexcept override;
  std::string ended() const override;

  bool take_off(Arming arming, const Interrupts& interrupts, const PrintMessage& print) override;
  void land(const Interrupts& interrupts, const PrintMessage& print) override;
  bool requested_to_land() const noexcept override { return calls_.to_land(); }
  void show(const Sample& sample) noexcept override;
  std::vector<std::string> faults() const override;
  std::vector<std::string> counts() const override;
  LinkTiming timing() const override;
  PartExchange* exchange() noexcept override { return talk_.get(); }

  /// Before a flight, on the flying thread: findings about the robots, and their reported poses.
  std::vector<Finding> examine() { return preflight_.examine(); }
  std::vector<RobotPose> poses();

  LinkState state(BodyId robot) const {
    return robots_[static_cast<std::size_t>(robot.index)].machine.state();
  }

 private:
  /// Relation of a robot to the team.
  enum class Role : std::uint8_t {
    grounded,  ///< absent: it stays on the ground
    joins,     ///< takes off and holds
    flies,     ///< in the team
    leaves,    ///< has left the team, or has risen for an event that is ignored: it lands
  };

  struct Robot {
    std::string name;
    std::unique_ptr<LinkEnd> end;
    RobotState model;
    LinkMachine machine;
    LinkFacts facts{};                   // of the last step
    std::size_t body, x, u;              // index in the team; offsets of state and input
    std::shared_ptr<GoalTrack> track{};  // null: accepts no goals
    std::unique_ptr<GoalSubscriber> goals{};
    LinkState reported = LinkState::waiting;
    bool estimated = false, knows = false, knew = false;  // localized by vision; pose known now; known once
    LinkOrigin frame{};                                   // estimated pose of its odometry frame, in G
    Role role = Role::flies;
    double rises_at = std::numeric_limits<double>::infinity();  // in the task, ahead of its event [s]
    double risen_since = 0.0, fit_at = 0.0;                     // monotonic clock [s]
    JoiningPlace place;
    bool placed = false;      // where it joins
    bool holds = false;       // there, at the height of its start, at rest
    bool called_off = false;  // in the air, its event is ignored
  };

  /// State of a robot for other threads.
  struct Published {
    std::atomic<LinkState> state{LinkState::waiting};
    std::atomic<LinkReason> reason{LinkReason::as_requested};
    std::atomic<bool> joins{false}, called_off{false};
  };

  std::vector<Robot> made_robots(PublishMode publish) const;
  std::vector<LinkEnd*> ends() const;
  std::vector<ExaminedRobot> examined() const;
  void step_all(LinkOrder order, std::span<const double> estimated, std::span<const double> u) noexcept;
  void report_changes(const PrintMessage& print);
  void report_states(const PrintMessage& print);
  void report_news();
  /// Prints the sentence and publishes it to the flight log.
  void report_all(const std::string& sentence, const PrintMessage& print);
  /// Steps once per period until `done` returns true; returns at once if it is true already.
  template <class Done>
  void steps_until(LinkOrder order, const Interrupts& interrupts, const PrintMessage& print, Done&& done);
  void stand(LinkOrder order) noexcept;
  void begin_together(const Interrupts& interrupts, const PrintMessage& print);
  bool each_is(std::initializer_list<LinkState> states) const;
  /// Whether each robot that is in the team now fulfils a condition.
  template <class Is>
  bool each_in_team(const Is& is) const {
    return std::all_of(robots_.begin(), robots_.end(),
                       [&](const Robot& r) { return r.role != Role::flies || is(r); });
  }
  LinkOrder order_of(Robot& robot, LinkOrder order, double t) const noexcept;
  LinkOrder order_of_joining(Robot& robot, double t) const noexcept;
  bool each_stands() const;
  /// Why robots left the flight, one sentence each.
  std::vector<std::string> reasons() const;
  bool in_our_hands() const;

  Scenario scenario_;
  const Team& team_;  // of scenario_
  std::vector<double> start_, measured_, stamps_;
  std::vector<Quaternion> attitudes_;
  std::int64_t period_;  // [ns]
  LinkTimes times_;
  std::string node_;
  std::shared_ptr<Domain> domain_;
  std::vector<Robot> robots_;         // in team order; robots are the first bodies of the team
  std::vector<Published> published_;  // of robots_
  SeenBodies bodies_;
  std::unique_ptr<PredictionExchange> talk_;  // null unless the team is planned in parts
  LinkTelemetry telemetry_;
  Preflight preflight_;
  OperatorCalls calls_;
  std::unique_ptr<OperatorServices> services_;  // null with PublishMode::off
  std::atomic<bool> rival_{false};              // another program uses this node name
  std::vector<std::string> refusals_;           // of a fleet that was ready
  std::unique_ptr<FlightPublisher> topics_;     // null if nothing of the flight is published
  std::int64_t origin_ = 0;                     // time 0 of the loop, monotonic clock [ns]
  bool settled_ = false;                        // all hold, and the wait for standstill is over
  bool begun_ = false, seen_ = false;
  std::int64_t periods_ = 0, missed_ = 0;
  DelayHistogram wakes_;
  double begun_cpu_ = 0.0;
  std::optional<double> cpu_;  // average load of the task [cores]
  std::atomic<bool> done_{false};
  std::mutex news_;            // guards news_go_to_
  PrintMessage news_go_to_{};  // set during the task
  ServiceThread watcher_{"the watch over writers"};
};

}  // namespace sightline::dds
