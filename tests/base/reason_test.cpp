#include "sightline/base/reason.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <system_error>

namespace sightline {
namespace {

TEST(Reason, IsTheSystemsForItsErrno) {
  EXPECT_EQ(reason(ENOENT), std::make_error_code(std::errc::no_such_file_or_directory).message());
  EXPECT_NE(reason(ENOENT), reason(EACCES));
}

}  // namespace
}  // namespace sightline
