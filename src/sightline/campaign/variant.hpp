/// Scenarios of the runs of a campaign, which differ in the drawn numbers.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sightline/campaign/draw.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/scenario_numbers.hpp"

namespace sightline {

/// Writes a run's numbers into the text of the base scenario. `sightline run` can fly the resulting
/// text.
class Variants {
 public:
  /// @param base  its text is the template
  /// @param plan  of the same scenario, or of another one whose numbers are in this one too
  /// @throws ScenarioError if a number of the plan is neither in the text nor may be added to it
  Variants(const Scenario& base, const CampaignPlan& plan);

  /// @throws ScenarioError if a drawn number is refused
  Scenario of(const RunDraw& run) const;
  /// The same with a text to be written into `folder` and flown from there: it contains duration
  /// and seed, and its file names are valid from there.
  Scenario of(const RunDraw& run, const std::filesystem::path& folder) const;

  /// The drawn values that an Ocp depends on; runs with equal values share a solver.
  std::vector<double> team_values(const RunDraw& run) const;

 private:
  /// Positions of a start's numbers in the text.
  struct Start {
    NumberInText p[3], around[3], heading, v[2];
  };
  using Changes = std::vector<std::pair<NumberInText, double>>;

  Scenario flown(std::string text, const std::filesystem::path& file, std::vector<std::string> set,
                 const RunDraw& run) const;
  /// Builds a run to check that the numbers to add may be added.
  void try_additions() const;
  void place_start(const StartDraw& draw, const Start& at, const double*& value, Changes& changes) const;

  CampaignPlan plan_;
  std::filesystem::path file_;
  std::string text_, name_;
  std::shared_ptr<const Registry> registry_;
  std::vector<Start> starts_;
  /// A number that follows from a drawn value.
  struct Drawn {
    std::optional<NumberInText> number;  // none: the number is added
    std::string key;
    std::size_t draw;
    double times, plus;

    double of(const RunDraw& run) const { return times * run.values[draw] + plus; }
  };
  std::vector<Drawn> draws_;
  std::vector<std::size_t> of_team_;             // indices of values
  std::optional<NumberInText> duration_, seed_;  // of [simulation], if they are in the text
  SolverChoice solver_;
};

}  // namespace sightline
