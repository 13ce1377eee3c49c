/// Replay of a recorded flight: gives the same measurements to the same loop and compares its
/// commands with the log.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sightline/record/recorded_flight.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/run/spsc_queue.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// How a recorded run was flown, from its log.
struct FlownAs {
  std::string name, text;  ///< of the scenario; text includes the tuned events at its end
  FileTexts files{};       ///< that the scenario names
  std::string solver;
  std::string version, compiler;
  std::string partition{}, order{};  ///< for a partitioned team; else empty
  int exchanges = 1;
};
/// Reads it from the metadata of a log.
/// @throws std::runtime_error with a sentence that names the file, if it is no log of a run
FlownAs flown_as(const std::filesystem::path& log);

/// The scenario of a log as it was flown, or with another solver or other values. Deadlines are
/// off, and there are no comparison flights.
/// @param log  path of the log, for error messages
/// @param set  as in ScenarioChanges
/// @throws ScenarioError, and std::invalid_argument as solver_named() and check_solvers()
Scenario flown_scenario(const FlownAs& flown, const std::filesystem::path& log, const Registry& registry,
                        const std::optional<std::string>& solver = {},
                        const std::vector<std::string>& set = {});

/// First command that differs from the recorded one.
struct FirstDifference {
  std::int64_t update = 0;  ///< number of the period since the start of the flight
  double time = 0.0;        ///< [s]
  std::string robot, input;
  double recorded = 0.0, replayed = 0.0;
};

/// First pose estimate that differs from the recorded one.
struct FirstEstimate {
  std::int64_t update = 0;  ///< number of the period since the start of the flight
  double time = 0.0;        ///< [s]
  std::string robot, what;  ///< "p.x", "covariance"; "known" if only one of them has an estimate
  double recorded = 0.0, replayed = 0.0;
};

/// Difference between the commands of one robot and the recorded ones.
struct RobotDifference {
  std::string name;
  std::int64_t differing = 0;       ///< number of commands with a different bit
  double largest = 0.0, rms = 0.0;  ///< of an input, over all commands
  double largest_at = 0.0;          ///< [s]
};

/// Compares each command and each pose estimate of a replay with the log, bit for bit; allocates
/// nothing.
class CommandComparison final : public Sink<Sample> {
 public:
  /// @param prototype  sized_sample() of the loop
  CommandComparison(const RecordedFlight& flight, Sample prototype);

  Sample* claim() noexcept override { return &sample_; }
  void publish() noexcept override;
  void close() noexcept override {}

  std::int64_t updates() const noexcept { return static_cast<std::int64_t>(updates_); }
  std::int64_t commands() const noexcept;
  std::int64_t differing() const noexcept;
  /// Number of updates with a different solver status.
  std::int64_t other_status() const noexcept { return other_status_; }
  std::optional<FirstDifference> first() const;
  /// Number of pose estimates, and number of those with a different bit.
  std::int64_t estimates() const noexcept { return estimates_; }
  std::int64_t differing_estimates() const noexcept { return differing_estimates_; }
  std::optional<FirstEstimate> first_estimate() const;
  /// One for each robot, in the order of the team.
  std::vector<RobotDifference> robots() const;

 private:
  struct Robot {
    BodyId body;
    std::size_t u, nu;
    std::int64_t differing = 0;
    double largest = 0.0, largest_at = 0.0, squares = 0.0;
  };

  void compare_estimates(const RecordedPeriod& recorded) noexcept;

  const RecordedFlight& flight_;
  Sample sample_;
  std::vector<Robot> robots_;
  std::int64_t estimates_ = 0, differing_estimates_ = 0;
  struct EstimatePlace {
    std::size_t update;
    BodyId robot;
    std::size_t what;
    double recorded, replayed;
  };
  std::optional<EstimatePlace> first_estimate_{};
  std::size_t updates_ = 0;
  std::int64_t other_status_ = 0;
  struct Place {
    std::size_t update, robot, input;
    double replayed;
  };
  std::optional<Place> first_{};
};

/// Results of the comparison as JSON; docs/replay.md lists the keys.
std::string comparison_json(const CommandComparison& compared, const Scenario& scenario,
                            const RecordedFlight& flight);

}  // namespace sightline
