/// What a part knows of the others by their messages: who is heard, how much is lost, and how far their clocks are from its own.
///
/// Each message says when it was sent, by its sender's clock, and which message of each other part came last and how long ago. So the
/// receiver of an answer knows a round trip, and with it the offset of the clocks (as NTP does, RFC 5905, section 8):
///
///   offset = ((t_2 - t_1) + (t_3 - t_4)) / 2,   round trip = (t_4 - t_1) - (t_3 - t_2)
///
/// with t_1, t_4 by its own clock and t_2, t_3 by the other's. The offset of the least round trip of the last 10 s counts. Each is right
/// to half its round trip; two that cannot both be tell that a clock was set anew, and the later one counts alone.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "sightline/solver/prediction.hpp"

namespace sightline {

/// Which robots hear where others will be, in a team that plans in parts. Of the thread that flies; of the last update. Robots of one part hear each other always.
class Connectivity {
 public:
  /// Whether what a robot plans with knows where the other will be, from a message that is young enough, and the other keeps its
  /// distance to this one as well.
  virtual bool receives_from(BodyId robot, BodyId other) const noexcept = 0;
  /// Whether every robot hears this one; so it is of a body that sends nothing.
  virtual bool is_received(BodyId body) const noexcept = 0;

 protected:
  ~Connectivity() = default;
};

/// By a clock of a computer [ns].
using ClockTime = std::int64_t;

/// Of one part, what another one's messages said last.
struct Echo {
  ClockTime stamp = 0;  ///< by the clock of the one that is answered; 0: nothing came from it
  ClockTime held = 0;   ///< how long ago it came
};

/// What a part sends each period.
struct PartMessage {
  int part = -1;               ///< its place in the partition
  std::uint64_t session = 0;   ///< of the program that plans it: another one has another
  std::uint64_t sequence = 0;  ///< rises by one from message to message
  ClockTime stamp = 0;         ///< of the first sight of each prediction, by the sender's clock
  bool steers = false;         ///< its robots fly as they predict, and keep their distances
  std::uint8_t phase = 0;      ///< of its flight; of no meaning here
  ClockTime begins = 0;        ///< from when on it steers them, by the sender's clock; 0: not said
  ClockTime arrived = 0;       ///< by another clock of the receiver's, where it keeps one; of no meaning here
  std::vector<Prediction> predictions{};  ///< of its robots, `who` of the whole team
  std::vector<Echo> echoes{};             ///< of each part
};

/// The offset of another clock from one's own.
class ClockOffsetByEcho {
 public:
  static constexpr ClockTime kept = 10'000'000'000;  // [ns]
  static constexpr ClockTime drift = 2'000'000;      // of two clocks in this time at most, 200 ppm [ns]

  /// A message came at `now` that was sent at `stamp` by the other clock, and answers ours.
  void receive(ClockTime now, ClockTime stamp, const Echo& echo) noexcept;
  /// Theirs minus ours; none before the first answer.
  std::optional<ClockTime> offset() const noexcept;
  void forget() noexcept { *this = {}; }

 private:
  // The best of each of some spans of time, so that old ones can be dropped.
  struct Best {
    ClockTime since = 0, round_trip = std::numeric_limits<ClockTime>::max(), offset = 0;
  };
  static constexpr ClockTime span = kept / 5;
  std::array<Best, 5> best_{};
  std::size_t newest_ = 0;
};

/// How another part is heard.
enum class PeerState : std::uint8_t {
  silent,      ///< nothing came yet, or nothing that was answered
  received,    ///< its newest message is young
  stale,       ///< it is older than stale_after
  other_time,  ///< its clock is too far from ours
  idle,  ///< it is heard, and does not steer its robots: it neither says so nor said that by now it would
};

/// Of one part. Nothing allocates after construction.
class Peers {
 public:
  static constexpr ClockTime offset_max = 20'000'000;  ///< clocks that are farther apart are refused [ns]

  /// @param stale_after  age from which a message does not count any more [ns]
  Peers(int parts, int own, ClockTime stale_after);

  /// A message came at `now` by our clock. @return whether it is the newest of its part; an older one is counted and dropped
  bool receive(const PartMessage& message, ClockTime now) noexcept;
  /// One that could not be read, or is of no part.
  PeerState state(int part, ClockTime now) const noexcept;
  bool receives_from(int part, ClockTime now) const noexcept {
    return state(part, now) == PeerState::received;
  }
  /// Theirs minus ours; none where it is not known.
  std::optional<ClockTime> offset(int part) const noexcept;
  std::uint8_t phase(int part) const noexcept { return peers_[static_cast<std::size_t>(part)].phase; }
  /// When its task begins, by its clock; 0: not said.
  ClockTime begins(int part) const noexcept { return peers_[static_cast<std::size_t>(part)].begins; }
  /// What goes into the next message.
  void answer(ClockTime now, std::vector<Echo>& echoes) const noexcept;

  struct Counts {
    std::int64_t received = 0, lost = 0, late = 0;  ///< late: an earlier one than the newest
    std::int64_t sessions = 0;                      ///< programs that planned it
  };
  const Counts& counts(int part) const noexcept { return peers_[static_cast<std::size_t>(part)].counts; }
  void forget() noexcept;

 private:
  struct Peer {
    std::uint64_t session = 0, sequence = 0;
    ClockTime stamp = 0, arrived = 0, begins = 0;
    bool steers = false;
    std::uint8_t phase = 0;
    ClockOffsetByEcho clock{};
    Counts counts{};
  };
  std::vector<Peer> peers_;  // of each part, one's own included
  int own_;
  ClockTime stale_after_;
};

}  // namespace sightline
