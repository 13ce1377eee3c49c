#include "sightline/server/page_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(PageFiles, TheProgramCarriesThePageOrAPageThatSaysThatItDoesNot) {
  const PageFiles files = page_files();
  ASSERT_TRUE(files.contains("/"));
  EXPECT_EQ(files.size(), has_page() ? 3U : 1U);
  for (const auto& [path, file] : files) {
    EXPECT_TRUE(file.open) << path;
    EXPECT_FALSE(file.body.empty()) << path;
  }
  if (has_page()) {
    EXPECT_THAT(files.at("/").body, HasSubstr("page.js"));
    EXPECT_LT(files.at("/page.js").body.size(), 1'500'000U);
  } else {
    EXPECT_THAT(files.at("/").body, HasSubstr("built without its page"));
  }
}

// Its policy lets a browser run none, and fetch nothing from elsewhere.
TEST(PageFiles, ThePageHasNoInlineScriptAndNamesNoOtherPlace) {
  const std::string page = page_files().at("/").body;
  EXPECT_THAT(page, Not(HasSubstr("<script>")));
  EXPECT_THAT(page, Not(HasSubstr("<style")));
  EXPECT_THAT(page, Not(HasSubstr("://")));
}

}  // namespace
}  // namespace sightline
