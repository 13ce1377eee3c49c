#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "sightline/base.hpp"

namespace sightline {
namespace {

/// Whether the processor makes a subnormal number now; volatile, so that the compiler does not.
bool subnormals_arise() {
  volatile double tiny = std::numeric_limits<double>::min();
  return tiny / 4 != 0.0;
}

/// Whether a subnormal number that is already there counts.
bool subnormals_count() {
  volatile double subnormal = std::numeric_limits<double>::denorm_min();
  return subnormal * 0x1p100 != 0.0;
}

TEST(Subnormals, InsideTheScopeTheyAreZeroAndOutsideTheyAreNot) {
  ASSERT_TRUE(subnormals_arise() && subnormals_count());
  {
    const FlushSubnormals flush;
    EXPECT_FALSE(subnormals_arise());
    EXPECT_FALSE(subnormals_count());
  }
  EXPECT_TRUE(subnormals_arise() && subnormals_count());
}

TEST(Subnormals, AScopeWithinAScopeLeavesTheOuterOneAsItWas) {
  const FlushSubnormals outer;
  { const FlushSubnormals inner; }
  EXPECT_FALSE(subnormals_arise());
}

TEST(Subnormals, AScopeIsOfItsThreadAlone) {
  bool elsewhere = true;
  std::thread([&] {
    const FlushSubnormals flush;
    elsewhere = subnormals_arise();
  }).join();
  EXPECT_FALSE(elsewhere);
  EXPECT_TRUE(subnormals_arise());
}

}  // namespace
}  // namespace sightline
