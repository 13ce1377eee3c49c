#include "sightline/scenario/toml_table.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

/// What is said when `read` refuses the text.
template <class Read>
std::string table_refusal(const std::string& text, Read&& read) {
  return refusal_of<ScenarioError>([&] {
    const TomlDocument document = parse_toml(text, "a");
    read(TomlTable(document));
  });
}

TEST(TomlTable, KeysThatMakeDeepTablesAreRefusedBeforeTheParserSeesThem) {
  std::string text = "a";
  for (int i = 0; i < 1'000'000; ++i) text += ".a";
  EXPECT_EQ(table_refusal(text + " = 1\n", [](const TomlTable&) {}),
            "a:1: the key has too many parts, expected at most 16");
}

TEST(TomlTable, TheDeepestTablesLetThroughCanBeParsed) {
  std::string key = "a", text;
  for (int i = 1; i < key_parts_max; ++i) key += ".a";
  for (int i = 0; i < 250; ++i) text += key + " = { ";
  text += "a = 1";
  for (int i = 0; i < 250; ++i) text += " }";
  EXPECT_EQ(table_refusal(text + "\n", [](const TomlTable&) {}), "");
  EXPECT_NE(table_refusal(text + " }\n", [](const TomlTable&) {}), "");
}

TEST(TomlTable, AWrongValueIsSaidWithPlaceLineAndExpectation) {
  const std::string text = "[t]\nx = \"5\"\ny = [1,\n 2, nan]\nz = 7\n[[l]]\n[[l]]\nw = true\n";
  const auto say = [&](auto&& read) { return table_refusal(text, read); };
  EXPECT_EQ(say([](const TomlTable& r) { r.table("t").number("x", positive("> 0 m")); }),
            "a:2: t.x = \"5\", expected a number, > 0 m");
  EXPECT_EQ(say([](const TomlTable& r) { r.table("t").numbers("y", 3); }),
            "a:4: t.y[2] = nan, expected finite, at most 1e9 either way");
  EXPECT_EQ(say([](const TomlTable& r) { r.table("t").numbers("y", 2); }),
            "a:3: t.y = [1, 2, nan], expected an array of 2 numbers");
  EXPECT_EQ(say([](const TomlTable& r) { r.table("t").integer("z", 1, 6); }),
            "a:5: t.z = 7, expected an integer, 1 to 6");
  EXPECT_EQ(say([](const TomlTable& r) { r.tables("l")[1].text("w", "a name"); }),
            "a:8: l[1].w = true, expected a name");
  EXPECT_EQ(say([](const TomlTable& r) { r.tables("l")[0].text("w", "a name"); }),
            "a:6: l[0].w is missing, expected a name");
  EXPECT_EQ(say([](const TomlTable& r) { r.tables("t"); }), "a:1: t = {...}, expected tables under [[t]]");
  EXPECT_EQ(say([](const TomlTable& r) { r.table("l"); }), "a:6: l = [{}, {...}], expected a table");
  EXPECT_EQ(say([](const TomlTable& r) { r.table("t").table_or_empty("u").number("v"); }),
            "a:1: t.u.v is missing, expected a number, finite, at most 1e9 either way");
}

TEST(TomlTable, AnUnknownKeyIsSaidWithTheNearest) {
  EXPECT_EQ(table_refusal("[t]\n\nzetta = 1\n",
                          [](const TomlTable& r) {
                            r.table("t").expect_only({"k_max", "zeta"});
                          }),
            "a:3: t.zetta = 1, expected a known key, the nearest is \"zeta\"");
}

TEST(TomlTable, WhereNoKeyIsKnownNoneIsTheNearest) {
  EXPECT_EQ(table_refusal("[t]\nx = 1\n", [](const TomlTable& r) { r.table("t").expect_only({}); }),
            "a:2: t.x = 1, expected no key here");
}

TEST(TomlTable, MessagesAreShortWhateverTheValue) {
  const std::string huge(1'000'000, 'x');
  const auto length = [](const std::string& text, std::string_view key) {
    return table_refusal(text, [&](const TomlTable& r) { r.number(key); }).size();
  };
  EXPECT_LT(length("k = \"" + huge + "\"\n", "k"), 200U);
  EXPECT_LT(length(huge + " = true\n", huge), 200U);
  std::string array = "k = [1";
  for (int i = 0; i < 100'000; ++i) array += ", 1";
  EXPECT_LT(length(array + "]\n", "k"), 200U);
  EXPECT_LT(table_refusal(huge + " = 1\n", [](const TomlTable& r) { r.expect_only({"a"}); }).size(), 200U);
}

TEST(TomlTable, NamedTablesComeInTheOrderOfTheFile) {
  const TomlDocument document = parse_toml("[n.zz]\n[n.b.c]\n[n.a]\n[n.b]\n", "a");
  std::string order;
  for (const auto& [name, table] : TomlTable(document).named_tables("n"))
    order += name + " " + table.path() + ",";
  EXPECT_EQ(order, "zz n.zz,b n.b,a n.a,");
}

TEST(TomlTable, ASentenceAboutAFieldGetsTheLineOfItsKey) {
  const auto say = [](const char* sentence) {
    return table_refusal("[t]\nx = 1\ny = 2\n", [&](const TomlTable& r) {
      r.table("t").checked([&] { throw std::invalid_argument(sentence); });
    });
  };
  EXPECT_EQ(say("potential.y = 2, expected 3"), "a:3: t.y = 2, expected 3");
  EXPECT_EQ(say("potential.z = 2, expected 3"), "a:1: t: potential.z = 2, expected 3");
  EXPECT_EQ(say("nobody feels it."), "a:1: t: nobody feels it.");
}

}  // namespace
}  // namespace sightline
