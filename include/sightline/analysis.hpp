/// Scenarios as a whole: limits that cannot hold together, checks before a flight, campaigns of many runs.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/judge.hpp"
#include "sightline/scenario.hpp"
#include "sightline/team.hpp"
#include "sightline/world.hpp"

namespace sightline {

// Analysis of a team's limits before a flight: which limits can hold together, each pair's
// equilibrium, and the cost of each limit compared with the others.

/// What a limit requires of the distance of its two bodies.
enum class LimitKind {
  apart,     ///< broken at small distances, in any direction
  together,  ///< broken at large distances
  view,      ///< depends on the direction
  none,      ///< states no limit
};

/// Distances at which a limit, or several limits at once, can hold [m].
struct DistanceBand {
  double low, high;
};

/// A coupling's limit and its greatest weighted cost.
struct LimitWorth {
  std::size_t coupling;  ///< in the order of the team
  LimitKind kind{};
  std::vector<DistanceBand> holds;  ///< ascending; empty: it can hold at no distance
  bool in_world = false;            ///< it depends on the places in G; sampled around the starts
  double worst = 0.0;               ///< weight times the greatest l within `explain_reach`
};

/// Equilibrium of two bodies under their couplings alone; each coupling moves the bodies it acts
/// on.
struct PairRest {
  double distance, across, height;  ///< of the first body above the second [m]
  double cost;                      ///< weighted
  DistanceBand within;              ///< distances [m] where the cost is at most `explain_margin` higher
  std::vector<std::size_t> broken;  ///< indices of the couplings whose limits do not hold there
};

/// All couplings of two bodies.
struct PairAdvice {
  BodyId first, second;                ///< in the order of the pair's first coupling
  std::optional<std::size_t> same_as;  ///< an earlier pair whose couplings and weights are the same
  std::vector<LimitWorth> limits;
  std::vector<DistanceBand> holds;  ///< all limits at once, ascending; empty: they contradict each other
  std::vector<std::pair<std::size_t, std::size_t>> contradictions;  ///< indices of two couplings
  std::optional<PairRest> rest;
  std::optional<Vec3<double>> drift;  ///< direction in which both move without bound, each by its own cost
};

/// Cost of a collision for a robot, compared with all other limits that it would break by evading.
struct HitCost {
  std::size_t coupling;          ///< the coupling that keeps the robot apart from another body
  AgentId agent;                 ///< the robot it acts on
  double hit, others;            ///< greatest cost of this limit; sum over the robot's other limits that
                                 ///< keep no bodies apart
  std::optional<double> weight;  ///< weight at which a collision costs more than the others; none:
                                 ///< it does already
};

inline constexpr double explain_reach = 6.0;    ///< [m]
inline constexpr double explain_margin = 0.01;  ///< of the weighted cost [-]

struct Explanation {
  std::vector<PairAdvice> pairs;
  std::vector<HitCost> hits;
};

/// Samples the relative poses of each pair. Set-up: allocates.
/// @param x0  states of all bodies at the start (team.nx()); empty: all are at the origin
Explanation explain(const Team& team, std::span<const double> x0 = {});

/// The explanation as text, one sentence a line.
std::string to_string(const Explanation& explanation, const Team& team);

/// Text of `sightline explain`: the limits, cycles of observation, how cameras see tags, and which
/// robots' sensors do not determine their poses. Takes seconds if robots have cameras.
std::string explain_text(const Scenario& scenario);

/// check_scenario() with the checks of this analysis, if nothing refuses the flight: potentials,
/// cycles of observation and observability. Takes some tenths of a second.
Preflight preflight(const Scenario& scenario);

// A part of a campaign's runs, flown independently of the others.

/// Every `of`-th run, from `number` on. Shards 1 to N of N cover all runs, each once; number 0
/// equals N.
struct Shard {
  int number = 0;  ///< from 0 to `of`
  int of = 1;      ///< >= 1; 1: all runs

  int first() const { return number % of; }
  /// Index of its i-th run in the campaign.
  int run(int i) const { return first() + i * of; }
  /// Number of its runs in a campaign of `runs` runs.
  int size(int runs) const { return runs > first() ? (runs - first() - 1) / of + 1 : 0; }
  bool is_whole() const { return of == 1; }
  bool operator==(const Shard&) const = default;
};

inline constexpr int shards_max = 10'000;

/// Parses "3/8".
/// @throws std::invalid_argument
Shard shard_of(std::string_view text);

/// "3/8"
std::string to_string(const Shard& shard);

// Random numbers of one run of a campaign.

/// Draws one number.
double draw(const Distribution& distribution, RandomStream& random);

struct RunDraw {
  int index = 0;
  std::uint64_t seed = 0;      ///< of all random streams of the run; below 2^53
  std::vector<double> values;  ///< in the order of drawn_names()
};

/// Depends only on the campaign's seed and the index. Each value has its own stream, so that a
/// further draw in the plan does not change the earlier ones.
RunDraw draw_run(const CampaignPlan& plan, std::uint64_t seed, int index);

/// The run whose numbers are the quantiles of a point: the distributions of the plan, if the point's
/// numbers are independent and standard normal.
/// @param point  one number for each of drawn_names()
/// @param seed   of all random streams of the run; below 2^53
RunDraw run_at(const CampaignPlan& plan, std::span<const double> point, std::uint64_t seed, int index);

// Scenarios of the runs of a campaign, which differ in the drawn numbers.

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
  /// The same without [campaign], which takes as long to read as the rest.
  Scenario flight(const RunDraw& run) const;
  /// As of(), with a text to be written into `folder` and flown from there: it contains duration
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

  Scenario drawn(std::string_view text, const RunDraw& run) const;
  Scenario flown(std::string text, const std::filesystem::path& file, std::vector<std::string> set,
                 const RunDraw& run) const;
  /// Builds a run to check that the numbers to add may be added.
  void try_additions() const;
  void place_start(const StartDraw& draw, const Start& at, const double*& value, Changes& changes) const;

  CampaignPlan plan_;
  std::filesystem::path file_;
  std::string text_, text_of_flight_, name_;
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

// Monte Carlo runs of one scenario, each with its own draws, on all cores.

struct CampaignOptions {
  int runs = 100;          ///< >= 1
  std::uint64_t seed = 1;  ///< with an index, determines all draws of a run
  int threads = 1;         ///< >= 1
  int first = 0;           ///< number of the shard's runs that are known already
  Shard shard{};           ///< the part of the runs to fly
  /// The run of an index; empty: draw_run().
  std::function<RunDraw(int index)> draw{};
  /// Ends the campaign after the runs in progress, once it is true.
  const std::atomic<bool>* stop = nullptr;
};

/// Flies runs one after another, in one thread, and reuses its solvers.
class RunWorker {
 public:
  /// @param variants  must outlive this object
  RunWorker(const Variants& variants, const CampaignPlan& plan) : variants_(variants), plan_(plan) {}

  /// @throws ScenarioError if a drawn number is refused
  RunResult fly(const RunDraw& run);

 private:
  Controls& controls_of(const RunDraw& run, const Scenario& scenario);

  static constexpr std::size_t solvers_max = 8;
  const Variants& variants_;
  CampaignPlan plan_;
  std::vector<std::pair<std::vector<double>, std::unique_ptr<Controls>>> controls_;  // oldest first
};

/// The draws of a scenario.
/// @throws std::invalid_argument if it has no [campaign], ScenarioError if its campaign cannot be
///   flown
const CampaignPlan& campaign_plan(const Scenario& scenario);

/// @throws ScenarioError if the scenario cannot be judged over many runs of the plan, as Variants
void check_campaign(const Scenario& scenario, const CampaignPlan& plan);

/// Flies the unknown runs of options.shard with an index below options.runs. Passes them to
/// `landed` in the order of their indices.
/// @param landed  called by one thread at a time; an exception of it ends the campaign
/// @return number of runs passed to `landed`
/// @throws ScenarioError with the run, if a drawn number is refused
int fly_campaign(const Scenario& scenario, const CampaignPlan& plan, const CampaignOptions& options,
                 const std::function<void(const RunDraw&, const RunResult&)>& landed);

}  // namespace sightline
