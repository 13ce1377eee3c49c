#include "sightline/report/page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Page, ShowsAnyTextAsItIs) {
  EXPECT_EQ(escaped("a < b & \"c\" > d\n\te \x01"), "a &lt; b &amp; &quot;c&quot; &gt; d\n\te  ");
  EXPECT_THAT(page_head("<script>"), Not(HasSubstr("<script>")));
  EXPECT_THAT(page_figure({"<b>", "<i>", "<svg></svg>"}), Not(HasSubstr("<b>")));
  EXPECT_THAT(page_figure({"<b>", "<i>", "<svg></svg>"}), HasSubstr("<svg></svg>"));
}

TEST(Page, HasTheScriptOfItsFiguresAndASentenceForThoseWhoRunNone) {
  EXPECT_FALSE(figures_script().empty()) << "expected the packages of scripts/deps.sh test";
  EXPECT_THAT(figures_script(), Not(HasSubstr("</script")));
  EXPECT_THAT(page_end(), HasSubstr(std::string(figures_script())));
  EXPECT_THAT(page_head("title"), HasSubstr("<noscript>"));
}

}  // namespace
}  // namespace sightline
