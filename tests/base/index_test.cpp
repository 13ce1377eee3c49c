#include <gtest/gtest.h>

#include "sightline/base.hpp"

namespace sightline {
namespace {

static_assert(at(0) == 0U && at(7) == 7U);
static_assert(size(0) == 0U && size(7) == 7U);

TEST(Index, OfWhatIsNegativeIsAFault) {
  EXPECT_DEBUG_DEATH(static_cast<void>(at(-1)), "a place is not negative");
  EXPECT_DEBUG_DEATH(static_cast<void>(size(-1)), "a size is not negative");
}

}  // namespace
}  // namespace sightline
