/// State of the other parts from their messages: connectivity, losses, and clock offsets.
///
/// Each message holds its send time by the sender's clock, and per other part the latest received
/// message and its age. From an answer the receiver computes a round trip, and the clock offset (as
/// NTP, RFC 5905, section 8):
///
///   offset = ((t_2 - t_1) + (t_3 - t_4)) / 2,   round trip = (t_4 - t_1) - (t_3 - t_2)
///
/// with t_1, t_4 by the own clock and t_2, t_3 by the other clock. The offset with the smallest
/// round trip of the last 10 s is used. Each offset is exact to half its round trip; two
/// inconsistent offsets imply that a clock was reset, and only the later one is kept.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "sightline/solver/prediction.hpp"

namespace sightline {

/// Which robots receive predictions of others, in a team that plans in parts. Reports the last
/// update, on the flight thread. Robots of one part always receive each other.
class Connectivity {
 public:
  /// Whether the plan of `robot` uses a recent prediction of `other`, and `other` also keeps its
  /// distance to `robot`.
  virtual bool receives_from(BodyId robot, BodyId other) const noexcept = 0;
  /// Whether every robot receives this body's predictions; true for a body that sends none.
  virtual bool is_received(BodyId body) const noexcept = 0;

 protected:
  ~Connectivity() = default;
};

/// Time of a computer's clock [ns].
using ClockTime = std::int64_t;

/// Acknowledgement of the last message of another part.
struct Echo {
  ClockTime stamp = 0;  ///< stamp of that message, by its sender's clock; 0: none received
  ClockTime held = 0;   ///< time since its arrival [ns]
};

/// Message of a part, once per period.
struct PartMessage {
  int part = -1;               ///< index in the partition
  std::uint64_t session = 0;   ///< id of the planning program; a restarted program has another
  std::uint64_t sequence = 0;  ///< increases by one per message
  ClockTime stamp = 0;         ///< time of the first Sight of each prediction, by the sender's clock
  bool steers = false;         ///< its robots follow their predictions and keep their distances
  std::uint8_t phase = 0;      ///< of its flight; not used here
  ClockTime begins = 0;        ///< start of its control of the robots, by the sender's clock; 0: unknown
  ClockTime arrived = 0;       ///< by another clock of the receiver, if any; not used here
  std::vector<Prediction> predictions{};  ///< of its robots; `who` refers to the whole team
  std::vector<Echo> echoes{};             ///< per part
};

/// Estimate of another clock's offset from the own clock.
class ClockOffsetByEcho {
 public:
  static constexpr ClockTime kept = 10'000'000'000;  // window of the offsets [ns]
  static constexpr ClockTime drift = 2'000'000;  // largest drift of two clocks in this window, 200 ppm [ns]

  /// Processes a message received at `now` (own clock), sent at `stamp` (other clock), that echoes
  /// a message of ours.
  void receive(ClockTime now, ClockTime stamp, const Echo& echo) noexcept;
  /// Other clock minus own clock [ns]; none before the first echo.
  std::optional<ClockTime> offset() const noexcept;
  void forget() noexcept { *this = {}; }

 private:
  // Best offset per time span, so that old ones can be discarded.
  struct Best {
    ClockTime since = 0, round_trip = std::numeric_limits<ClockTime>::max(), offset = 0;
  };
  static constexpr ClockTime span = kept / 5;
  std::array<Best, 5> best_{};
  std::size_t newest_ = 0;
};

/// Connection state of another part.
enum class PeerState : std::uint8_t {
  silent,      ///< no message yet, or none with an echo
  received,    ///< its newest message is recent
  stale,       ///< its newest message is older than stale_after
  other_time,  ///< its clock offset is too large
  idle,        ///< messages arrive, but it does not steer its robots and its announced start is not reached
};

/// Message state of all parts. Allocates only in the constructor.
class Peers {
 public:
  static constexpr ClockTime offset_max = 20'000'000;  ///< largest accepted clock offset [ns]

  /// @param stale_after  age beyond which a message is ignored [ns]
  Peers(int parts, int own, ClockTime stale_after);

  /// Processes a message received at `now` [ns, own clock]. @return whether it is the newest of its
  /// part; an older one is counted as late and dropped, one of an invalid part is dropped
  bool receive(const PartMessage& message, ClockTime now) noexcept;
  /// Connection state of a part at `now` [ns, own clock].
  PeerState state(int part, ClockTime now) const noexcept;
  bool receives_from(int part, ClockTime now) const noexcept {
    return state(part, now) == PeerState::received;
  }
  /// Other clock minus own clock [ns]; none if unknown.
  std::optional<ClockTime> offset(int part) const noexcept;
  std::uint8_t phase(int part) const noexcept { return peers_[static_cast<std::size_t>(part)].phase; }
  /// Start of its control, by its clock [ns]; 0: unknown.
  ClockTime begins(int part) const noexcept { return peers_[static_cast<std::size_t>(part)].begins; }
  /// Writes the echoes for the next message.
  void answer(ClockTime now, std::vector<Echo>& echoes) const noexcept;

  struct Counts {
    std::int64_t received = 0, lost = 0, late = 0;  ///< late: older than the newest message
    std::int64_t sessions = 0;                      ///< number of programs that planned the part
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
  std::vector<Peer> peers_;  // per part, including the own one
  int own_;
  ClockTime stale_after_;
};

}  // namespace sightline
