#include "sightline/scenario/string_place.hpp"

#include <gtest/gtest.h>
#include <toml++/toml.h>

#include <string>

namespace sightline {
namespace {

/// The place of the first `token` of the string under `text`.
TextPlace place_of(const std::string& document, std::string_view token) {
  const toml::table root = toml::parse(document);
  const auto& node = *root["text"].as_string();
  const auto quote = node.source().begin;
  return place_in_string(document, {quote.line, quote.column}, node.get(), node.get().find(token));
}

TEST(PlaceInString, OfEachKindOfStringIsTheOneInTheFile) {
  EXPECT_EQ(place_of("text = \"ab HERE\"", "HERE"), (TextPlace{1, 12}));
  EXPECT_EQ(place_of("\ntext = 'ab HERE'", "HERE"), (TextPlace{2, 12}));
  EXPECT_EQ(place_of("text = \"\"\"\nab\n  HERE\"\"\"", "HERE"), (TextPlace{3, 3}));
  EXPECT_EQ(place_of("text = \"\"\"ab HERE\"\"\"", "HERE"), (TextPlace{1, 14}));
  EXPECT_EQ(place_of("text = '''\nab\\\n HERE'''", "HERE"), (TextPlace{3, 2}));
}

TEST(PlaceInString, EscapesAndCharactersOfSeveralBytesCountAsTheyAreWritten) {
  EXPECT_EQ(place_of("text = \"\\t\\\"\\u00e9HERE\"", "HERE"), (TextPlace{1, 19}));
  EXPECT_EQ(place_of("text = \"\\U0001F600HERE\"", "HERE"), (TextPlace{1, 19}));
  EXPECT_EQ(place_of("text = \"éé HERE\"", "HERE"), (TextPlace{1, 12}));
  EXPECT_EQ(place_of("\"é\" = 1\n\"ö\" = 2\ntext = \"HERE\"", "HERE"), (TextPlace{3, 9}));
  EXPECT_EQ(place_of("a = { \"é\" = 1 }\nb = 'é'\ntext = 'é HERE'", "HERE"), (TextPlace{3, 11}));
}

TEST(PlaceInString, ALineThatGoesOnIsSeenThrough) {
  EXPECT_EQ(place_of("text = \"\"\"ab \\\n\n   HERE\"\"\"", "HERE"), (TextPlace{3, 4}));
}

TEST(PlaceInString, LinesMayEndAsOnOtherSystems) {
  EXPECT_EQ(place_of("a = 1\r\ntext = \"\"\"\r\nab\r\n HERE\"\"\"", "HERE"), (TextPlace{4, 2}));
}

TEST(PlaceInString, TheEndOfTheContentIsTheClosingQuote) {
  EXPECT_EQ(place_in_string("t = \"ab\"", {1, 5}, "ab", 2), (TextPlace{1, 8}));
}

TEST(PlaceInString, WhatIsNoStringKeepsItsPlace) {
  EXPECT_EQ(place_in_string("t = 4.0", {1, 5}, "", 0), (TextPlace{1, 5}));
  EXPECT_EQ(place_in_string("t = 4.0", {7, 5}, "abc", 1), (TextPlace{7, 5}));
  EXPECT_EQ(place_in_string("", {1, 1}, "abc", 1), (TextPlace{1, 1}));
}

}  // namespace
}  // namespace sightline
