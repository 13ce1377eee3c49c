#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <ctime>
#include <numbers>

#include "sightline/formula.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/error.hpp"
#include "tests/support/formula_text.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

const Vocabulary vocabulary = small_vocabulary();
constexpr std::array<double, small_vocabulary_size> vocabulary_point = {0.3, -0.7, 1.1, 2.0};

double value(std::string_view text) {
  return parse_formula(text, vocabulary)(std::span<const double>(vocabulary_point), 0.0);
}

std::string formula_refusal(std::string_view text) {
  return refusal_of<FormulaError>([&] { parse_formula(text, vocabulary); });
}
std::string limit_refusal(std::string_view text) {
  return refusal_of<FormulaError>([&] { parse_limits(text, vocabulary); });
}

TEST(Parse, OperatorsBindAsOnPaper) {
  EXPECT_DOUBLE_EQ(value("1 + 2 * 3 ^ 2"), 19);
  EXPECT_DOUBLE_EQ(value("8 - 3 - 2"), 3);
  EXPECT_DOUBLE_EQ(value("8 / 4 / 2"), 1);
  EXPECT_DOUBLE_EQ(value("2 ^ 3 ^ 2"), 512);
  EXPECT_DOUBLE_EQ(value("-2 ^ 2"), -4);
  EXPECT_DOUBLE_EQ(value("2 ^ -1"), 0.5);
  EXPECT_DOUBLE_EQ(value("--2 - -3"), 5);
  EXPECT_DOUBLE_EQ(value("(1 + 2) * 3"), 9);
}

TEST(Parse, EveryFunctionIsTheOneOfItsName) {
  const double x = vocabulary_point[0], y = vocabulary_point[1], z = vocabulary_point[2];
  EXPECT_NEAR(value("sqrt(z)"), std::sqrt(z), 1e-15);
  EXPECT_NEAR(value("abs(y)"), 0.7, 1e-15);
  EXPECT_NEAR(value("min(x, y, z)"), y, 1e-15);
  EXPECT_NEAR(value("max(x, y, z)"), z, 1e-15);
  EXPECT_NEAR(value("sin(x / 1 m)"), std::sin(x), 1e-15);
  EXPECT_NEAR(value("cos(x / 1 m)"), std::cos(x), 1e-15);
  EXPECT_NEAR(value("tan(x / 1 m)"), std::tan(x), 1e-15);
  EXPECT_NEAR(value("atan2(y, x)"), std::atan2(y, x), 1e-15);
  EXPECT_NEAR(value("exp(x / 1 m)"), std::exp(x), 1e-15);
  EXPECT_NEAR(value("log(z / 1 m)"), std::log(z), 1e-15);
  EXPECT_NEAR(value("norm(x, y, z)"), std::hypot(x, y, z), 1e-15);
  EXPECT_NEAR(value("hypot(x, y)"), std::hypot(x, y), 1e-15);
  EXPECT_NEAR(value("range"), std::hypot(x, y, z), 1e-15);
  EXPECT_NEAR(value("z ^ 1.5"), std::pow(z, 1.5), 1e-14);
  EXPECT_NEAR(value("(z / 1 m) ^ 0.3"), std::pow(z, 0.3), 1e-14);
  EXPECT_EQ(value("pi"), std::numbers::pi);
}

TEST(Parse, UnitsScaleNumbersAndBindBeforeOperators) {
  EXPECT_DOUBLE_EQ(value("180 deg"), std::numbers::pi);
  EXPECT_DOUBLE_EQ(value("250 cm + 1 m"), 3.5);
  EXPECT_DOUBLE_EQ(value("2 m/s * 500 ms"), 1.0);
  EXPECT_DOUBLE_EQ(value("3 cm^2 / 1 m^2"), 3e-4);
  EXPECT_DOUBLE_EQ(value("4/s"), 4.0);
  EXPECT_DOUBLE_EQ(value("4 / k"), 8.0);
  EXPECT_EQ(parse_formula("9 m/s^2", vocabulary).unit(), units::velocity / units::time);
  EXPECT_EQ(parse_formula("sqrt(x * y)", vocabulary).unit(), units::length);
  EXPECT_EQ(parse_formula("range / t", vocabulary).unit(), units::velocity);
  EXPECT_EQ(parse_formula("atan2(y, x)", vocabulary).unit(), units::none);
  EXPECT_FALSE(parse_formula("k * x", vocabulary).unit()) << "a number without a unit leaves it open";
}

TEST(Parse, UnitsThatDoNotFitAreRefusedWhereTheyMeet) {
  const std::string both = ", expected the same unit on both sides";
  EXPECT_EQ(formula_refusal("x + t"), "1:3: \"+\" joins m with s" + both);
  EXPECT_EQ(limit_refusal("range < 4 s"), "1:7: \"<\" joins m with s" + both);
  EXPECT_EQ(formula_refusal("norm(x, t)"), "1:1: \"norm\" joins m with s" + both);
  EXPECT_EQ(formula_refusal("2 + sin(x)"),
            "1:9: the argument of sin has the unit m, expected a plain number or an angle");
  EXPECT_EQ(formula_refusal("x ^ y"),
            "1:5: the exponent has the unit m, expected a plain number or an angle");
  EXPECT_EQ(formula_refusal("x ^ 0.3"),
            "1:5: the power 0.3 of m has no unit, expected a whole or half power");
  for (const char* text : {"x + 1", "2 * x + t * k", "sin(k * x)", "atan2(x, 3)", "max(x, 0)"}) {
    EXPECT_EQ(formula_refusal(text), "") << text;
  }
}

TEST(Parse, ALimitIsNotAboveZeroExactlyWhereItHolds) {
  const auto c = [](std::string_view text) {
    std::vector<double> list;
    for (const Expression& e : parse_limits(text, vocabulary))
      list.push_back(e(std::span<const double>(vocabulary_point), 0.0));
    return list;
  };
  EXPECT_EQ(c("x < 1 m"), std::vector<double>{0.3 - 1});
  EXPECT_EQ(c("x > 1 m"), std::vector<double>{1 - 0.3});
  EXPECT_EQ(c("x <= 1 m"), c("1 m >= x"));
  EXPECT_EQ(c("0 < x < 1 < z"), (std::vector<double>{0 - 0.3, 0.3 - 1, 1 - 1.1}));
  EXPECT_EQ(c("2 > x > y"), (std::vector<double>{0.3 - 2, -0.7 - 0.3}));
}

TEST(Parse, WhatIsNoFormulaIsRefusedAtTheToken) {
  EXPECT_EQ(formula_refusal("rnge + 1"),
            "1:1: \"rnge\" is unknown, expected a known name, the nearest is \"range\"");
  EXPECT_EQ(formula_refusal("1 + (x * 2"), "1:5: \"(\" is never closed, expected \")\"");
  EXPECT_EQ(formula_refusal("x) + 1"), "1:2: \")\" closes no bracket, expected an operator or the end");
  EXPECT_EQ(formula_refusal(""), "1:1: the end comes too early, expected a number, a name or \"(\"");
  EXPECT_EQ(formula_refusal("2 x"), "1:3: \"x\" after a number, expected an operator, as in 2 * x");
  EXPECT_EQ(formula_refusal("2 ft"),
            "1:3: \"ft\" after a number, expected a unit, one of m, cm, mm, km, rad, deg, s, ms, Hz");
  EXPECT_EQ(formula_refusal("x y"), "1:3: \"y\" comes too early, expected an operator or the end");
  EXPECT_EQ(formula_refusal("x < 2"), "1:3: \"<\" compares, expected a formula of one value here");
  EXPECT_EQ(formula_refusal("(x < 2) + 1"), "1:4: \"<\" within brackets, expected an operator or \")\"");
  EXPECT_EQ(formula_refusal("sin"), "1:1: \"sin\" is a function, expected its arguments in brackets");
  EXPECT_EQ(formula_refusal("x(2)"), "1:1: \"x\" is no function, expected an operator after it");
  EXPECT_EQ(formula_refusal("x * m"), "1:5: \"m\" is a unit, expected a number before it");
  EXPECT_EQ(formula_refusal("atan2(x)"), "1:1: atan2 has 1 argument, expected 2");
  EXPECT_EQ(formula_refusal("min(x)"), "1:1: min has 1 argument, expected 2 to 16");
  EXPECT_EQ(formula_refusal("2 m^x"), "1:5: \"x\" is no power of a unit, expected a whole number up to 8");
  EXPECT_EQ(limit_refusal("x + 1"), "1:6: the end comes too early, expected a comparison, one of < <= > >=");
  EXPECT_EQ(limit_refusal("0 < x > 1"), "1:7: \">\" turns the chain round, expected < again");
}

TEST(Parse, ConstantsThatAreNotFiniteAreRefused) {
  EXPECT_EQ(formula_refusal("x / 0"), "1:5: division by zero, expected a divisor that is not 0");
  EXPECT_EQ(formula_refusal("(1 - 1)^-1"), "1:1: division by zero, expected a base that is not 0");
  EXPECT_EQ(formula_refusal("x + sqrt(-1)"),
            "1:5: \"sqrt\" gives no finite number, expected a finite constant");
  EXPECT_EQ(formula_refusal("1e200 * 1e200"),
            "1:7: \"*\" gives no finite number, expected a finite constant");
}

TEST(Parse, DepthLengthAndNumberOfOperationsAreBounded) {
  const auto nested = [](std::size_t n) {
    return fmt::format("{}x{}", std::string(n, '('), std::string(n, ')'));
  };
  EXPECT_EQ(formula_refusal(nested(formula_depth_max)), "");
  EXPECT_EQ(formula_refusal(nested(10'000)),
            "1:101: brackets and powers are nested deeper than 100, expected fewer");
  std::string powers = "x";
  for (int i = 0; i < 10'000; ++i) powers += "^k";
  EXPECT_NE(formula_refusal(powers).find("nested deeper than 100"), std::string::npos);
  EXPECT_EQ(formula_refusal(fmt::format("{}x", std::string(50'000, '-'))), "") << "signs are no nesting";
  std::string sum = "k";
  for (int i = 0; i < 2'000; ++i) sum += fmt::format("+sin({}*k*x)", i);
  EXPECT_NE(formula_refusal(sum).find("more than 1000 operations by here"), std::string::npos);
}

TEST(Parse, AFormulaThatIsReadIsTheSameOnNumbersAndInAGraph) {
  Random random(1);
  int read = 0;
  for (int k = 0; k < 3000; ++k) {
    const std::string text = formula_text(random, 4);
    if (!formula_refusal(text).empty()) continue;
    const Expression e = parse_formula(text, vocabulary);
    const double expected = e(std::span<const double>(vocabulary_point), 1e-3);
    if (!(std::fabs(expected) < 1e6)) continue;
    Graph graph;
    const std::vector<Symbol> symbols = variables(graph, 0, small_vocabulary_size);
    const Program program(graph, std::vector{e(std::span<const Symbol>(symbols), 1e-3).in(graph)},
                          small_vocabulary_size);
    // Constants are gathered on the way, which moves the last digits of large parts that cancel.
    EXPECT_LE(relative_error(evaluate(program, vocabulary_point)[0], expected), 1e-6) << text;
    ++read;
  }
  EXPECT_GT(read, 500);
}

TEST(Parse, AnyTextIsReadOrRefusedWithinItselfAtOnce) {
  Random random(20181121);
  const int texts = runs(1'000'000, 20);
  int read = 0;
  std::clock_t longest = 0;
  for (int k = 0; k < texts; ++k) {
    const std::string text = hostile_text(random);
    const std::clock_t begin = std::clock();
    try {
      for (const Expression& c : parse_limits(text, vocabulary))
        c(std::span<const double>(vocabulary_point), 1e-3);
      ++read;
    } catch (const FormulaError& error) {
      ASSERT_LE(error.offset(), text.size()) << text;
      ASSERT_NE(error.sentence().find("expected"), std::string::npos) << error.what();
    }
    longest = std::max(longest, std::clock() - begin);
  }
  EXPECT_GT(read, texts / 100);
  EXPECT_LT(static_cast<double>(longest) / CLOCKS_PER_SEC, 0.1) << "of the processor, for the slowest text";
}

TEST(Parse, CornersAreToldByTheFunctionThatHasThem) {
  EXPECT_EQ(parse_formula("abs(x) + max(x, y)", vocabulary).smoothed(),
            (std::set<std::string>{"abs", "max"}));
  EXPECT_EQ(parse_formula("range", vocabulary).smoothed(), std::set<std::string>{"norm"});
  EXPECT_TRUE(parse_formula("sin(k * x)", vocabulary).smoothed().empty());
}

TEST(Define, DefinitionsMayUseEachOtherInAnyOrder) {
  Vocabulary words = vocabulary;
  define(words, std::vector<Definition>{{"a", "b + c"}, {"b", "2 * c"}, {"c", "x^2"}});
  EXPECT_DOUBLE_EQ(parse_formula("a", words)(std::span<const double>(vocabulary_point), 0.0), 3 * 0.09);
}

TEST(Define, WhatNeedsItselfIsRefusedInTheCircle) {
  const auto said = [](const std::vector<Definition>& definitions) {
    Vocabulary words = vocabulary;
    try {
      define(words, definitions);
    } catch (const FormulaError& error) {
      return error.definition() + " " + error.what();
    }
    return std::string("not refused");
  };
  EXPECT_EQ(said({{"a", "1 + a"}}),
            "a 1:5: \"a\" needs itself through \"a\", expected parameters that end in numbers");
  const std::string circle = said({{"outside", "1 + b"}, {"b", "2 * c"}, {"c", "x + b"}, {"d", "1"}});
  EXPECT_TRUE(circle.starts_with("b 1:5: \"b\" needs itself through \"c\"") ||
              circle.starts_with("c 1:5: \"c\" needs itself through \"b\""))
      << circle;
  EXPECT_EQ(said({{"a", "1 +"}}), "a 1:4: the end comes too early, expected a number, a name or \"(\"");
}

TEST(Define, NamesThatAreTakenAreNotFree) {
  for (const char* name : {"sin", "m", "pi", "a.b", "1a", ""}) EXPECT_FALSE(is_free_name(name)) << name;
  for (const char* name : {"alpha", "d_max", "x"}) EXPECT_TRUE(is_free_name(name)) << name;
}

}  // namespace
}  // namespace sightline
