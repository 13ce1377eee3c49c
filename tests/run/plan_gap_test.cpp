#include "sightline/run/plan_gap.hpp"

#include <gtest/gtest.h>

#include "tests/support/period.hpp"

namespace sightline {
namespace {

using test::control_period;

SolverRecord record(Status status, bool answered = true) {
  SolverRecord of;
  of.status = status;
  of.answered = answered;
  return of;
}

/// Adds n periods from period k on. @return the next
int add(PlanGaps& gaps, int k, int n, const SolverRecord& of) {
  for (int i = 0; i < n; ++i) gaps.add(control_period * (k + i), control_period, of);
  return k + n;
}

TEST(PlanGaps, EveryStatusThatGivesAPlanEndsAGapAndNoOtherDoes) {
  for (int s = 0; s < status_count; ++s) {
    const auto status = static_cast<Status>(s);
    PlanGaps gaps;
    add(gaps, 0, 100, record(status));
    const bool planned = s <= static_cast<int>(Status::deadline);
    EXPECT_EQ(gives_plan(status), planned);
    EXPECT_NEAR(gaps.failed().longest, planned ? 0.0 : 1.0, 1e-12) << to_string(status);
    EXPECT_NEAR(gaps.any().longest, planned ? 0.0 : 1.0, 1e-12) << to_string(status);
  }
}

TEST(PlanGaps, TheLongestIsKeptWithItsBeginAndWhy) {
  PlanGaps gaps;
  int k = add(gaps, 0, 10, record(Status::stepped));
  k = add(gaps, k, 30, record(Status::not_finite));
  k = add(gaps, k, 10, record(Status::invalid_state));
  k = add(gaps, k, 1, record(Status::converged));
  k = add(gaps, k, 20, record(Status::invalid_state));
  EXPECT_NEAR(gaps.failed().longest, 0.4, 1e-12);
  EXPECT_NEAR(gaps.failed().from, 0.1, 1e-12);
  EXPECT_EQ(gaps.failed().status, Status::not_finite);
}

TEST(PlanGaps, ASolverThatWasNotAskedDidNotFail) {
  PlanGaps gaps;
  int k = add(gaps, 0, 50, record(Status::deadline, false));
  EXPECT_EQ(gaps.failed().longest, 0.0);
  EXPECT_NEAR(gaps.any().longest, 0.5, 1e-12);
  // It is to blame from its own failure on, until it gives a plan, asked or not in between.
  k = add(gaps, k, 1, record(Status::not_finite));
  k = add(gaps, k, 9, record(Status::deadline, false));
  EXPECT_NEAR(gaps.failed().longest, 0.1, 1e-12);
  EXPECT_NEAR(gaps.failed().from, 0.5, 1e-12);
  EXPECT_NEAR(gaps.any().longest, 0.6, 1e-12);
  add(gaps, k, 1, record(Status::stepped));
  EXPECT_NEAR(gaps.any().longest, 0.6, 1e-12);
}

}  // namespace
}  // namespace sightline
