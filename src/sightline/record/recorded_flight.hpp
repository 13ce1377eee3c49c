/// What a flight saw and did, as its log keeps it for a replay: written, and read as a world that can be flown again.
///
/// Topics of run.mcap, one message a period each:
///
///     /BODY/measurement   {time, stamp, x}: the state that the controllers saw, all numbers exactly, and when it was
///                         so; null in x is a number that was not finite, a null stamp is a body never seen
///     /OBSERVER/detection {time, stamp, arrival, target, tags, p, q, covariance}: what its camera said of another body,
///     in order
///     /AGENT/goal         {time, after, p, heading}: where a person sent it, the waypoints one after another
///     /team               {time}: a team that was asked for took over in this period, or was refused
///
/// beside those of localization (localization_log.hpp), /BODY/state (the truth), /AGENT/input (the command) and /events (missed periods). No time of the wall clock.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sightline/ocp/team.hpp"
#include "sightline/record/log_text.hpp"
#include "sightline/run/clock.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/scenario/goal_track.hpp"
#include "sightline/world/world.hpp"

namespace sightline {

/// Writes the topics above, but for those of the log itself.
class MeasurementLog {
 public:
  MeasurementLog(const Team& team, MessageSink& sink, const std::vector<RobotGoals>& goals = {});

  /// Adds a sample; allocates nothing once the buffers have grown and each observer has detected something.
  void add(const Sample& sample);

 private:
  SchemaId detection();

  Team team_;
  MessageSink& sink_;
  LogMessage message_;
  struct Goals {
    std::shared_ptr<const GoalTrack> track;
    McapChannel channel{};
    std::size_t written = 0;
  };
  void add_goals(double time);

  std::vector<Goals> goals_;
  std::vector<Waypoint> waypoints_;
  std::vector<double> numbers_;
  std::vector<McapChannel> bodies_;                     // of each body
  std::vector<std::optional<McapChannel>> detections_;  // of each body that detected one
  std::optional<SchemaId> detection_{};
  McapChannel changes_;
};

/// One period of a recorded flight.
struct RecordedPeriod {
  double time = 0.0;                                       ///< [s]
  std::vector<double> measured{}, stamps{}, truth{}, u{};  ///< nx, bodies, nx, nu
  std::vector<Detection> detections{};
  std::vector<RobotMotion> motions{};
  std::vector<BodyBroadcast> broadcasts{};
  /// Of a robot that was localized.
  struct Localized {
    BodyId robot{};
    PoseEstimate estimate{};
  };
  std::vector<Localized> estimates{};
  std::vector<Status> status{};  ///< of each controller
  bool team_answered = false;
};

/// A recorded flight as a world, and as the clock of a loop that flies in it: the same measurements in the same
/// periods; periods that were missed are missed again. Commands move nothing; a sink compares them.
class RecordedFlight final : public World, public Clock {
 public:
  /// @param team  of the scenario that was flown
  /// @param goals  those of the team that took goals: their tracks are cleared, and get the recorded ones
  /// @throws std::runtime_error with a sentence that names the file where it cannot be read, or holds no measurements
  /// of this team
  RecordedFlight(const std::filesystem::path& log, Team team, std::vector<double> start, double period,
                 std::vector<RobotGoals> goals = {});

  const std::vector<RecordedPeriod>& periods() const noexcept { return periods_; }
  /// Whether the log ends in the middle, as that of a killed run.
  bool truncated() const noexcept { return truncated_; }
  /// Time after which samples were lost, so that what followed is not to be repeated [s]; none if all are there.
  std::optional<double> lost_after() const noexcept { return lost_after_; }
  /// The number of the period at a time [s], from 0 where the flight began.
  std::int64_t number(double time) const noexcept;

  const Team& team() const noexcept override { return team_; }
  std::span<const double> start() const noexcept override { return start_; }
  MeasuredMost measured_max() const noexcept override { return most_; }
  void set_presence(std::span<const Presence>) noexcept override {}
  Measured measure(double t) noexcept override;
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override;

  void start(double) noexcept override {}
  std::int64_t wait(std::int64_t k) noexcept override;
  bool waits_for_log() const noexcept override { return true; }
  TeamDue team_due(std::int64_t k) const noexcept override;

 private:
  class Reader;

  Team team_;
  std::vector<double> start_;
  double period_;  // [s]
  std::vector<RecordedPeriod> periods_;
  struct RecordedGoal {
    double time;  // [s]
    std::shared_ptr<GoalTrack> track;
    std::vector<Waypoint> waypoints;
  };
  std::vector<RobotGoals> goals_;
  std::vector<RecordedGoal> sent_;
  std::size_t next_goal_ = 0;
  std::size_t next_ = 0;  // period to be measured
  bool measured_ = false;
  MeasuredMost most_{};
  bool truncated_ = false;
  std::optional<double> lost_after_{};
};

}  // namespace sightline
