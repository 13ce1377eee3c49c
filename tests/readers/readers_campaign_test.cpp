#include <gtest/gtest.h>

#include "tests/support/ulog.hpp"

namespace sightline::test {
namespace {

TEST(ReadersCampaign, AHundredThousandMutatedULogsAreReadOrRefusedInOneSentence) {
  EXPECT_GT(read_mutated_ulogs(100'000, 2), 10'000);
}

}  // namespace
}  // namespace sightline::test
