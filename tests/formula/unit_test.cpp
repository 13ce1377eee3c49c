#include <gtest/gtest.h>

#include "sightline/formula.hpp"

namespace sightline {
namespace {

TEST(Unit, ARootOfAPowerIsAUnitUntilHalvesEnd) {
  EXPECT_EQ(to_power(units::length, 2), units::length * units::length);
  EXPECT_EQ(to_power(*to_power(units::length, 0.5), 2), units::length);
  EXPECT_EQ(to_power(units::velocity, -1), units::time / units::length);
  EXPECT_FALSE(to_power(units::length, 0.3));
  EXPECT_FALSE(to_power(*to_power(units::length, 0.5), 0.5));
  EXPECT_FALSE(to_power(units::length, 1e9));
  EXPECT_EQ(to_power(units::none, 0.3), units::none);
}

TEST(Unit, IsSaidAsItIsWritten) {
  EXPECT_EQ(to_string(units::length), "m");
  EXPECT_EQ(to_string(units::velocity), "m/s");
  EXPECT_EQ(to_string(units::none / (units::time * units::time)), "1/s^2");
  EXPECT_EQ(to_string(*to_power(units::length, 0.5)), "m^0.5");
  EXPECT_EQ(to_string(units::length * units::time), "m s");
  EXPECT_EQ(to_string(units::none), "a plain number or an angle");
}

}  // namespace
}  // namespace sightline
