#include <gtest/gtest.h>

#include <numbers>

#include "sightline/formula.hpp"

namespace sightline {
namespace {

TEST(Unit, NamesAreKnownWithTheirSize) {
  EXPECT_EQ(unit_named("m")->unit, units::length);
  EXPECT_EQ(unit_named("cm")->factor, 0.01);
  EXPECT_EQ(unit_named("deg")->unit, units::none);
  EXPECT_DOUBLE_EQ(180 * unit_named("deg")->factor, std::numbers::pi);
  EXPECT_EQ(unit_named("Hz")->unit, units::none / units::time);
  EXPECT_FALSE(unit_named("metre"));
}

TEST(Unit, ProductsAndQuotientsAddAndSubtractPowers) {
  EXPECT_EQ(units::velocity * units::time, units::length);
  EXPECT_EQ(units::length / units::time, units::velocity);
  EXPECT_EQ(units::length / units::length, units::none);
}

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
