#include "sightline/base/refuse.hpp"

#include <gtest/gtest.h>

#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

TEST(Refuse, ThrowsItsSentence) {
  EXPECT_EQ(refusal_of([] { refuse("{} = {}, expected > {} s", "period", -1, 0); }),
            "period = -1, expected > 0 s");
}

}  // namespace
}  // namespace sightline
