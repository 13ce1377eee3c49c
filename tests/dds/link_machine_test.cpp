#include "bridges/dds/links/link_machine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

namespace sightline::dds {
namespace {

constexpr double machine_tick = 0.01;  // [s]

/// A robot that does as it is asked, at once.
struct Obedient {
  LinkFacts facts{.there = true, .checked = true};
  bool deaf = false;
  AutopilotMode after_landing = AutopilotMode::land;

  void take(Request request) {
    if (deaf) return;
    if (request == Request::arm) facts.armed = true;
    if (request == Request::take_off)
      facts.mode = AutopilotMode::takeoff, facts.airborne = true, facts.landed = false;
    if (request == Request::offboard) facts.mode = AutopilotMode::offboard;
    if (request == Request::hold) facts.mode = AutopilotMode::takeoff;
    if (request == Request::land) facts.mode = after_landing, facts.armed = false, facts.landed = true;
  }
};

/// Steps until the state is that, or so long [s].
double until(LinkState state, LinkMachine& machine, Obedient& robot, LinkOrder order, double t,
             double at_most = 100) {
  for (const double end = t + at_most; t < end && machine.state() != state; t += machine_tick)
    robot.take(machine.step(t, robot.facts, order).request);
  return t;
}

TEST(LinkMachine, ARobotThatDoesAsItIsAskedFliesAndLands) {
  LinkMachine machine;
  Obedient robot;
  double t = until(LinkState::ready, machine, robot, LinkOrder::task, 0.0);
  EXPECT_LT(t, 0.1);
  t = until(LinkState::arming, machine, robot, LinkOrder::task, t);
  EXPECT_NEAR(t, 1.2, 0.05);  // PX4 is to hear us for more than a second
  t = until(LinkState::flying, machine, robot, LinkOrder::task, t);
  EXPECT_EQ(machine.state(), LinkState::flying);
  EXPECT_EQ(machine.step(t, robot.facts, LinkOrder::task).setpoint, Setpoint::task);
  t = until(LinkState::holding, machine, robot, LinkOrder::hold, t);
  EXPECT_EQ(machine.step(t, robot.facts, LinkOrder::hold).setpoint, Setpoint::zero);
  until(LinkState::done, machine, robot, LinkOrder::land, t);
  EXPECT_EQ(machine.state(), LinkState::done);
  EXPECT_EQ(machine.reason(), LinkReason::as_requested);
}

TEST(LinkMachine, NothingIsArmedBeforeItIsAsked) {
  LinkMachine machine;
  Obedient robot;
  until(LinkState::arming, machine, robot, LinkOrder::check, 0.0, 50);
  EXPECT_EQ(machine.state(), LinkState::ready);
  EXPECT_FALSE(robot.facts.armed);
}

// Two flyers that begin together may both be ready before they know of each other.
TEST(LinkMachine, WhoIsContestedWhenReadyIsNotArmed) {
  LinkMachine machine;
  Obedient robot;
  const double t = until(LinkState::ready, machine, robot, LinkOrder::check, 0.0);
  robot.facts.contested = true;
  EXPECT_EQ(machine.step(t, robot.facts, LinkOrder::take_off).request, Request::none);
  EXPECT_EQ(machine.state(), LinkState::done);
  EXPECT_EQ(machine.reason(), LinkReason::contested);
}

TEST(LinkMachine, WhoIsUnfitOnTheGroundIsNotArmedButMayWait) {
  for (const LinkOrder order : {LinkOrder::take_off, LinkOrder::hold, LinkOrder::task}) {
    LinkMachine machine;
    Obedient robot;
    const double t = until(LinkState::ready, machine, robot, LinkOrder::check, 0.0);
    robot.facts.unfit = LinkReason::battery_low;
    until(LinkState::done, machine, robot, LinkOrder::check, t, 5.0);
    ASSERT_EQ(machine.state(), LinkState::ready);
    EXPECT_EQ(machine.step(t + 5.0, robot.facts, order).request, Request::none);
    EXPECT_EQ(machine.state(), LinkState::done);
    EXPECT_EQ(machine.reason(), LinkReason::battery_low);
  }
}

TEST(LinkMachine, EachWayOutOfFlightHasItsReason) {
  struct Case {
    const char* what;
    void (*change)(LinkFacts&);
    LinkState state;
    LinkReason reason;
  };
  const std::vector<Case> cases = {
      {"switch", [](LinkFacts& f) { f.mode = AutopilotMode::other; }, LinkState::pilot, LinkReason::pilot},
      {"hold by the pilot", [](LinkFacts& f) { f.mode = AutopilotMode::takeoff; }, LinkState::pilot,
       LinkReason::pilot},
      {"failsafe", [](LinkFacts& f) { f.failsafe = true; }, LinkState::pilot, LinkReason::failsafe},
      {"disarmed", [](LinkFacts& f) { f.armed = false; }, LinkState::done, LinkReason::disarmed},
      {"contested", [](LinkFacts& f) { f.contested = true; }, LinkState::landing, LinkReason::contested},
      {"restarted", [](LinkFacts& f) { f.restarted = true; }, LinkState::done, LinkReason::restarted},
      {"battery", [](LinkFacts& f) { f.unfit = LinkReason::battery_low; }, LinkState::landing,
       LinkReason::battery_low},
      {"estimator", [](LinkFacts& f) { f.unfit = LinkReason::estimator_invalid; }, LinkState::landing,
       LinkReason::estimator_invalid},
      {"silent", [](LinkFacts& f) { f.there = false; }, LinkState::landing, LinkReason::silent}};
  for (const Case& one : cases) {
    for (const LinkOrder order : {LinkOrder::task, LinkOrder::hold}) {
      LinkMachine machine;
      Obedient robot;
      const LinkState from = order == LinkOrder::task ? LinkState::flying : LinkState::holding;
      const double t = until(from, machine, robot, order, 0.0);
      ASSERT_EQ(machine.state(), from);
      one.change(robot.facts);
      const LinkOutput output = machine.step(t, robot.facts, order);
      EXPECT_EQ(machine.state(), one.state) << one.what;
      EXPECT_EQ(machine.reason(), one.reason) << one.what;
      if (one.state == LinkState::pilot || one.state == LinkState::done) {
        EXPECT_FALSE(output.heartbeat) << one.what;
        EXPECT_EQ(output.setpoint, Setpoint::none) << one.what;
      }
    }
  }
}

TEST(LinkMachine, WhoDoesNotAnswerIsGivenUpInTime) {
  LinkMachine machine;
  Obedient robot;
  robot.deaf = true;
  double t = until(LinkState::arming, machine, robot, LinkOrder::task, 0.0);
  t = until(LinkState::done, machine, robot, LinkOrder::task, t) - t;
  EXPECT_NEAR(t, LinkTimes{}.arming, 0.05);
  EXPECT_EQ(machine.reason(), LinkReason::no_answer);

  LinkMachine absent;
  Obedient nobody;
  nobody.facts.there = false;
  EXPECT_NEAR(until(LinkState::done, absent, nobody, LinkOrder::task, 0.0), LinkTimes{}.ready, 0.05);
  EXPECT_EQ(absent.reason(), LinkReason::not_ready);
}

TEST(LinkMachine, WhoIsLostWhileItLandsIsGivenUpUnlessItComesBack) {
  LinkMachine machine;
  Obedient robot;
  double t = until(LinkState::flying, machine, robot, LinkOrder::task, 0.0);
  robot.facts.there = false;
  robot.deaf = true;
  t = until(LinkState::done, machine, robot, LinkOrder::task, t, 2.0);
  EXPECT_EQ(machine.state(), LinkState::landing);
  robot.facts.there = true;
  t = until(LinkState::done, machine, robot, LinkOrder::task, t, 1.0);
  robot.facts.there = false;
  EXPECT_NEAR(until(LinkState::done, machine, robot, LinkOrder::task, t) - t, LinkTimes{}.gone, 0.05);
  EXPECT_EQ(machine.reason(), LinkReason::silent);
}

TEST(LinkMachine, WhoIsArmedByAnotherIsNotTaken) {
  LinkMachine machine;
  Obedient robot;
  const double t = until(LinkState::ready, machine, robot, LinkOrder::check, 0.0);
  robot.facts.armed = true;
  (void)machine.step(t, robot.facts, LinkOrder::task);
  EXPECT_EQ(machine.state(), LinkState::pilot);
}

TEST(LinkMachine, HandedOverNothingIsSent) {
  LinkMachine machine;
  Obedient robot;
  const double t = until(LinkState::flying, machine, robot, LinkOrder::task, 0.0);
  const LinkOutput output = machine.step(t, robot.facts, LinkOrder::hand_over);
  EXPECT_EQ(machine.state(), LinkState::done);
  EXPECT_EQ(machine.reason(), LinkReason::handed_over);
  EXPECT_FALSE(output.heartbeat);
}

TEST(LinkMachine, AnEmergencyStopsWhatItHadArmedOnceAndNothingElse) {
  for (const LinkState from : {LinkState::waiting, LinkState::ready, LinkState::arming, LinkState::taking_off,
                               LinkState::holding, LinkState::flying, LinkState::landing, LinkState::done}) {
    LinkMachine machine;
    Obedient robot;
    robot.facts.checked = from != LinkState::waiting;
    double t = 0.0;
    if (from == LinkState::landing || from == LinkState::done)
      t = until(LinkState::flying, machine, robot, LinkOrder::task, t);
    t = until(from, machine, robot,
              from >= LinkState::landing   ? LinkOrder::land
              : from == LinkState::holding ? LinkOrder::hold
                                           : LinkOrder::task,
              t, 5);
    ASSERT_EQ(machine.state(), from);
    const bool ours = machine.in_our_hands();
    int stopped = 0;
    for (int k = 0; k < 200; ++k, t += machine_tick) {
      const LinkOutput output = machine.step(t, robot.facts, LinkOrder::emergency);
      stopped += output.request == Request::emergency ? 1 : 0;
      ASSERT_TRUE(output.request == Request::none || (k == 0 && ours)) << to_string(from);
      ASSERT_FALSE(output.heartbeat);
      ASSERT_EQ(output.setpoint, Setpoint::none);
    }
    EXPECT_EQ(stopped, ours ? 1 : 0) << to_string(from);
    EXPECT_EQ(machine.state(), LinkState::done);
    EXPECT_EQ(machine.reason(), ours ? LinkReason::emergency : LinkReason::as_requested) << to_string(from);
  }
}

// PX4 restores the mode from before the landing, in which it does not arm without heartbeats.
TEST(LinkMachine, ARobotOnTheGroundIsBroughtOutOfOffboard) {
  for (const bool deaf : {false, true}) {
    LinkMachine machine;
    Obedient robot{.facts = {.there = true, .checked = true, .mode = AutopilotMode::offboard},
                   .after_landing = AutopilotMode::offboard};
    double t = until(LinkState::flying, machine, robot, LinkOrder::task, 0.0);
    ASSERT_EQ(machine.state(), LinkState::flying);
    robot.take(machine.step(t, robot.facts, LinkOrder::land).request);
    robot.deaf = deaf;
    EXPECT_NEAR(until(LinkState::done, machine, robot, LinkOrder::land, t) - t,
                deaf ? LinkTimes{}.offboard : 0.0, 5 * machine_tick);
    EXPECT_EQ(robot.facts.mode, deaf ? AutopilotMode::offboard : AutopilotMode::takeoff);
    EXPECT_EQ(machine.reason(), LinkReason::as_requested);
  }
}

TEST(LinkMachine, ARequestIsRepeatedUntilItIsAnswered) {
  struct Case {
    LinkState state;
    Request request;
  };
  for (const Case& one :
       {Case{LinkState::arming, Request::arm}, Case{LinkState::taking_off, Request::take_off},
        Case{LinkState::taking_off, Request::offboard}}) {
    for (const int answered : {1, 3, 100}) {
      LinkMachine machine;
      Obedient robot;
      double t = until(one.state, machine, robot, LinkOrder::take_off, 0.0);
      if (one.request == Request::arm) robot.facts.armed = false;
      robot.facts.landed = one.request != Request::offboard, robot.facts.airborne = !robot.facts.landed;
      robot.facts.answered = answered == 1;
      int requests = one.request == Request::offboard ? 0 : 1;  // of the step into the state
      double last = t - machine_tick;
      for (const double end = t + 1.9; t < end; t += machine_tick) {
        const LinkOutput output = machine.step(t, robot.facts, LinkOrder::hold);
        if (output.request == Request::none) continue;
        ASSERT_EQ(output.request, one.request);
        EXPECT_TRUE(++requests == 1 || std::abs(t - last - LinkTimes{}.again) < 2 * machine_tick) << t - last;
        robot.facts.answered = requests >= answered;
        last = t;
      }
      EXPECT_EQ(requests, std::min(answered, LinkTimes{}.attempts));
      EXPECT_EQ(machine.state(), one.state);
    }
  }
}

// Whatever robots and persons do: set-points only where the autopilot takes them and in the states
// for them, heartbeats only from ready to landing. Requests to arm, take off and take set-points
// are few; pilot and done have no way out; each state ends in bounded time.
TEST(LinkMachine, KeepsItsPromisesInAMillionRandomEvents) {
  std::mt19937 random(7);
  const auto chance = [&](double p) { return std::uniform_real_distribution<>(0, 1)(random) < p; };
  const LinkTimes times{.called = 5, .takeoff = 5, .holding = 5, .task = 5, .landing = 5};
  constexpr int events = 1'000'000;
  std::set<LinkState> seen;
  std::set<LinkReason> reasons;
  int flights = 0;
  for (int left = events; left > 0; ++flights) {
    LinkMachine machine(times);
    LinkFacts f{.there = true, .checked = true};
    LinkOrder order = LinkOrder::check;
    double t = 0.0, entered = 0.0;
    int armed = 0, took_off = 0, offboard = 0, stopped = 0;
    const double wild = chance(0.3) ? 0.0 : chance(0.5) ? 0.001 : 0.02;  // of each fact, each time
    for (int k = 0, after_end = 0; k < 3000 && left > 0 && after_end < 50; ++k, --left, t += 0.02) {
      if (chance(wild)) f.there = !f.there || chance(0.2);
      if (chance(wild)) f.checked = chance(0.7);
      if (chance(wild))
        f.unfit = chance(0.6)   ? LinkReason::as_requested
                  : chance(0.3) ? LinkReason::battery_low
                  : chance(0.5) ? LinkReason::estimator_invalid
                  : chance(0.3) ? LinkReason::stamps_stuck
                  : chance(0.3) ? LinkReason::late
                  : chance(0.5) ? LinkReason::strayed
                  : chance(0.5) ? LinkReason::misplaced
                                : LinkReason::moved;
      if (chance(wild)) f.armed = chance(0.7);
      if (chance(wild)) f.airborne = chance(0.7);
      if (chance(wild)) f.landed = chance(0.5);
      if (chance(wild)) f.refused = chance(0.2);
      if (chance(wild)) f.answered = chance(0.7);
      if (chance(wild)) f.failsafe = chance(0.3);
      if (chance(wild)) f.restarted = chance(0.1);
      if (chance(wild)) f.contested = chance(0.3);
      if (chance(wild)) f.mode = static_cast<AutopilotMode>(std::uniform_int_distribution<>(0, 3)(random));
      if (chance(0.004))
        order = static_cast<LinkOrder>(std::uniform_int_distribution<>(0, chance(0.3) ? 6 : 3)(random));
      const LinkState before = machine.state();
      const LinkOutput out = machine.step(t, f, order);
      const LinkState state = machine.state();
      seen.insert(state);
      reasons.insert(machine.reason());
      if (state != before) entered = t;

      const bool final = state == LinkState::pilot || state == LinkState::done;
      const bool was_final = before == LinkState::pilot || before == LinkState::done;
      after_end += was_final ? 1 : 0;
      ASSERT_TRUE(!was_final || state == before);
      ASSERT_TRUE(final || t - entered <= machine.longest(state) + 0.021) << to_string(state);
      const bool takes =
          state == LinkState::flying || state == LinkState::holding || state == LinkState::landing;
      ASSERT_TRUE(out.setpoint == Setpoint::none || (takes && f.mode == AutopilotMode::offboard))
          << to_string(state);
      ASSERT_TRUE(out.setpoint != Setpoint::task || state == LinkState::flying);
      ASSERT_TRUE(!out.heartbeat || (state >= LinkState::ready && state <= LinkState::landing));
      ASSERT_TRUE(state != LinkState::ready || before == state || f.mode != AutopilotMode::offboard);
      if (out.request == Request::hold) {
        ASSERT_TRUE(!f.armed && f.landed && f.mode == AutopilotMode::offboard);
        ASSERT_TRUE(state == LinkState::waiting || state == LinkState::landing);
      } else if (out.request == Request::emergency) {
        ASSERT_TRUE(before >= LinkState::arming && before <= LinkState::landing && state == LinkState::done);
        ++stopped;
      } else {
        ASSERT_TRUE(out.request == Request::none || (!final && state != LinkState::waiting));
      }
      ASSERT_LE(stopped, 1);
      armed += out.request == Request::arm ? 1 : 0;
      took_off += out.request == Request::take_off ? 1 : 0;
      offboard += out.request == Request::offboard ? 1 : 0;
      for (const int requests : {armed, took_off, offboard}) ASSERT_LE(requests, times.attempts);
      // What is asked, mostly happens, or is refused; or it is acknowledged and does not happen.
      const bool obeys = chance(0.9);
      if (out.request != Request::none) f.answered = obeys || chance(0.3), f.refused = !obeys && chance(0.5);
      if (out.request == Request::arm && obeys) f.armed = true, f.landed = false;
      if (out.request == Request::take_off && obeys) f.mode = AutopilotMode::takeoff, f.airborne = true;
      if (out.request == Request::offboard && obeys) f.mode = AutopilotMode::offboard;
      if (out.request == Request::hold && obeys) f.mode = AutopilotMode::takeoff;
      if (out.request == Request::land && chance(0.5)) f.mode = AutopilotMode::land;
    }
  }
  EXPECT_EQ(seen.size(), static_cast<std::size_t>(link_states));
  for (int i = 0; i < link_reasons; ++i) {
    const auto reason = static_cast<LinkReason>(i);
    EXPECT_TRUE(reasons.contains(reason)) << to_string(reason);
  }
  EXPECT_GT(flights, 300);
}

}  // namespace
}  // namespace sightline::dds
