#include "bridges/dds/topics/operator_calls.hpp"

#include <gtest/gtest.h>

#include <array>
#include <thread>
#include <vector>

namespace sightline::dds {
namespace {

using Call = CallAnswer (OperatorCalls::*)() noexcept;

// Which call is taken in which phase: start, stop, land, emergency.
TEST(OperatorCalls, EachIsTakenWhereItMeansSomething) {
  constexpr std::array<Call, 4> calls = {&OperatorCalls::start, &OperatorCalls::stop, &OperatorCalls::land,
                                         &OperatorCalls::emergency};
  using P = FlightPhase;
  const std::vector<std::pair<P, std::array<bool, 4>>> table = {
      {P::checking, {false, false, true, true}},   {P::waiting, {true, false, true, true}},
      {P::taking_off, {false, false, true, true}}, {P::task, {false, true, true, true}},
      {P::landing, {false, false, true, true}},    {P::over, {false, false, false, false}}};
  for (const auto& [phase, taken] : table) {
    for (std::size_t k = 0; k < calls.size(); ++k) {
      OperatorCalls flight;
      flight.is_at(phase);
      const CallAnswer answer = (flight.*calls[k])();
      EXPECT_EQ(answer.success, taken[k]) << static_cast<int>(phase) << " " << k;
      EXPECT_FALSE(answer.message.empty());
      EXPECT_EQ(flight.started(), taken[k] && k == 0);
      EXPECT_EQ(flight.to_land(), taken[k] && k > 0);
      EXPECT_EQ(flight.is_emergency(), taken[k] && k == 3);
    }
  }
}

TEST(OperatorCalls, WhatIsAskedTwiceIsDoneOnceAndWhatLandsDoesNotStart) {
  OperatorCalls flight;
  flight.is_at(FlightPhase::waiting);
  EXPECT_TRUE(flight.land().success);
  EXPECT_TRUE(flight.land().success);
  EXPECT_FALSE(flight.start().success);
  EXPECT_FALSE(flight.started());
  EXPECT_FALSE(flight.is_emergency());
}

}  // namespace
}  // namespace sightline::dds
