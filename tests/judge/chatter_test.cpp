#include "sightline/judge/chatter.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/period.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using test::control_period;

// What u(k) makes over so many periods, with a range of 2.
template <class U>
std::vector<Chatter::Found> of(int periods, U&& u, double range = 2.0) {
  Chatter chatter(1);
  for (int k = 0; k < periods; ++k) chatter.add(0, control_period * k, u(k), range);
  return chatter.found();
}

TEST(Chatter, AnInputThatAlternatesIsToldWithItsJumpItsShareAndItsBegin) {
  const auto found = of(1000, [](int k) { return k < 300 || k >= 700 ? 0.2 : k % 2 == 0 ? 0.41 : 0.0; });
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].input, 0U);
  EXPECT_NEAR(found[0].jump, 0.41, 1e-3);
  EXPECT_NEAR(found[0].share, 0.4, 0.011);
  EXPECT_NEAR(found[0].from, 3.45, 0.02);
}

TEST(Chatter, ItIsMeasuredByTheRangeOfTheInput) {
  const auto alternates = [](int k) { return k % 2 == 0 ? 0.03 : 0.0; };
  EXPECT_FALSE(of(200, alternates, 2.0).empty());
  EXPECT_TRUE(of(200, alternates, 6.0).empty());
  EXPECT_FALSE(of(
                   200, [&](int k) { return 3 * alternates(k); }, 6.0)
                   .empty());
  EXPECT_TRUE(of(200, [](int k) { return k % 2 == 0 ? 0.01 : 0.0; }).empty());
}

TEST(Chatter, ItIsFoundOnAnInputThatMovesBesides) {
  EXPECT_FALSE(of(400, [](int k) { return 0.5 * std::sin(0.02 * k) + (k % 2 == 0 ? 0.1 : 0.0); }).empty());
}

TEST(Chatter, NoiseOscillationsAndJumpsNowAndThenAreNone) {
  Random random(1);
  EXPECT_TRUE(of(200'000, [&](int) { return uniform(random, -1, 1); }).empty());
  EXPECT_TRUE(of(2000, [](int k) { return std::sin(1.5 * k); }).empty());  // 21 periods of 5
  EXPECT_TRUE(of(2000, [](int k) { return k / 50 % 2 == 0 ? 1.0 : -1.0; }).empty());
  EXPECT_TRUE(of(2000, [](int k) { return k % 100 < 40 ? k % 2 : 0; }).empty());  // a transient
  EXPECT_TRUE(of(2000, [](int) { return std::nan(""); }).empty());
}

TEST(Chatter, EachInputIsJudgedByItself) {
  Chatter chatter(3);
  for (int k = 0; k < 100; ++k) {
    chatter.add(0, control_period * k, 0.1, 2.0);
    chatter.add(1, control_period * k, k % 2 == 0 ? 1.0 : -1.0, 2.0);
    chatter.add(2, control_period * k, 0.01 * k, 2.0);
  }
  ASSERT_EQ(chatter.found().size(), 1U);
  EXPECT_EQ(chatter.found()[0].input, 1U);
  EXPECT_EQ(chatter.worst_share(), chatter.found()[0].share);
  EXPECT_EQ(Chatter(3).worst_share(), 0.0);
}

}  // namespace
}  // namespace sightline
