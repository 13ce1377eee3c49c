#include <gtest/gtest.h>

#include <cstdlib>

#include "cli/allocations.hpp"
#include "sightline/solvers.hpp"

namespace sightline {
namespace {

constexpr ClockTime ms = 1'000'000, begin_of_day = 1'000'000'000'000;

/// Two parts that talk each 10 ms; the clock of the second is ahead.
struct Talk {
  ClockTime ahead, there, back;  // delays of messages to the second, and to the first
  Peers first{2, 0, 200 * ms}, second{2, 1, 200 * ms};
  std::uint64_t number = 0, session = 1;
  ClockTime now = begin_of_day;

  PartMessage message(int of) {
    PartMessage m{.part = of, .session = session, .sequence = number, .steers = true};
    m.stamp = now + (of == 1 ? ahead : 0);
    m.echoes.resize(2);
    (of == 0 ? first : second).answer(m.stamp, m.echoes);
    return m;
  }
  void period() {
    ++number;
    const PartMessage of_first = message(0), of_second = message(1);
    second.receive(of_first, now + there + ahead);
    first.receive(of_second, now + back);
    now += 10 * ms;
  }
};

TEST(Peers, ClocksAreKnownToHalfOfHowFarTheWaysDiffer) {
  for (const ClockTime ahead : {-15 * ms, ClockTime{0}, 3 * ms, 700 * ms}) {
    for (const ClockTime back : {2 * ms, 8 * ms}) {
      const ClockTime there = 2 * ms;
      Talk talk{.ahead = ahead, .there = there, .back = back};
      for (int i = 0; i < 20; ++i) talk.period();
      ASSERT_TRUE(talk.first.offset(1).has_value());
      EXPECT_LE(std::abs(*talk.first.offset(1) - ahead), std::abs(back - there) / 2 + 1);
      EXPECT_LE(std::abs(*talk.second.offset(0) + ahead), std::abs(back - there) / 2 + 1);
    }
  }
}

TEST(Peers, AClockThatIsTooFarAwayIsNotHeard) {
  Talk talk{.ahead = 19 * ms, .there = 2 * ms, .back = 2 * ms};
  for (int i = 0; i < 5; ++i) talk.period();
  EXPECT_TRUE(talk.first.receives_from(1, talk.now));
  Talk far{.ahead = -21 * ms, .there = 2 * ms, .back = 2 * ms};
  for (int i = 0; i < 5; ++i) far.period();
  EXPECT_EQ(far.first.state(1, far.now), PeerState::other_time);
  EXPECT_FALSE(far.second.receives_from(0, far.now - 21 * ms));
}

TEST(Peers, AClockThatIsSetAnewIsKnownSoonAndNotTrustedBefore) {
  for (const ClockTime step : {-700 * ms, -8 * ms, 8 * ms, 700 * ms}) {
    Talk talk{.ahead = 0, .there = 2 * ms, .back = 2 * ms};
    for (int i = 0; i < 300; ++i) talk.period();
    talk.ahead += step;
    for (int i = 0; i < 3; ++i) {
      talk.period();
      const bool far = std::abs(step) > Peers::offset_max;
      EXPECT_FALSE(far && talk.first.receives_from(1, talk.now)) << step << ' ' << i;
    }
    ASSERT_TRUE(talk.first.offset(1).has_value());
    EXPECT_EQ(*talk.first.offset(1), step);
    EXPECT_EQ(*talk.second.offset(0), -step);
    EXPECT_EQ(talk.first.receives_from(1, talk.now), std::abs(step) <= Peers::offset_max);
    talk.ahead = 0;  // and back
    for (int i = 0; i < 3; ++i) talk.period();
    EXPECT_TRUE(talk.first.receives_from(1, talk.now)) << step;
  }
}

TEST(Peers, NothingCountsBeforeItIsAnsweredAndNoLongerThanItIsYoung) {
  Talk talk{.ahead = 0, .there = 2 * ms, .back = 2 * ms};
  EXPECT_EQ(talk.first.state(1, talk.now), PeerState::silent);
  talk.period();
  EXPECT_EQ(talk.first.state(1, talk.now), PeerState::silent) << "no answer has come";
  talk.period();
  talk.period();
  const ClockTime sent = talk.now - 10 * ms;
  EXPECT_EQ(talk.first.state(1, sent + 200 * ms), PeerState::received);
  EXPECT_EQ(talk.first.state(1, sent + 201 * ms), PeerState::stale);
}

TEST(Peers, TheNewestCountsAndAnotherProgramBeginsAnew) {
  Peers peers(2, 0, 200 * ms);
  const auto came = [&](std::uint64_t session, std::uint64_t number) {
    return peers.receive({.part = 1, .session = session, .sequence = number, .stamp = begin_of_day},
                         begin_of_day);
  };
  EXPECT_TRUE(came(7, 10));
  EXPECT_FALSE(came(7, 9));
  EXPECT_FALSE(came(7, 10));
  EXPECT_TRUE(came(7, 14));
  EXPECT_EQ(peers.counts(1).lost, 3);
  EXPECT_EQ(peers.counts(1).late, 2);
  EXPECT_TRUE(came(8, 1)) << "started again";
  EXPECT_EQ(peers.counts(1).sessions, 2);
  EXPECT_EQ(peers.counts(1).lost, 3);
  EXPECT_FALSE(peers.receive({.part = 0}, begin_of_day)) << "of itself";
  EXPECT_FALSE(peers.receive({.part = 2}, begin_of_day)) << "of nobody";
}

TEST(Peers, WhoDoesNotSteerIsHeardAndIdle) {
  Talk talk{.ahead = 0, .there = 2 * ms, .back = 2 * ms};
  for (int i = 0; i < 5; ++i) talk.period();
  ++talk.number;
  PartMessage rests = talk.message(1);
  rests.steers = false;
  EXPECT_TRUE(talk.first.receive(rests, talk.now + 2 * ms));
  EXPECT_EQ(talk.first.state(1, talk.now + 3 * ms), PeerState::idle);
}

TEST(Peers, WhoSaidWhenItBeginsIsCountedOnFromThenOn) {
  for (const ClockTime ahead : {-15 * ms, ClockTime{0}, 15 * ms}) {
    Talk talk{.ahead = ahead, .there = 2 * ms, .back = 2 * ms};
    for (int i = 0; i < 5; ++i) talk.period();
    ++talk.number;
    const ClockTime begins = talk.now + 50 * ms;
    PartMessage holds = talk.message(1);
    holds.steers = false;
    holds.begins = begins + ahead;
    EXPECT_TRUE(talk.first.receive(holds, talk.now + 2 * ms));
    EXPECT_EQ(talk.first.state(1, begins - ms), PeerState::idle);
    EXPECT_EQ(talk.first.state(1, begins + ms), PeerState::received);
    EXPECT_EQ(talk.first.state(1, talk.now + 202 * ms), PeerState::stale) << "nothing more came";
  }
}

TEST(Peers, NoMessageTakesMemory) {
  Talk talk{.ahead = 0, .there = 2 * ms, .back = 2 * ms};
  ++talk.number;
  const PartMessage message = talk.message(1);
  PartMessage answer = talk.message(0);
  const std::int64_t before = cli::allocations();
  talk.first.receive(message, talk.now);
  talk.first.answer(talk.now, answer.echoes);
  (void)talk.first.state(1, talk.now);
  EXPECT_EQ(cli::allocations() - before, 0);
}

}  // namespace
}  // namespace sightline
