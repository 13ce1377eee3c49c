#include "sightline/report/gnuplot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

#include "tests/support/folder.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(Gnuplot, WritesWhatItsScriptAsksFor) {
  EXPECT_EQ(run_gnuplot("set print '-'\nprint 'a', 2\n"), "a 2\n");
  const std::string rows(300'000, '#');  // more than any pipe holds
  EXPECT_EQ(run_gnuplot("set print '-'\n# " + rows + "\nprint 1\n"), "1\n");
}

TEST(Gnuplot, AFaultOfTheScriptIsTold) {
  try {
    run_gnuplot("plot nothing(x)\n");
    FAIL() << "expected a failure";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("undefined function: nothing"));
  }
}

// A signal that ends us between two lines of ours leaves nothing, since there is nothing.
TEST(Gnuplot, LeavesNothingInTheFolderForTemporaryFiles) {
  const auto folder = test::fresh_folder();
  const char* const before = std::getenv("TMPDIR");
  const std::string kept = before != nullptr ? before : "";
  ::setenv("TMPDIR", folder.c_str(), 1);
  EXPECT_THAT(run_gnuplot("set terminal svg\nplot x\n"), HasSubstr("</svg>"));
  ::setenv("TMPDIR", (folder / "none").c_str(), 1);
  EXPECT_THAT(run_gnuplot("set terminal svg\nplot x\n"), HasSubstr("</svg>")) << "and needs none";
  before != nullptr ? ::setenv("TMPDIR", kept.c_str(), 1) : ::unsetenv("TMPDIR");
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

}  // namespace
}  // namespace sightline
