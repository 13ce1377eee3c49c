// A million hostile texts through the reader of formulas.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <string_view>

#include "tests/support/formula_text.hpp"

namespace sightline {
namespace {

TEST(ParseCampaign, AMillionTextsAreReadOrRefusedAtOnce) {
  const char* const form = std::getenv("SIGHTLINE_CAMPAIGN");
  const int texts = form != nullptr && std::string_view(form) == "whole" ? 1'000'000 : 50'000;
  const Vocabulary names = small_vocabulary();
  const std::array<double, small_vocabulary_size> point = {0.3, -0.7, 1.1, 2.0};
  Random random(20181121);
  int read = 0;
  std::clock_t longest = 0;
  for (int k = 0; k < texts; ++k) {
    const std::string text = hostile_text(random);
    const std::clock_t begin = std::clock();
    try {
      for (const Expression& c : parse_limits(text, names)) c(std::span<const double>(point), 1e-3);
      ++read;
    } catch (const FormulaError& error) {
      ASSERT_LE(error.offset(), text.size()) << text;
    }
    longest = std::max(longest, std::clock() - begin);
  }
  EXPECT_GT(read, texts / 100);
  EXPECT_LT(static_cast<double>(longest) / CLOCKS_PER_SEC, 0.1) << "of the processor, for the slowest text";
}

}  // namespace
}  // namespace sightline
