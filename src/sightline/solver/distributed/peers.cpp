#include <algorithm>
#include <cstdlib>

#include "sightline/base.hpp"
#include "sightline/solvers.hpp"

namespace sightline {

void ClockOffsetByEcho::receive(ClockTime now, ClockTime stamp, const Echo& echo) noexcept {
  if (echo.stamp == 0) return;
  const ClockTime round_trip = (now - echo.stamp) - echo.held;
  if (round_trip < 0 || round_trip > kept) return;  // a clock was reset
  // Other clock: t_2 = stamp - held, arrival of our message, and t_3 = stamp. Exact to half the
  // round trip, for any asymmetry of the two paths.
  const ClockTime offset = ((stamp - echo.held - echo.stamp) + (stamp - now)) / 2;
  const bool agree = std::all_of(best_.begin(), best_.end(), [&](const Best& best) {
    return best.since == 0 || std::abs(best.offset - offset) <= (best.round_trip + round_trip) / 2 + drift;
  });
  if (!agree) forget();  // a clock was reset: earlier offsets are invalid
  if (now - best_[newest_].since > span || best_[newest_].since == 0) {
    newest_ = (newest_ + 1) % best_.size();
    best_[newest_] = {.since = now};
  }
  Best& best = best_[newest_];
  if (round_trip > best.round_trip) return;
  best.round_trip = round_trip;
  best.offset = offset;
}

std::optional<ClockTime> ClockOffsetByEcho::offset() const noexcept {
  const auto best = std::min_element(
      best_.begin(), best_.end(), [](const Best& a, const Best& b) { return a.round_trip < b.round_trip; });
  if (best->since == 0 || best->round_trip == std::numeric_limits<ClockTime>::max()) return std::nullopt;
  return best->offset;
}

Peers::Peers(int parts, int own, ClockTime stale_after)
    : peers_(at(parts)), own_(own), stale_after_(stale_after) {}

bool Peers::receive(const PartMessage& message, ClockTime now) noexcept {
  if (message.part < 0 || message.part >= static_cast<int>(peers_.size()) || message.part == own_)
    return false;
  Peer& peer = peers_[at(message.part)];
  const bool other = peer.counts.sessions == 0 || message.session != peer.session;
  if (!other && message.sequence <= peer.sequence) {
    ++peer.counts.late;
    return false;
  }
  if (other) {
    peer.clock.forget();
    peer.session = message.session;
    ++peer.counts.sessions;
  } else {
    peer.counts.lost += static_cast<std::int64_t>(message.sequence - peer.sequence - 1);
  }
  ++peer.counts.received;
  peer.sequence = message.sequence;
  peer.stamp = message.stamp;
  peer.arrived = now;
  peer.steers = message.steers;
  peer.phase = message.phase;
  peer.begins = message.begins;
  if (message.echoes.size() == peers_.size())
    peer.clock.receive(now, message.stamp, message.echoes[at(own_)]);
  return true;
}

PeerState Peers::state(int part, ClockTime now) const noexcept {
  const Peer& peer = peers_[at(part)];
  const std::optional<ClockTime> offset = peer.clock.offset();
  if (peer.counts.received == 0 || !offset) return PeerState::silent;
  if (std::abs(*offset) > offset_max) return PeerState::other_time;
  // A stamp in the future means that a clock was reset; stale until the next echo.
  if (const ClockTime age = now - (peer.stamp - *offset); age > stale_after_ || age < -offset_max)
    return PeerState::stale;
  const bool begun = peer.begins != 0 && now >= peer.begins - *offset;
  return peer.steers || begun ? PeerState::received : PeerState::idle;
}

std::optional<ClockTime> Peers::offset(int part) const noexcept { return peers_[at(part)].clock.offset(); }

void Peers::answer(ClockTime now, std::vector<Echo>& echoes) const noexcept {
  for (std::size_t i = 0; i < echoes.size() && i < peers_.size(); ++i) {
    const Peer& peer = peers_[i];
    echoes[i] = peer.counts.received == 0 ? Echo{} : Echo{peer.stamp, now - peer.arrived};
  }
}

void Peers::forget() noexcept { std::fill(peers_.begin(), peers_.end(), Peer{}); }

}  // namespace sightline
