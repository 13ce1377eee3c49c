#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/base.hpp"
#include "sightline/base/split_mix.hpp"
#include "sightline/solvers.hpp"

namespace sightline {
namespace {

constexpr double nanoseconds = 1e9;                       // per second
constexpr ClockTime begin_of_clocks = 1'000'000'000'000;  // keeps stamps nonzero
constexpr double same_instant = 1e-6;                     // [s]

}  // namespace

double chance_of(MessageChance what, std::uint64_t seed, int to, int from, std::uint64_t sequence) noexcept {
  std::uint64_t state = seed ^ (static_cast<std::uint64_t>(what) << 56);
  state = next_split_mix(state) ^ (static_cast<std::uint64_t>(to) << 32) ^ static_cast<std::uint64_t>(from);
  state = next_split_mix(state) ^ sequence;
  return static_cast<double>(next_split_mix(state) >> 11) * 0x1p-53;
}

SimulatedMessages::SimulatedMessages(const ExchangeOptions& options, const Horizon& horizon,
                                     std::span<const std::vector<Prediction>> predictions)
    : options_(options),
      parts_(predictions.size()),
      kept_(static_cast<std::size_t>(std::ceil((options.delay + options.jitter) / horizon.dt)) + 2),
      talk_periods_(static_cast<int>(std::ceil(2 * (options.delay + options.jitter) / horizon.dt)) + 20),
      numbers_(parts_),
      links_(parts_ * parts_) {
  const auto stale_after = static_cast<ClockTime>(std::llround(nanoseconds * options.stale_after));
  for (std::size_t i = 0; i < parts_; ++i) {
    PartMessage message{
        .part = static_cast<int>(i), .session = 1, .steers = true, .predictions = predictions[i]};
    for (Prediction& prediction : message.predictions) prediction.sights.reserve(at(horizon.N + 1));
    message.echoes.resize(parts_);
    std::vector<PartMessage>& kept = sent_.emplace_back(kept_, message);
    for (PartMessage& one : kept)
      for (Prediction& prediction : one.predictions) prediction.sights.reserve(at(horizon.N + 1));
    sent_at_.emplace_back(kept_);
    peers_.emplace_back(static_cast<int>(parts_), static_cast<int>(i), stale_after);
  }
}

ClockTime SimulatedMessages::clock(int part, double t) const noexcept {
  const double share = parts_ > 1 ? part / static_cast<double>(parts_ - 1) : 0.0;
  return begin_of_clocks + std::llround(nanoseconds * (t + share * options_.offset));
}

void SimulatedMessages::send(int part, double t, std::span<const Prediction> predictions) noexcept {
  const std::uint64_t number = ++numbers_[at(part)];
  PartMessage& message = sent_[at(part)][number % kept_];
  sent_at_[at(part)][number % kept_] = t;
  message.sequence = number;
  message.stamp = clock(part, t);
  for (std::size_t i = 0; i < predictions.size(); ++i) {
    message.predictions[i].time = t;
    message.predictions[i].sights.assign(predictions[i].sights.begin(), predictions[i].sights.end());
  }
  peers_[at(part)].answer(message.stamp, message.echoes);
}

void SimulatedMessages::receive(int to, double t) noexcept {
  Peers& peers = peers_[at(to)];
  const ClockTime now = clock(to, t);
  for (int from = 0; from < static_cast<int>(parts_); ++from) {
    Link& link = links_[place(to, from)];
    link.news = {};
    if (from == to) continue;
    const std::uint64_t newest = numbers_[at(from)];
    const PartMessage* came = nullptr;
    for (std::uint64_t n = newest; n > link.seen && n + kept_ > newest && came == nullptr; --n) {
      const auto chance = [&](MessageChance what) { return chance_of(what, options_.seed, to, from, n); };
      const double arrival =
          sent_at_[at(from)][n % kept_] + options_.delay + options_.jitter * chance(MessageChance::jitter);
      if (arrival > t + same_instant || chance(MessageChance::loss) < options_.loss) continue;
      came = &sent_[at(from)][n % kept_];
      link.seen = n;
      peers.receive(*came, clock(to, arrival));
    }
    const PeerState state = peers.state(from, now);
    link.received = state == PeerState::received;
    link.news.ended = link.used && !link.received;
    link.used = link.received;
    if (came == nullptr || !link.received) continue;
    link.news.message = came;
    link.news.time = t - static_cast<double>(now - (came->stamp - *peers.offset(from))) / nanoseconds;
  }
}

void SimulatedMessages::restart() noexcept {
  std::fill(numbers_.begin(), numbers_.end(), 0);
  std::fill(links_.begin(), links_.end(), Link{});
  for (Peers& peers : peers_) peers.forget();
}

}  // namespace sightline
