#include <gtest/gtest.h>

#include "sightline/formula.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

std::string tokens(std::string_view text) {
  std::string all;
  for (Lexer lexer(text); lexer.token().kind != TokenKind::end;) all += std::string(lexer.take().text) + "|";
  return all;
}

std::string lexer_refusal(std::string_view text) {
  return refusal_of<FormulaError>([&] { tokens(text); });
}

TEST(Lexer, TokensAreTakenWholeAndBlanksAreNone) {
  EXPECT_EQ(tokens(" a1 <=2.5e-3*target.p_x\n^ -.5"), "a1|<=|2.5e-3|*|target.p_x|^|-|.5|");
  EXPECT_EQ(tokens("<<= >=>"), "<|<=|>=|>|");
  EXPECT_EQ(tokens(""), "");
}

TEST(Lexer, WhatIsNoTokenIsRefusedAtItsLineAndColumn) {
  EXPECT_EQ(lexer_refusal("x +\n  é"),
            "2:3: \"é\" has no meaning here, expected numbers, names and the signs + - * / ^ "
            "( ) , < <= > >=");
  EXPECT_EQ(lexer_refusal("x == 1"),
            "1:3: \"=\" has no meaning here, expected a comparison, one of < <= > >=");
  EXPECT_EQ(lexer_refusal("x < 1e999"),
            "1:5: \"1e999\" is beyond what a number can be, expected a finite constant");
  EXPECT_EQ(lexer_refusal(std::string(1'000'000, 'x')),
            "1:1: the formula has 1000000 bytes, expected at most 100000");
}

TEST(Lexer, ColumnsCountCharactersAndNotBytes) {
  const FormulaError error("éé\nöx", 7, "bad");
  EXPECT_STREQ(error.what(), "2:2: bad");
  EXPECT_EQ(error.offset(), 7U);
  EXPECT_EQ(error.sentence(), "bad");
}

}  // namespace
}  // namespace sightline
