/// Who writes JSON: base/json_text.hpp alone, since nlohmann's dump() throws where a text is not UTF-8.
#include <gtest/gtest.h>

#include "tests/support/product_files.hpp"

namespace {

namespace test = sightline::test;

TEST(Json, IsWrittenByOneFunctionAlone) {
  for (const auto& file : test::product_files()) {
    if (file == test::tree / "src/sightline/base/json_text.hpp") continue;
    EXPECT_EQ(test::without_comments(test::text_of(file)).find(".dump("), std::string::npos) << file;
  }
}

}  // namespace
