#include "sightline/server/page_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

// What the tests need, scripts/deps.sh test, is what the page is built of.
TEST(PageFiles, TheProgramCarriesThePage) {
  ASSERT_TRUE(has_page()) << without_page(page_lacks());
  EXPECT_EQ(page_lacks(), "");
  const PageFiles files = page_files();
  ASSERT_EQ(files.size(), 3U);
  for (const auto& [path, file] : files) {
    EXPECT_TRUE(file.open) << path;
    EXPECT_FALSE(file.body.empty()) << path;
  }
  EXPECT_THAT(files.at("/").body, HasSubstr("page.js"));
  EXPECT_LT(files.at("/page.js").body.size(), 800'000U);
}

TEST(PageFiles, WithoutAPageItIsSaidWhatTheBuildLackedAndWhatBringsIt) {
  const PageFiles files = page_files({}, "esbuild and libjs-three");
  ASSERT_EQ(files.size(), 1U);
  EXPECT_THAT(files.at("/").body, HasSubstr("for want of esbuild and libjs-three"));
  EXPECT_THAT(files.at("/").body, HasSubstr("scripts/deps.sh demo"));
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
