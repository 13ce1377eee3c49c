#include "sightline/server/tuning.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/page_client.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/tuned_flight.hpp"

namespace sightline {
namespace {

using nlohmann::json;
using test::eventually;
using test::PageClient;
using testing::HasSubstr;

/// A flight that is tuned, without the flight.
struct Tuned {
  explicit Tuned(bool waits = true)
      : scenario(test::scenario_of(test::tuned_scenario(2.0))),
        tuning((scenario.tuned = std::make_shared<TunedScript>(), scenario),
               {.clock = waits ? &clock : nullptr,
                .restart = waits ? std::function<void(std::uint64_t)>([this](std::uint64_t to) { seed = to; })
                                 : std::function<void(std::uint64_t)>()}) {}

  /// Says it. @return [number, id, accepted, sentence]
  json request(const std::string& message) {
    const std::size_t before = answered;
    tuning.receive(message);
    json all;
    EXPECT_TRUE(eventually([&] {
      all = json::parse("{\"t\":0" + tuning.reported() + "}")["answers"];
      return !all.empty() && all.back()[0] >= before;
    })) << message;
    ++answered;
    return all.empty() ? json() : all.back();
  }

  std::atomic<bool> stop{false};
  PacedClock clock{1.0, false, stop};
  std::atomic<std::uint64_t> seed{0};
  Scenario scenario;
  Tuning tuning;
  std::size_t answered = 0;
};

TEST(Tuning, AChangeIsAnsweredAndHandedToTheFlight) {
  Tuned tuned;
  const json answer =
      tuned.request(R"({"id":"a","event":{"retune":{"couple":"bearing","weight":0.4}},"ramp":0.3})");
  EXPECT_EQ(answer[1], "a");
  EXPECT_EQ(answer[2], true);
  EXPECT_THAT(answer[3].get<std::string>(), HasSubstr("retune bearing, weight 0.4"));
  ASSERT_EQ(tuned.scenario.tuned->size(), 1U);
  EXPECT_EQ(ramp_of(tuned.scenario.tuned->event(0)), 0.3);
  EXPECT_TRUE(eventually(
      [&] { return json::parse(tuned.tuning.files().at("/tune.json").body)["terms"][0]["weight"] == 0.4; }));
  // Not before it happened is it of the flight that is written, which says so from the answer on.
  EXPECT_THAT(
      tuned.tuning.files().at("/tuned.toml").body,
      testing::AllOf(testing::Not(HasSubstr("[[event]]")),
                     HasSubstr("\n# not in this text, since it is accepted and not flown yet: tune 0: ")));
  tuned.scenario.tuned->occur(0, 0.25);
  EXPECT_TRUE(eventually([&] {
    return tuned.tuning.files().at("/tuned.toml").body.find("[[event]]\nat = 0.25\n") != std::string::npos;
  }));
  EXPECT_THAT(tuned.tuning.files().at("/tuned.toml").body, testing::Not(HasSubstr("not flown yet")));
}

TEST(Tuning, AFlightIsPausedSteppedAndBegunAnew) {
  Tuned tuned;
  EXPECT_THAT(tuned.request(R"({"step":1})")[3].get<std::string>(),
              HasSubstr("expected a flight that is paused"));
  EXPECT_EQ(tuned.request(R"({"id":"p","pause":true})")[2], true);
  EXPECT_TRUE(tuned.clock.paused());
  EXPECT_EQ(tuned.request(R"({"step":3})")[3], "3 periods");
  EXPECT_EQ(tuned.request(R"({"pause":false})")[2], true);
  EXPECT_FALSE(tuned.clock.paused());
  EXPECT_EQ(tuned.request(R"({"seed":7})")[2], true);
  EXPECT_EQ(tuned.seed, 7U);
}

TEST(Tuning, WhatCannotBeIsRefusedWithASentence) {
  Tuned tuned, alone(false);
  const auto refused = [](Tuned& of, const std::string& message, const std::string& sentence) {
    const json answer = of.request(message);
    EXPECT_EQ(answer[2], false) << message;
    EXPECT_THAT(answer[3].get<std::string>(), HasSubstr(sentence)) << message;
  };
  refused(tuned, "garbage", "no JSON object");
  refused(tuned, "[1,2]", "no JSON object");
  refused(tuned, std::string("{\"id\":\"\xff\"}"), "no JSON object");
  refused(tuned, std::string(1000, '['), "no JSON object");
  refused(tuned, "{}", "0 of event, pause, step, seed");
  refused(tuned, R"({"pause":true,"step":1})", "2 of event, pause, step, seed");
  refused(tuned, R"({"paus":true})", "expected one of id, event");
  refused(tuned, R"({"pause":1})", "expected true or false");
  refused(tuned, R"({"pause":true,"ramp":1})", "beside event alone");
  refused(tuned, R"({"seed":-1})", "expected a whole number");
  refused(tuned, R"({"seed":1.5})", "expected a whole number");
  refused(tuned, R"({"event":7})", "expected an object with one of");
  refused(tuned, R"({"event":{"wind":{"acceleration":[0,0,0]}},"ramp":"x"})", "expected a number");
  refused(tuned, R"({"event":{"retune":{"couple":"bearing","weight":-1}}})", "expected >= 0");
  refused(alone, R"({"pause":true})", "keeps the wall clock");
  refused(alone, R"({"step":1})", "keeps the wall clock");
  refused(alone, R"({"seed":1})", "flown once");
  EXPECT_EQ(alone.tuning.refused(), 3);
  tuned.tuning.end();
  refused(tuned, R"({"event":{"wind":{"acceleration":[0,0,0]}}})", "the flight is over");
  EXPECT_EQ(tuned.scenario.tuned->size(), 0U);
}

// No more is kept than was said, however much comes.
TEST(Tuning, AFloodIsBounded) {
  Tuned tuned;
  for (int i = 0; i < 10'000; ++i) tuned.tuning.receive(R"({"id":"x","pause":false})");
  EXPECT_GT(tuned.tuning.stale(), 0);
  EXPECT_TRUE(eventually([&] {
    return json::parse("{\"t\":0" + tuned.tuning.reported() + "}")["answers"].size() ==
           Tuning::answers_reported;
  }));
  EXPECT_LT(tuned.tuning.reported().size(), 8192U);
}

TEST(Tuning, WithoutItAPageIsReadOnlyAndCountsWhatItIsTold) {
  PageServer server({}, {});
  PageClient client(server.port());
  client.watch();
  client.say(PageClient::masked(1, R"({"pause":true})"));
  EXPECT_TRUE(eventually([&] { return server.counts().unrequested == 1; }));
  server.post("{}");
  EXPECT_THAT(client.receive("{}"), HasSubstr("{}")) << "it goes on looking";
}

TEST(Tuning, AFileThatChangesIsServedAsItIsNow) {
  PageServer server({}, {{"/tuned.toml", {"application/toml", "before"}}});
  server.put("/tuned.toml", {"application/toml", "behind"});
  EXPECT_THAT(PageClient(server.port()).request("GET /tuned.toml"), HasSubstr("behind"));
}

}  // namespace
}  // namespace sightline
