/// Losing what one is localized by, and finding it again; hard distances kept on estimates.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "tests/support/campaign.hpp"
#include "tests/support/searching_flight.hpp"

namespace sightline {
namespace {

using test::SearchingFlight;
using test::SearchingOptions;
using test::SearchingOutcome;

struct SearchTally {
  std::vector<SearchingOutcome> flights;

  template <class Condition>
  int count(Condition&& condition) const {
    return static_cast<int>(std::count_if(flights.begin(), flights.end(), condition));
  }
  double found_within(double part) const {
    std::vector<double> times;
    for (const SearchingOutcome& f : flights) times.push_back(f.found_after);
    std::sort(times.begin(), times.end());
    return times[static_cast<std::size_t>(part * static_cast<double>(times.size() - 1))];
  }
  /// The standard deviation that was said at the end of hiding, over the error's.
  double said_of_true() const {
    double squares = 0, variances = 0;
    for (const SearchingOutcome& f : flights) squares += f.error * f.error, variances += f.sigma * f.sigma;
    return std::sqrt(variances / squares);
  }
  void print(const char* what) const {
    double squares = 0, variances = 0, nearest = 1e9, nees = 0;
    int searches = 0;
    for (const SearchingOutcome& f : flights) {
      squares += f.error * f.error, variances += f.sigma * f.sigma, nearest = std::min(nearest, f.nearest);
      searches += f.searches, nees += f.nees;
    }
    const auto n = static_cast<double>(flights.size());
    std::printf(
        "%-32s flights %zu, out of view over 0.5 s %d, found after median %.2f, 90 %% %.2f, all %.2f s; "
        "blind: error "
        "%.3f, said %.3f m, ANEES %.1f; searches %d, nearest %.2f m\n",
        what, flights.size(), count([](const SearchingOutcome& f) { return f.longest_unseen > 0.5; }),
        found_within(0.5), found_within(0.9), found_within(1.0), std::sqrt(squares / n),
        std::sqrt(variances / n), nees / n, searches, nearest);
  }
};

SearchTally tally(SearchingOptions options, int count) {
  SearchTally all;
  for (int i = 0; i < count; ++i) {
    options.seed = static_cast<std::uint64_t>(i) + 1;
    all.flights.push_back(SearchingFlight(options).fly());
  }
  return all;
}

constexpr std::array both_filters = {FilterKind::heading, FilterKind::attitude};

TEST(SearchingCampaign, HiddenForTwoAndFiveSecondsItIsNotLost) {
  for (const FilterKind filter : both_filters) {
    for (const double hidden : {2.0, 5.0}) {
      const SearchTally all =
          tally({.filter = filter, .duration = 20.0 + hidden, .hidden = {12.0, 12.0 + hidden}}, runs(50, 10));
      all.print(filter == FilterKind::heading ? "hidden, heading" : "hidden, attitude");
      EXPECT_LT(all.found_within(1.0), 2.0) << hidden;
      EXPECT_NEAR(all.said_of_true(), 1.0, whole_campaign() ? 0.2 : 0.5) << hidden;
      EXPECT_EQ(all.count([](const SearchingOutcome& f) { return f.longest_unseen > 0.5; }), 0) << hidden;
    }
  }
}

TEST(SearchingCampaign, HiddenForTenSecondsItBacksOffAndSweeps) {
  for (const FilterKind filter : both_filters) {
    const SearchTally all = tally({.filter = filter, .duration = 32.0, .hidden = {12.0, 22.0}}, runs(50, 10));
    all.print(filter == FilterKind::heading ? "hidden for 10 s, heading" : "hidden for 10 s, attitude");
    const int late = all.count([](const SearchingOutcome& f) { return f.found_after > 2.0; });
    EXPECT_LE(late, filter == FilterKind::heading ? 2 : 0);
  }
}

TEST(SearchingCampaign, ToldAWrongPoseItFindsTheTargetAgain) {
  for (const FilterKind filter : both_filters) {
    const SearchTally all = tally({.filter = filter, .duration = 24.0, .misled_at = 12.0}, runs(50, 10));
    all.print(filter == FilterKind::heading ? "misled, heading" : "misled, attitude");
    EXPECT_LT(all.found_within(1.0), 10.0);
  }
}

TEST(SearchingCampaign, WithoutAPositionItTurnsUntilItSees) {
  const SearchTally all = tally({.duration = 10.0, .starts_anywhere = true}, runs(100, 10));
  std::vector<double> known;
  for (const SearchingOutcome& f : all.flights) known.push_back(f.known_from);
  std::sort(known.begin(), known.end());
  std::printf("first contact: known after median %.2f s, 95 %% %.2f, last %.2f\n", known[known.size() / 2],
              known[known.size() * 95 / 100], known.back());
  EXPECT_LE(all.count([](const SearchingOutcome& f) { return f.known_from > 10.0; }), runs(1, 10));
}

TEST(SearchingCampaign, OnEstimatesNobodyComesBelowTheHardDistance) {
  for (const bool guarded : {true, false}) {
    double nearest = 1e9;
    int below = 0;
    const int count = runs(guarded ? 2000 : 100, 50);
    for (int i = 0; i < count; ++i) {
      // Shorter than it takes until the barrier reckons with less than is not known,
      // Guard::sigma_most.
      SearchingOptions options{
          .seed = static_cast<std::uint64_t>(i) + 1, .duration = 7.0, .hostile = true, .guarded = guarded};
      options.filter = both_filters[i % 10 == 0 ? 1 : 0];
      if (i % 2 == 1) options.hidden = {1.0 + 0.5 * (i % 5), options.duration + 1.0};
      const SearchingOutcome flown = SearchingFlight(options).fly();
      nearest = std::min(nearest, flown.nearest);
      below += flown.nearest < SearchingFlight::d_hard;
    }
    std::printf("%s: %d flights, %d below the hard distance, nearest %.3f m\n",
                guarded ? "barrier on" : "barrier off", count, below, nearest);
    if (guarded)
      EXPECT_EQ(below, 0);
    else
      EXPECT_GT(below, count / 4);
  }
}

}  // namespace
}  // namespace sightline
