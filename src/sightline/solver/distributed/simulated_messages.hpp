/// The messages of a team that plans in parts, as a network would bring them: late, in another order, or not at all.
///
/// Everything is drawn from the seed, the two parts and the number of the message, so that a flight is the same each time.
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

/// What brings the messages of a flight whose parts plan in programs of their own.
enum class MessagesBy : std::uint8_t {
  network,
  simulation,  ///< the network, and then late and lost as they would be in simulation: to try it
};

/// How parts exchange what they predict.
struct ExchangeOptions {
  static constexpr std::string_view name = "exchange";

  double stale_after = 0.2;
  double speed_max = 1.5;
  // Of the simulated network.
  double delay = 0.01, jitter = 0.0, loss = 0.0, offset = 0.0;
  MessagesBy flown_by = MessagesBy::network;
  std::uint64_t seed = 1;  ///< of what is lost, and of the jitter

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

/// What a part received since its last update.
struct ReceivedMessage {
  const PartMessage* message = nullptr;  ///< the newest, if it is to be used; none: nothing came
  double time = 0.0;                     ///< of its first sights, by the receiver [s]
  bool ended = false;                    ///< what came before is too old now
};

/// In [0, 1), the same for the same: what happens to a message from one part to another.
enum class MessageChance : std::uint8_t { loss = 1, jitter };
double chance_of(MessageChance what, std::uint64_t seed, int to, int from, std::uint64_t sequence) noexcept;

/// Of all parts. Nothing allocates after construction. Parts may receive at the same time, and send at the same time.
class SimulatedMessages {
 public:
  /// @param said  the predictions of each part, sized
  SimulatedMessages(const ExchangeOptions& options, const Horizon& horizon,
                    std::span<const std::vector<Prediction>> said);

  /// Each part sends what it predicts from t on.
  void send(int part, double t, std::span<const Prediction> predictions) noexcept;
  /// A part takes what has come by t.
  void receive(int to, double t) noexcept;
  /// Of its last receive().
  ReceivedMessage news(int to, int from) const noexcept { return links_[place(to, from)].news; }
  bool receives_from(int to, int from) const noexcept { return links_[place(to, from)].received; }

  /// Whether anything was sent.
  bool begun() const noexcept { return numbers_.front() > 0; }
  /// After which two parts know each other's clock, unless nothing comes.
  int talk_periods() const noexcept { return talk_periods_; }
  void restart() noexcept;

 private:
  struct Link {
    std::uint64_t seen = 0;  // number of the newest message that came
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
  std::vector<std::vector<PartMessage>> sent_;  // the last of each part, by number
  std::vector<std::vector<double>> sent_at_;    // when [s]
  std::vector<std::uint64_t> numbers_;          // of messages, of each part
  std::vector<Peers> peers_;
  std::vector<Link> links_;
};

}  // namespace sightline
