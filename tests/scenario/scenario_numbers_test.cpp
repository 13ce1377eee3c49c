#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "sightline/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"
#include "tests/support/command.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using Changes = std::vector<std::pair<NumberInText, double>>;

ScenarioNumbers numbers(const std::string& text) { return numbers_of(parse_toml(text, "a")); }

TEST(ScenarioNumbers, EachNumberIsFoundUnderTheKeyThatRefusalsName) {
  const std::string text =
      "a = 1.5  # µ, 7.0\n[x.y]\nlist = [ 1, [-2e-3, 0x10], {z = +3.0} ]\n\"µ\" = { q = 1_000.0, name = "
      "\"5.0\" }\n"
      "[[row]]\nv = 4\n[[row]]\nv = 5.25\n";
  const ScenarioNumbers found = numbers(text);
  std::vector<std::string> keys;
  for (const auto& [key, number] : found)
    keys.push_back(fmt::format("{} {} {}", key, text.substr(number.offset, number.size), number.value));
  EXPECT_THAT(keys,
              testing::UnorderedElementsAre("a 1.5 1.5", "x.y.list[0] 1 1", "x.y.list[1][0] -2e-3 -0.002",
                                            "x.y.list[1][1] 0x10 16", "x.y.list[2].z +3.0 3",
                                            "x.y.µ.q 1_000.0 1000", "row[0].v 4 4", "row[1].v 5.25 5.25"));
}

TEST(ScenarioNumbers, WhatIsWrittenIsReadBackBitForBitAndAllElseStays) {
  const std::string text = "a = 1.5 # one\nb = { c = [2.0, 3.0], d = 4.0 }\ne = 5\n";
  const ScenarioNumbers before = numbers(text);
  Random random(3);
  for (int trial = 0; trial < 2000; ++trial) {
    Changes changes;
    for (const char* key : {"e", "a", "b.c[1]"}) {
      double value = random_finite(random);
      changes.emplace_back(before.at(key), value);
    }
    const std::string after = with_numbers(text, changes);
    const ScenarioNumbers read = numbers(after);
    EXPECT_EQ(read.at("e").value, changes[0].second);
    EXPECT_EQ(read.at("a").value, changes[1].second);
    EXPECT_EQ(read.at("b.c[1]").value, changes[2].second);
    EXPECT_EQ(read.at("b.c[0]").value, 2.0);
    EXPECT_EQ(read.at("b.d").value, 4.0);
    // Put back, the text is the old one but for how its numbers are written.
    Changes back;
    for (const auto& [key, number] : before) back.emplace_back(read.at(key), number.value);
    EXPECT_EQ(with_numbers(after, back), "a = 1.5 # one\nb = { c = [2, 3], d = 4 }\ne = 5\n");
  }
  EXPECT_EQ(with_numbers(text, Changes{}), text);
}

TEST(ScenarioNumbers, OfEachShippedScenarioEveryNumberCanBeWrittenOver) {
  for (const auto& entry : std::filesystem::directory_iterator(SIGHTLINE_SOURCE_DIR "/scenarios")) {
    if (entry.path().extension() != ".toml") continue;
    const std::string text = test::read_file(entry.path());
    Changes same;
    for (const auto& [key, number] : numbers(text)) same.emplace_back(number, number.value);
    EXPECT_GT(same.size(), 20U) << entry.path();
    const ScenarioNumbers again = numbers(with_numbers(text, same));
    std::size_t i = 0;
    for (const auto& [key, number] : again) EXPECT_EQ(number.value, same[i++].second) << key;
  }
}

TEST(ScenarioNumbers, SpacesForASectionLeaveAllElseWhereItIs) {
  for (const auto& entry : std::filesystem::directory_iterator(SIGHTLINE_SOURCE_DIR "/scenarios")) {
    if (entry.path().extension() != ".toml") continue;
    const std::string text = test::read_file(entry.path());
    const TomlDocument document = parse_toml(text, "a");
    for (const std::string section : {"campaign", "couple", "agent", "no_section"}) {
      const std::string left = with_spaces_for(section, document);
      ScenarioNumbers rest;
      for (const auto& [key, number] : numbers(text)) {
        if (!key.starts_with(section + ".") && !key.starts_with(section + "[")) rest.emplace(key, number);
      }
      const ScenarioNumbers found = numbers(left);
      ASSERT_EQ(found.size(), rest.size()) << entry.path() << ' ' << section;
      for (const auto& [key, number] : found) {
        EXPECT_EQ(number.offset, rest.at(key).offset) << key;
        EXPECT_EQ(number.size, rest.at(key).size) << key;
      }
      EXPECT_FALSE(parse_toml(left, "a").root.contains(section)) << entry.path() << ' ' << section;
    }
  }
}

}  // namespace
}  // namespace sightline
