#include <gtest/gtest.h>

#include "tests/support/folder.hpp"
#include "tests/support/mutated_bags.hpp"
#include "tests/support/mutated_rigs.hpp"
#include "tests/support/ulog.hpp"

namespace sightline::test {
namespace {

TEST(ReadersCampaign, AHundredThousandMutatedULogsAreReadOrRefusedInOneSentence) {
  EXPECT_GT(read_mutated_ulogs(100'000, 2), 10'000);
}

TEST(ReadersCampaign, AHundredThousandMutatedBagsAreReadOrRefusedInOneSentence) {
  EXPECT_GT(read_mutated_bags(100'000, 2, fresh_folder() / "a.mcap"), 1'000);
}

TEST(ReadersCampaign, AHundredThousandMutatedRigsAreReadOrRefusedInOneSentence) {
  EXPECT_GT(read_mutated_rigs(100'000, 2, fresh_folder()), 10'000);
}

}  // namespace
}  // namespace sightline::test
