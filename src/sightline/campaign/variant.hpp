/// Scenarios that differ from one in the numbers drawn for each run.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sightline/campaign/draw.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/scenario_numbers.hpp"

namespace sightline {

/// Makes the scenario of each run by writing its numbers into the text, so that the run's own text is a scenario
/// that `sightline run` flies.
class Variants {
 public:
  /// @param base  its text is what is written over
  /// @param plan  of the same scenario, or of another whose numbers are in this one too
  /// @throws ScenarioError where a number of the plan is neither in the text nor may be added to it
  Variants(const Scenario& base, const CampaignPlan& plan);

  /// @throws ScenarioError where a number drawn is refused
  Scenario of(const RunDraw& run) const;
  /// The same with a text that may be written into a folder and flown from there: it has duration and seed, and names
  /// files as they are seen from there.
  Scenario of(const RunDraw& run, const std::filesystem::path& folder) const;

  /// The drawn values that an Ocp depends on; runs alike in these share a solver.
  std::vector<double> team_values(const RunDraw& run) const;

 private:
  /// Where the numbers of a start stand.
  struct Start {
    NumberInText p[3], around[3], heading, v[2];
  };
  using Changes = std::vector<std::pair<NumberInText, double>>;

  Scenario flown(std::string text, const std::filesystem::path& file, std::vector<std::string> set,
                 const RunDraw& run) const;
  /// What is to be added must be something that may be added, which a run shows.
  void try_additions() const;
  void place_start(const StartDraw& draw, const Start& at, const double*& value, Changes& changes) const;

  CampaignPlan plan_;
  std::filesystem::path file_;
  std::string text_, name_;
  std::shared_ptr<const Registry> registry_;
  std::vector<Start> starts_;
  /// A number that follows from a drawn value.
  struct Drawn {
    std::optional<NumberInText> number;  // none: it is added
    std::string key;
    std::size_t draw;
    double times, plus;

    double of(const RunDraw& run) const { return times * run.values[draw] + plus; }
  };
  std::vector<Drawn> draws_;
  std::vector<std::size_t> of_team_;             // indices of values
  std::optional<NumberInText> duration_, seed_;  // of [simulation], where they are written out
  SolverChoice solver_;
};

}  // namespace sightline
