/// A recorded flight flown again: the same measurements into the same loop, and its commands compared with those of
/// the log.
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

/// How a log says that it was flown.
struct FlownAs {
  std::string name, text;  ///< of the scenario, with the events that were tuned behind its own
  FileTexts files{};       ///< that the scenario names
  std::string solver;
  std::string version, compiler;
  std::string partition{}, order{};  ///< where the team planned in parts; else empty
  int exchanges = 1;
};
/// @throws std::runtime_error with a sentence that names the file where it is no log of a run
FlownAs flown_as(const std::filesystem::path& log);

/// The scenario of a log as it was flown, or with another solver or other values; no deadline acts, and nothing flies beside it.
/// @param log  its file, for refusals
/// @param set  as in ScenarioChanges
/// @throws ScenarioError, and std::invalid_argument as solver_named() and check_solvers()
Scenario flown_scenario(const FlownAs& flown, const std::filesystem::path& log, const Registry& registry,
                        const std::optional<std::string>& solver = {},
                        const std::vector<std::string>& set = {});

/// Where a command first differs from the recorded one.
struct FirstDifference {
  std::int64_t update = 0;  ///< number of the period since the flight began
  double time = 0.0;        ///< [s]
  std::string robot, input;
  double recorded = 0.0, replayed = 0.0;
};

/// Where an estimate of a robot's pose first differs from the recorded one.
struct FirstEstimate {
  std::int64_t update = 0;  ///< number of the period since the flight began
  double time = 0.0;        ///< [s]
  std::string robot, what;  ///< "p.x", "covariance"; "known" where one of them says nothing
  double recorded = 0.0, replayed = 0.0;
};

/// How far the commands of one robot are from the recorded ones.
struct RobotDifference {
  std::string name;
  std::int64_t differing = 0;       ///< commands of which a bit differs
  double largest = 0.0, rms = 0.0;  ///< of an input, over all of them
  double largest_at = 0.0;          ///< [s]
};

/// Compares each command of a loop that flies in a recorded flight, and each estimate of its localizer, bit for bit;
/// allocates nothing.
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
  /// Updates of which a solver's status differs.
  std::int64_t other_status() const noexcept { return other_status_; }
  std::optional<FirstDifference> first() const;
  /// Estimates of robots that are localized, and those of which a bit differs.
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

/// What was compared, as JSON: docs/replay.md has the keys.
std::string comparison_json(const CommandComparison& compared, const Scenario& scenario,
                            const RecordedFlight& flight);

}  // namespace sightline
