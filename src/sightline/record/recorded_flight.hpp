/// Measurements and commands of a flight in its log: a writer, and a world that replays them.
///
/// Topics of run.mcap; /BODY/measurement has one message per period, the others as data arrives:
///
///     /BODY/measurement   {time, stamp, x}: the measured state that the controllers receive, all
///                         numbers exact, and its time; null in x: a number that was not finite;
///                         null stamp: a body that was never measured
///     /OBSERVER/detection {time, stamp, arrival, target, tags, p, q, covariance}: detection of
///                         another body by the observer's camera, in order
///     /AGENT/goal         {time, after, p, heading}: goal that a person sent, as successive
///                         waypoints
///     /team               {time}: a requested team took effect in this period or was rejected
///
/// A replay also uses the topics of localization (localization_log.hpp), /BODY/state (the truth),
/// /AGENT/input (the command) and /events (missed periods). Nothing depends on wall-clock time.
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

/// Writes the four topics above; the others belong to LocalizationLog and LogTopics.
class MeasurementLog {
 public:
  MeasurementLog(const Team& team, MessageSink& sink, const std::vector<RobotGoals>& goals = {});

  /// Adds a sample; allocates nothing once the buffers have reached their final size and each
  /// observer has detected a body.
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
  std::vector<std::optional<McapChannel>> detections_;  // of each body with a detection
  std::optional<SchemaId> detection_{};
  McapChannel changes_;
};

/// One period of a recorded flight.
struct RecordedPeriod {
  double time = 0.0;                                       ///< [s]
  std::vector<double> measured{}, stamps{}, truth{}, u{};  ///< sizes nx, bodies, nx, nu
  std::vector<Detection> detections{};
  std::vector<RobotMotion> motions{};
  std::vector<BodyBroadcast> broadcasts{};
  /// Estimate of a localized robot.
  struct Localized {
    BodyId robot{};
    PoseEstimate estimate{};
  };
  std::vector<Localized> estimates{};
  std::vector<Status> status{};  ///< of each controller
  bool team_answered = false;
};

/// A recorded flight as the world and the clock of a loop: the same measurements in the same
/// periods; missed periods are missed again. Commands have no effect; a sink compares them.
class RecordedFlight final : public World, public Clock {
 public:
  /// @param team    of the scenario that was flown
  /// @param goals   of the team that received goals: their tracks are cleared and receive the
  ///   recorded goals
  /// @throws std::runtime_error with a sentence that names the file, if it cannot be read or
  ///   contains no measurements of this team
  RecordedFlight(const std::filesystem::path& log, Team team, std::vector<double> start, double period,
                 std::vector<RobotGoals> goals = {});

  const std::vector<RecordedPeriod>& periods() const noexcept { return periods_; }
  /// True if the log is truncated, as after a killed run.
  bool truncated() const noexcept { return truncated_; }
  /// Time after which samples were lost, so that later periods cannot be replayed [s]; empty if
  /// none was lost.
  std::optional<double> lost_after() const noexcept { return lost_after_; }
  /// Number of the period at a time [s]; 0 at the start of the flight.
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
  std::size_t next_ = 0;  // next period to be measured
  bool measured_ = false;
  MeasuredMost most_{};
  bool truncated_ = false;
  std::optional<double> lost_after_{};
};

}  // namespace sightline
