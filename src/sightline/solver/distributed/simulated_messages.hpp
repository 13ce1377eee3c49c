/// Simulated network between the parts of a team: messages arrive late, reordered, or not at all.
///
/// Delay and loss are drawn from the seed, the two parts and the message number, so that a flight
/// is reproducible.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <tuple>
#include <vector>

#include "sightline/base/parameter.hpp"
#include "sightline/ocp/ocp.hpp"
#include "sightline/solver/distributed/peers.hpp"

namespace sightline {

/// Transport of messages in a flight whose parts run in separate programs.
enum class MessagesBy : std::uint8_t {
  network,
  simulation,  ///< the network plus the simulated delay and loss, for tests
};

/// Options of the exchange of predictions between parts.
struct ExchangeOptions {
  static constexpr std::string_view name = "exchange";

  double stale_after = 0.2;
  double speed_max = 1.5;
  // Simulated network.
  double delay = 0.01, jitter = 0.0, loss = 0.0, offset = 0.0;
  MessagesBy flown_by = MessagesBy::network;
  std::uint64_t seed = 1;  ///< of loss and jitter

  static constexpr auto parameters() {
    using E = ExchangeOptions;
    return std::tuple{
        parameter("stale_after", &E::stale_after, "s", {0.02, 10, "0.02 to 10"},
                  "age of a message from which its robots count as uncooperative"),
        parameter("speed_max", &E::speed_max, "m/s", from_zero,
                  "at most, of a robot of another part without messages"),
        parameter("delay", &E::delay, "s", {0, 1, "0 to 1"}, "simulated: from the update to the receiver"),
        parameter("jitter", &E::jitter, "s", {0, 1, "0 to 1"}, "simulated: at most, added to the delay"),
        parameter("loss", &E::loss, "", {0, 1, "0 to 1"}, "simulated: share of the messages that never come"),
        parameter("offset", &E::offset, "s", {-1, 1, "-1 to 1"},
                  "simulated: by which the clock of the last part is ahead of the first one's; those between "
                  "lie between"),
        parameter("flown_by", &E::flown_by, std::array<std::string_view, 2>{"network", "simulation"},
                  "of flights: what is simulated happens to the network's messages as well, to try it")};
  }
};

/// Message that a part received since its last update.
struct ReceivedMessage {
  const PartMessage* message = nullptr;  ///< the newest usable one; null: none arrived
  double time = 0.0;                     ///< time of its first Sights, by the receiver's clock [s]
  bool ended = false;                    ///< the earlier prediction is now too old
};

/// Uniform random number in [0, 1), a function of its arguments: decides a message from one part to
/// another.
enum class MessageChance : std::uint8_t { loss = 1, jitter };
double chance_of(MessageChance what, std::uint64_t seed, int to, int from, std::uint64_t sequence) noexcept;

/// Messages of all parts. Allocates only in the constructor. Different parts may receive in
/// parallel, and send in parallel.
class SimulatedMessages {
 public:
  /// @param said  predictions of each part, in their final sizes
  SimulatedMessages(const ExchangeOptions& options, const Horizon& horizon,
                    std::span<const std::vector<Prediction>> said);

  /// Sends a part's predictions from t [s] on.
  void send(int part, double t, std::span<const Prediction> predictions) noexcept;
  /// Delivers to a part the messages that have arrived by t [s].
  void receive(int to, double t) noexcept;
  /// Result of the last receive().
  ReceivedMessage news(int to, int from) const noexcept { return links_[place(to, from)].news; }
  bool receives_from(int to, int from) const noexcept { return links_[place(to, from)].received; }

  /// Whether any message was sent.
  bool begun() const noexcept { return numbers_.front() > 0; }
  /// Periods after which two parts know each other's clock offset, unless no message arrives.
  int talk_periods() const noexcept { return talk_periods_; }
  void restart() noexcept;

 private:
  struct Link {
    std::uint64_t seen = 0;  // number of the newest received message
    bool received = false, used = false;
    ReceivedMessage news{};
  };
  std::size_t place(int to, int from) const noexcept {
    return static_cast<std::size_t>(to) * parts_ + static_cast<std::size_t>(from);
  }
  ClockTime clock(int part, double t) const noexcept;

  ExchangeOptions options_;
  double dt_;
  std::size_t parts_, kept_;
  int talk_periods_;
  std::vector<std::vector<PartMessage>> sent_;  // latest messages of each part, by number
  std::vector<std::vector<double>> sent_at_;    // send times [s]
  std::vector<std::uint64_t> numbers_;          // messages sent, per part
  std::vector<Peers> peers_;
  std::vector<Link> links_;
};

}  // namespace sightline
