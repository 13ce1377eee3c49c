#include "bridges/dds/topics/services.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "tests/dds/person.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/child.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using PlainResponse = std_srvs_srv_dds__Trigger_Response_;

class Services : public testing::Test {
 protected:
  std::shared_ptr<Domain> domain = std::make_shared<Domain>(test::own_network(1));
  OperatorCalls calls;
  OperatorServices services{domain->participant(), "/sightline", calls};
};

TEST_F(Services, TwoCallersAreAnsweredEachForItself) {
  Person one(*domain, 7, "/sightline/land"), other(*domain, 8, "/sightline/land");
  EXPECT_EQ(one.call(), "yes: all land");
  EXPECT_EQ(other.call(), "yes: all land");
  EXPECT_EQ(one.answers().size(), 1u);
  EXPECT_TRUE(calls.to_land());
  EXPECT_FALSE(calls.is_emergency());
  // The same once more, as after a lost reply.
  one.send(101);
  EXPECT_TRUE(test::eventually([&] { return one.answers().size() == 2; }));
  EXPECT_EQ(one.answers()[0], one.answers()[1]);
}

TEST_F(Services, WhatComesTooEarlyOrTooLateIsRefusedInASentence) {
  Person starts(*domain, 1, "/sightline/start"), stops(*domain, 2, "/sightline/stop"),
      kills(*domain, 3, "/sightline/emergency");
  EXPECT_EQ(starts.call(), "no: not all robots are ready yet");
  EXPECT_EQ(stops.call(), "no: there is no task now; land ends a flight at any time");
  calls.is_at(FlightPhase::over);
  for (Person* one : {&starts, &stops, &kills}) EXPECT_EQ(one->call(), "no: the flight is over");
  EXPECT_FALSE(calls.started() || calls.to_land() || calls.is_emergency());
}

// As one of Fast DDS, whose request has no header.
TEST_F(Services, APlainCallIsAnsweredPlainly) {
  const dds_entity_t at = domain->another_participant();
  std::atomic<int> yes{0};
  RawWriter requests(at, trigger_service.request, wire_request("/sightline/land"), of_services);
  const RawReader replies(at, trigger_service.response, wire_reply("/sightline/land"), of_services,
                          std::nullopt, Writers::all,
                          taking<PlainResponse>([&](const PlainResponse& r, const Arrival&) {
                            yes += r.success && std::string(r.message) == "all land" ? 1 : 0;
                          }));
  ASSERT_TRUE(test::eventually([&] { return requests.matched() == 2 && replies.matched() == 2; }));
  const std_srvs_srv_dds__Trigger_Request_ request{};
  requests.write(&request);
  EXPECT_TRUE(test::eventually([&] { return yes == 1; }));
  EXPECT_TRUE(calls.to_land());
}

TEST_F(Services, AnotherOneOfThatNameIsARival) {
  WriterList writers(domain->participant());
  EXPECT_FALSE(services.has_rival(writers.look()));
  OperatorCalls others;
  const OperatorServices elsewhere(domain->another_participant(), "/lab/sightline", others);
  const OperatorServices second(domain->another_participant(), "/sightline", others);
  EXPECT_TRUE(test::eventually([&] { return services.has_rival(writers.look()); }));
}

/// The flight of a row, by calls from elsewhere.
class CalledFlight : public testing::Test {
 protected:
  std::string call(Rig& rig, const std::string& what) {
    return Person(*rig.domain, ++person_, "/sightline/" + what).call();
  }
  std::uint64_t person_ = 40;
};

TEST_F(CalledFlight, StartedByACallAndStoppedByACallItIsNoFailure) {
  Rig rig(row_of({"1.16", "1.14"}, 60.0));
  std::thread operator_([&] {
    EXPECT_TRUE(test::eventually([&] { return call(rig, "start") == "yes: they take off"; }));
    EXPECT_EQ(rig.counts_of(0).arm_requests, 0);  // not before
    EXPECT_TRUE(test::eventually([&] { return call(rig, "stop") == "yes: the task ends, all land"; }));
  });
  const LoopOutcome outcome = rig.fly(0, {}, Arming::on_call);
  operator_.join();
  EXPECT_TRUE(outcome.finite) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_GT(outcome.updates, 0);
  EXPECT_LT(outcome.updates, 2000);
  EXPECT_THAT(rig.reported, Contains("all are ready: /sightline/start lets them take off"));
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  EXPECT_EQ(call(rig, "land"), "no: the flight is over");
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_FALSE(rig.vehicle(i).armed());
    EXPECT_EQ(rig.counts_of(i).kills, 0);
  }
  expect_well_treated(rig);
}

TEST_F(CalledFlight, AnEmergencyStopsEachOnceAndNothingIsSentAfter) {
  Rig rig(row_of({"1.16", "1.14"}, 60.0));
  std::array<std::int64_t, 2> heartbeats{}, setpoints{};
  const LoopOutcome outcome = rig.fly(1.0, [&] {
    EXPECT_THAT(call(rig, "emergency"), HasSubstr("yes: the motors of all robots stop"));
    EXPECT_THAT(call(rig, "emergency"), testing::StartsWith(""));  // again, after the flight too
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    for (std::size_t i = 0; i < 2; ++i)
      heartbeats[i] = rig.counts_of(i).heartbeats, setpoints[i] = rig.counts_of(i).setpoints;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_FALSE(outcome.finite);
  EXPECT_EQ(rig.world->ended(),
            "uav0: its motors were stopped by the operator; uav1: its motors were stopped by the operator");
  EXPECT_EQ(rig.world->faults().size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(rig.counts_of(i).kills, 1) << i;
    EXPECT_FALSE(rig.vehicle(i).armed()) << i;
    EXPECT_EQ(rig.state(static_cast<int>(i)), LinkState::done);
    EXPECT_EQ(rig.counts_of(i).heartbeats, heartbeats[i]);
    EXPECT_EQ(rig.counts_of(i).setpoints, setpoints[i]);
  }
}

TEST_F(CalledFlight, ASecondFlyerOfTheNameIsRefusedBeforeArming) {
  Rig rig(row_of({"1.16"}, 1.0));
  OperatorCalls others;
  const OperatorServices second(rig.domain->another_participant(), "/sightline", others);
  EXPECT_FALSE(rig.take_off());
  EXPECT_THAT(rig.world->faults(), ElementsAre(HasSubstr("fleet.node = \"/sightline\", by which another")));
  EXPECT_EQ(rig.counts_of(0).arm_requests, 0);
}

}  // namespace
}  // namespace sightline::dds
