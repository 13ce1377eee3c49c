#include "sightline/base/split_mix.hpp"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(SplitMix, GivesTheNumbersOfItsAuthors) {
  std::uint64_t state = 1234567;
  for (const std::uint64_t expected : {6457827717110365317ULL, 3203168211198807973ULL, 9817491932198370423ULL,
                                       4593380528125082431ULL, 16408922859458223821ULL})
    EXPECT_EQ(next_split_mix(state), expected);
}

}  // namespace
}  // namespace sightline
