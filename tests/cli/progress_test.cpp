#include "cli/progress.hpp"

#include <gtest/gtest.h>

namespace sightline::cli {
namespace {

TEST(Progress, IsSilentWhereStderrIsNoTerminal) {
  testing::internal::CaptureStderr();
  {
    Progress progress(10.0);
    progress.show(5.0);
    progress.show(10.0);
    progress.end();
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace sightline::cli
