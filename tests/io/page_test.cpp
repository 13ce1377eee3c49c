#include "sightline/io/page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "tests/support/folder.hpp"

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

TEST(Page, ReadsOnLightAndOnDark) {
  EXPECT_THAT(page_head("title"), HasSubstr("color-scheme: light dark"));
  EXPECT_THAT(page_head("title"), HasSubstr("<title>title</title>"));
}

TEST(Page, WhatIsWrittenStandsInTheFileAndAFileThatCannotBeIsNamed) {
  const test::Folder folder("page_test");
  const auto file = folder.path() / "page.html";
  for (const std::string text : {"a longer text\n", "short"}) {
    write_text(file, text);
    std::ifstream in(file, std::ios::binary);
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), text);
  }
  try {
    write_text(folder.path() / "nowhere" / "page.html", "");
    FAIL() << "expected a refusal";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("nowhere/page.html cannot be written"));
  }
}

}  // namespace
}  // namespace sightline
