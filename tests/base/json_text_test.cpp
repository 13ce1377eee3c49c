#include "sightline/base/json_text.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sightline {
namespace {

TEST(JsonText, BytesThatAreNoUtf8AreReplaced) {
  EXPECT_EQ(json_text(nlohmann::json{{"name", "bad\xff"}}), "{\"name\":\"bad\xef\xbf\xbd\"}");
  EXPECT_EQ(json_text(nlohmann::ordered_json{{"b", 1}, {"a", "\xc3\xa4"}}, 2),
            "{\n  \"b\": 1,\n  \"a\": \"\xc3\xa4\"\n}");
}

}  // namespace
}  // namespace sightline
