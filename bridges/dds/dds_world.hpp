/// A fleet on its links, as a world.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "bridges/dds/domain.hpp"
#include "bridges/dds/flight_publisher.hpp"
#include "bridges/dds/goal_subscriber.hpp"
#include "bridges/dds/link_end.hpp"
#include "bridges/dds/link_telemetry.hpp"
#include "bridges/dds/prediction_exchange.hpp"
#include "bridges/dds/preflight.hpp"
#include "bridges/dds/seen_bodies.hpp"
#include "bridges/dds/services.hpp"
#include "sightline/base/service_thread.hpp"
#include "sightline/scenario/bridge.hpp"

namespace sightline::dds {

class DdsWorld final : public LinkedWorld {
 public:
  /// @param domain  of the scenario's [fleet]
  /// @throws std::invalid_argument for a scenario that it cannot fly, std::runtime_error where a topic cannot be had
  /// @param voice   silent: it listens alone, and nobody notices
  DdsWorld(const Scenario& scenario, std::shared_ptr<Domain> domain, const LinkTimes& times = {},
           PublishMode publish = PublishMode::on);
  ~DdsWorld() override;

  const Team& team() const noexcept override { return team_; }
  std::span<const double> start() const noexcept override { return start_; }
  MeasuredMost measured_max() const noexcept override { return telemetry_.most(); }
  void set_presence(std::span<const Presence>) noexcept override {}
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

  /// Before a flight, by the thread that flies: what is found of the robots, and where they say that they are.
  std::vector<Finding> examine() { return preflight_.examine(); }
  std::vector<RobotPose> poses();

  LinkState state(BodyId robot) const {
    return robots_[static_cast<std::size_t>(robot.index)].machine.state();
  }

 private:
  struct Robot {
    std::string name;
    std::unique_ptr<LinkEnd> end;
    RobotState model;
    LinkMachine machine;
    std::size_t body, x, u;              // its place in the team, where its state and its inputs begin
    std::shared_ptr<GoalTrack> track{};  // none: it takes no goals
    std::unique_ptr<GoalSubscriber> goals{};
    LinkState reported = LinkState::waiting;
    bool estimated = false, knows = false, knew = false;  // localized by view; where it is, now and once
  };

  std::vector<Robot> made_robots(PublishMode publish) const;
  std::vector<PoseSubscriber*> subscribers() const;
  std::vector<ExaminedRobot> examined() const;
  void step_all(LinkOrder order, std::span<const double> estimated, std::span<const double> u) noexcept;
  void report_changes(const PrintMessage& print);
  void report_news();
  /// To the person, and to those who look on.
  void report_all(const std::string& sentence, const PrintMessage& print);
  /// Steps at the period until `done`; at once where that is so.
  template <class Done>
  void steps_until(LinkOrder order, const Interrupts& interrupts, const PrintMessage& print, Done&& done);
  void stand(LinkOrder order) noexcept;
  void begin_together(const Interrupts& interrupts, const PrintMessage& print);
  bool each_is(std::initializer_list<LinkState> states) const;
  bool each_stands() const;
  bool in_our_hands() const;

  Scenario scenario_;
  const Team& team_;  // of it
  std::vector<double> start_, measured_, stamps_;
  std::int64_t period_;  // [ns]
  LinkTimes times_;
  std::string node_;
  std::shared_ptr<Domain> domain_;
  std::vector<Robot> robots_;  // in the order of the team, whose first bodies they are
  SeenBodies bodies_;
  std::unique_ptr<PredictionExchange> talk_;  // of a part of a team
  LinkTelemetry telemetry_;
  Preflight preflight_;
  OperatorCalls calls_;
  std::unique_ptr<OperatorServices> services_;  // none where it only listens
  std::atomic<bool> rival_{false};              // another program has our name
  std::vector<std::string> refusals_;           // of a fleet that was ready
  std::unique_ptr<FlightPublisher> topics_;     // none where nobody is to see the flight
  std::int64_t origin_ = 0;                     // time 0 of the loop, of the monotonic clock [ns]
  bool settled_ = false;                        // all hold, and stand
  bool begun_ = false, seen_ = false;
  std::int64_t periods_ = 0, missed_ = 0;
  DelayHistogram wakes_;
  double begun_cpu_ = 0.0;
  std::optional<double> cpu_;  // at the end of the task, of one core
  std::atomic<bool> done_{false};
  std::mutex news_;            // of the next
  PrintMessage news_go_to_{};  // while the task is flown
  ServiceThread watcher_{"the watch over writers"};
};

}  // namespace sightline::dds
