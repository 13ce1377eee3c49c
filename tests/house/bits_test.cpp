/// What would give a machine or a compiler bits of its own.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/tree.hpp"

namespace {

using sightline::test::tree;
namespace fs = std::filesystem;

/// Functions of <cmath> that round, and gave the same bits on x86-64 and AArch64 in all arguments that
/// scripts/arm64.sh tries (tests/support/c_library_bits.cpp). The others are not called.
const std::set<std::string> agreed = {"sin",   "cos", "tan", "asin", "acos", "atan",
                                      "atan2", "exp", "log", "pow",  "log1p"};
const std::regex rounds(
    "(?:std)?::(a?(?:sin|cos|tan)h?|atan2|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot|erfc?|[lt]gamma|"
    "lerp|"
    "beta|legendre|riemann_zeta|(?:cyl|sph)_\\w+)\\s*\\(");

/// Code without comments and strings.
std::string code_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  static const std::regex aside(R"re("(?:\\.|[^"\\\n])*"|//[^\n]*)re");
  return std::regex_replace(text.str(), aside, "\"\"");
}

std::vector<std::string> refused_in(const std::string& code) {
  std::vector<std::string> names;
  for (auto call = std::sregex_iterator(code.begin(), code.end(), rounds); call != std::sregex_iterator();
       ++call) {
    if (!agreed.contains((*call)[1])) names.push_back((*call)[1]);
  }
  return names;
}

TEST(Bits, the_rule_knows_calls_of_functions_whose_bits_differ) {
  EXPECT_EQ(refused_in("a = std::hypot(x, y) + std::sin(x);"), std::vector<std::string>{"hypot"});
  EXPECT_EQ(refused_in("::tanh (x)"), std::vector<std::string>{"tanh"});
  EXPECT_EQ(refused_in("sightline::norm(x, y) + std::remainder(x, y) + std::sqrt(x)"),
            std::vector<std::string>{});
}

TEST(Bits, the_library_calls_no_function_whose_bits_are_the_machines_own) {
  int files = 0;
  for (const char* folder : {"src", "cli", "worlds"}) {
    for (const auto& entry : fs::recursive_directory_iterator(tree / folder)) {
      const fs::path extension = entry.path().extension();
      if (extension != ".hpp" && extension != ".cpp") continue;
      ++files;
      for (const std::string& name : refused_in(code_of(entry.path())))
        ADD_FAILURE()
            << fs::relative(entry.path(), tree).string() << " calls " << name
            << " of the C library, expected one of ours (math/elementary.hpp, norm of math/fixed.hpp)";
    }
  }
  EXPECT_GT(files, 100);
}

}  // namespace
