#include <gtest/gtest.h>

#include <map>
#include <stdexcept>

#include "sightline/base.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

enum class Form { round, square };

struct Part {
  double length = 1.5;
  std::optional<double> angle{};
  std::array<double, 3> corner = {1, 2, 3};
  int place = 0;
  Form form = Form::round;

  static constexpr std::string_view name = "part";
  static constexpr auto parameters() {
    constexpr Bounds few = {0, 3, "0 to 3"};
    constexpr std::array<std::string_view, 2> forms = {"round", "square"};
    return std::tuple{parameter("length", &Part::length, "m", above_zero, "how long"),
                      parameter("angle", &Part::angle, "rad", any_finite, "left out: free"),
                      needed(parameter("corner", &Part::corner, "m", any_finite, "where")),
                      parameter("place", &Part::place, "", few, "which"),
                      parameter("form", &Part::form, forms, "how it looks")};
  }
};

struct Path {
  std::vector<double> times{}, heading{};
  static constexpr std::string_view name = "path";
  static constexpr auto parameters() {
    return Parameters{ListParameter<Path, double>{"times", &Path::times, "s", "when", true}} +
           Parameters{ListParameter<Path, double>{"heading", &Path::heading, "rad", "", false, false}};
  }
};

struct Lamp {
  double power = 10;
  [[maybe_unused]] static constexpr std::string_view name = "lamp";
  static constexpr auto parameters() {
    return Parameters{parameter("power", &Lamp::power, "W", from_zero, "of its light")};
  }
  static constexpr auto presets() {
    return std::array{Preset<Lamp>{"dim", {1}}, Preset<Lamp>{"bright", {99}}};
  }
};

/// What a program gives, by key.
class Given final : public ParameterSource {
 public:
  std::map<std::string, std::vector<double>, std::less<>> values;
  mutable std::vector<std::string> allowed;

  bool has(std::string_view key) const override { return values.contains(key); }
  void expect_only(std::span<const std::string_view> keys) const override {
    allowed.assign(keys.begin(), keys.end());
  }
  double number(std::string_view key, const Bounds& bounds, std::string_view unit) const override {
    const double v = numbers(key, 1, bounds, unit)[0];
    if (!bounds.hold(v)) refuse_parameter("given", key, v, bounds.expected(unit));
    return v;
  }
  int integer(std::string_view key, const Bounds& bounds) const override {
    return static_cast<int>(number(key, bounds, ""));
  }
  std::vector<double> numbers(std::string_view key, std::size_t length, const Bounds&,
                              std::string_view) const override {
    const auto found = values.find(key);
    if (found == values.end() || (length != any_length && found->second.size() != length))
      throw_invalid(std::string(key) + " of another length");
    return found->second;
  }
  std::vector<double> rising(std::string_view key) const override {
    return numbers(key, any_length, any_finite, "");
  }
  std::vector<std::vector<double>> rows(std::string_view, std::size_t, std::size_t) const override {
    return {};
  }
  std::size_t word(std::string_view key, std::span<const std::string_view>) const override {
    return static_cast<std::size_t>(numbers(key, 1, any_finite, "")[0]);
  }
  [[noreturn]] void throw_invalid(std::string_view sentence) const override {
    throw std::invalid_argument(std::string(sentence));
  }
};

TEST(Parameter, WhatIsGivenIsSetAndWhatIsLeftOutIsTheStructsOwn) {
  Given given;
  given.values = {{"corner", {4, 5, 6}}, {"angle", {0.25}}, {"form", {1}}, {"place", {2}}};
  const Part part = read_part<Part>(given);
  EXPECT_EQ(part.length, 1.5);
  EXPECT_EQ(part.angle, 0.25);
  EXPECT_EQ(part.corner, (std::array<double, 3>{4, 5, 6}));
  EXPECT_EQ(part.place, 2);
  EXPECT_EQ(part.form, Form::square);
  EXPECT_EQ(given.allowed, (std::vector<std::string>{"length", "angle", "corner", "place", "form"}));
}

TEST(Parameter, WhatMustBeGivenIsMissed) {
  EXPECT_EQ(refusal_of([] { read_part<Part>(Given{}); }), "corner of another length");
}

TEST(Parameter, TheFirstListSaysHowLongTheOthersAre) {
  Given given;
  given.values = {{"times", {0, 1, 2}}, {"heading", {0, 1}}};
  EXPECT_EQ(refusal_of([&] { read_part<Path>(given); }), "heading of another length");
  given.values["heading"] = {0, 1, 2};
  EXPECT_EQ(read_part<Path>(given).heading, (std::vector<double>{0, 1, 2}));
}

TEST(Parameter, APresetIsTheStartForWhatIsGivenBesideIt) {
  Given given;
  given.values = {{"preset", {1}}};
  EXPECT_EQ(read_part<Lamp>(given).power, 99);
  given.values["power"] = {5};
  EXPECT_EQ(read_part<Lamp>(given).power, 5);
  EXPECT_EQ(given.allowed, (std::vector<std::string>{"power", "preset"}));
}

TEST(Parameter, ANumberOutOfItsRangeIsRefusedWithPartKeyValueAndRange) {
  EXPECT_EQ(refusal_of([] { check_parameters(Part{.length = 0}); }), "part.length = 0, expected > 0 m");
  EXPECT_EQ(refusal_of([] { check_parameters(Part{.angle = NAN}); }),
            "part.angle = nan, expected finite rad");
  EXPECT_EQ(refusal_of([] {
              check_parameters(Part{.corner = {0, INFINITY, 0}});
            }),
            "part.corner = inf, expected finite m");
  EXPECT_EQ(refusal_of([] { check_parameters(Part{.place = 4}); }), "part.place = 4, expected 0 to 3");
  EXPECT_EQ(refusal_of([] {
              check_parameters(Path{.times = {0, NAN}});
            }),
            "path.times = nan, expected finite s");
  EXPECT_EQ(refusal_of([] { check_parameters(Part{}); }), "");
}

TEST(Parameter, BoundsMayLeaveAGapAboveZero) {
  constexpr Bounds lag = {1e-3, 1e3, "0 or 0.001 to 1000", true};
  EXPECT_TRUE(lag.hold(0) && lag.hold(1e-3) && lag.hold(1e3));
  EXPECT_FALSE(lag.hold(1e-4) || lag.hold(-1) || lag.hold(1e4) || lag.hold(NAN));
}

TEST(Parameter, WordsHaveKeyUnitRangeDefaultAndWhatDiffersFromIt) {
  const std::vector<ParameterText> texts = parameter_texts(Part{.length = 2, .form = Form::square});
  ASSERT_EQ(texts.size(), 5U);
  EXPECT_EQ(texts[0].key, "length");
  EXPECT_EQ(texts[0].unit, "m");
  EXPECT_EQ(texts[0].range, "> 0");
  EXPECT_EQ(texts[0].value, "2");
  EXPECT_EQ(texts[0].fallback, "1.5");
  EXPECT_EQ(texts[1].fallback, "");
  EXPECT_TRUE(texts[2].must_be_given);
  EXPECT_EQ(texts[2].value, "[1, 2, 3]");
  EXPECT_EQ(texts[4].range, "one of round, square");
  EXPECT_EQ(changed(texts), "length = 2 m, corner = [1, 2, 3] m, form = square");
  EXPECT_TRUE(parameter_texts(3.0).empty());
}

}  // namespace
}  // namespace sightline
