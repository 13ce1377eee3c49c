#include <gtest/gtest.h>

#include <set>

#include "sightline/estimator.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

TEST(FilterOptions, TheirDefaultsAreInTheirRangesAndTheirKeysDiffer) {
  EXPECT_NO_THROW(FilterOptions{}.check());
  const auto keys = parameter_keys<FilterOptions>();
  EXPECT_EQ(std::set(keys.begin(), keys.end()).size(), keys.size());
}

TEST(FilterOptions, ANumberOutOfItsRangeIsRefusedByName) {
  EXPECT_EQ(refusal_of([] { FilterOptions{.velocity_noise = 0.0}.check(); }),
            "estimate.velocity_noise = 0, expected > 0 m/s");
  EXPECT_EQ(refusal_of([] { FilterOptions{.tilt_time = -1.0}.check(); }),
            "estimate.tilt_time = -1, expected > 0 s");
  EXPECT_EQ(refusal_of([] { FilterOptions{.start_sightings = 0}.check(); }),
            "estimate.start_sightings = 0, expected 1 to 32");
}

}  // namespace
}  // namespace sightline
