/// Evasion of an obstacle by a robot that observes a target: Table 1 and Figs 26 to 32 of the
/// paper.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sightline/loop.hpp"
#include "sightline/report.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// One column of Table 1.
struct EvasionRow {
  double min_obstacle;  ///< least distance of robot and obstacle, from its entry on [m]
  double min_target;    ///< least and
  double max_target;    ///< greatest distance of robot and target [m]
  double max_angle;     ///< greatest angle of the target off the sensor axis, from the entry on [rad], (71)
  double first_view;    ///< time when the target came into view [s]; infinity if never
  double lost;          ///< total time out of view after that [s]
};

/// Time series of one run, a row every 0.1 s.
struct EvasionSeries {
  std::vector<double> time, heading;                  // [s], [rad]
  std::vector<Vec3<double>> p, obstacle, target;      // [m]
  std::vector<double> to_obstacle, to_target, angle;  // [m], [m], [rad]
  std::vector<std::string> inputs;                    // names
  std::vector<std::vector<double>> u;                 // [input][row]
};

/// Receives a loop's samples and keeps the data for the table and the figures.
class EvasionTrace final : public Sink<Sample> {
 public:
  /// @param sample  of sized_sample()
  /// @throws std::invalid_argument if the plan names unknown bodies, or if the robot's sensor does
  ///   not observe the target
  EvasionTrace(const Scenario& scenario, const EvasionPlan& plan, Sample sample);

  Sample* claim() noexcept override { return &sample_; }
  void publish() noexcept override;
  void close() noexcept override {}

  const EvasionRow& row() const { return row_; }
  const EvasionSeries& series() const { return series_; }

 private:
  const Team& team_;
  EvasionPlan plan_;
  BodyId agent_, target_, obstacle_;
  SensorMount mount_;
  double period_;
  std::int64_t every_, samples_ = 0;  // samples per row
  Sample sample_;
  EvasionRow row_;
  EvasionSeries series_;
};

/// The runs of one scenario.
struct EvasionRuns {
  std::string name;
  std::vector<EvasionTrace> runs;
};

/// Table 1: a row for each quantity and source, the published values first; a column for each run.
std::vector<std::vector<std::string>> evasion_table(const EvasionPlan& plan,
                                                    std::span<const EvasionRuns> flown);

/// Figs 26 to 32 of one scenario's runs.
std::vector<Drawing> evasion_drawings(const EvasionPlan& plan, const EvasionRuns& flown);

}  // namespace sightline
