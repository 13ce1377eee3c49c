/// Exchange of predictions between the parts of a team over DDS: rt/sightline/TEAM/PART/prediction,
/// best effort, newest message only.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/conversion.hpp"
#include "sightline/base.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"
#include "sightline/solver/distributed/part_solver.hpp"

namespace sightline::dds {

/// Flight phase of a part.
enum class PartPhase : std::uint8_t { ground, rising, holding, task, landing };

/// ROS topic "/sightline/TEAM/PART/prediction".
std::string prediction_topic(std::string_view team, std::string_view part);

/// receive(), send(), stand(), all_hold(), begins(), receives_from() and is_received() run on the
/// control thread: they do not allocate, lock, throw or print. A separate thread writes the
/// messages.
class PredictionExchange final : public PartExchange {
 public:
  /// @param scenario  of one part
  /// @throws std::runtime_error if a topic cannot be created
  PredictionExchange(const Scenario& scenario, dds_entity_t participant);
  ~PredictionExchange();  ///< Waits until the last message is sent.
  PredictionExchange(const PredictionExchange&) = delete;
  PredictionExchange& operator=(const PredictionExchange&) = delete;

  /// Time 0 of the flight, of the monotonic clock.
  void begin(Nanoseconds origin) noexcept { origin_ = origin; }
  void receive(double t, Subteam& receiver) noexcept override;
  void send(double t, std::span<const Prediction> predictions) noexcept override;
  /// Outside the task: publishes where the part's robots are, extrapolated by their velocity; these
  /// robots keep no distances. Also processes the received messages.
  void stand(PartPhase phase, std::span<const double> states) noexcept;
  /// Whether every part that is received has reached its holding phase.
  bool all_hold() const noexcept;
  /// Start of the task by the monotonic clock, as agreed with the parts that hold. Once all hold,
  /// each part proposes a time and the earliest proposal applies. None before.
  std::optional<Nanoseconds> begins() const noexcept { return begins_; }
  /// Names of the parts that it waits for, as text.
  std::string awaited() const;

  bool receives_from(BodyId robot, BodyId other) const noexcept override;
  bool is_received(BodyId body) const noexcept override;

  /// State changes of other parts since the last call, one sentence each; single thread.
  std::vector<std::string> news();
  /// Counts of sent, received and lost messages, one line per part.
  std::vector<std::string> counts() const;

 private:
  struct OtherPart {
    std::string name;
    std::vector<BodyId> robots;  // indices in our team, in the part's order
    std::vector<std::string> names;
    std::unique_ptr<SpscQueue<PartMessage>> came;  // filled by the receive thread
    PartMessage newest;
    bool has_newest = false;
    bool used = false;                                // the planner has it
    std::atomic<PeerState> state{PeerState::silent};  // at the last drain()
    std::atomic<std::int64_t> offset{0};              // of its clock [ns]
    PeerState received = PeerState::silent;
    std::atomic<std::int64_t> garbled{0};
    std::unique_ptr<RawReader> reader{};  // last member: destroyed before the members it fills
  };

  void take(OtherPart& from, const void* message, const Arrival& arrival);
  void drain() noexcept;
  bool waits_for(int part) const noexcept;
  void agree(PartPhase phase) noexcept;
  Nanoseconds delay_of(const PartMessage& message) const noexcept;
  PartMessage* claim(ClockTime stamp, PartPhase phase, bool steers) noexcept;
  void write_all();

  Team team_;
  int own_;
  double step_;
  Nanoseconds period_;
  std::size_t stages_;
  std::vector<std::string> parts_;
  std::vector<std::unique_ptr<OtherPart>> others_;  // one per part; our own entry stays empty
  std::vector<int> part_of_;                        // per body; -1: in no part
  std::vector<BodyId> robots_;                      // of our own part
  std::vector<double> no_input_;
  ExchangeOptions exchange_;
  Peers peers_;
  Nanoseconds origin_ = 0;
  std::optional<Nanoseconds> begins_;
  std::uint64_t session_, number_ = 0;
  std::atomic<std::int64_t> sent_{0};
  RawWriter writer_;
  SpscQueue<PartMessage> waiting_;                       // messages to be written
  ServiceThread thread_{"the messages to other parts"};  // last member: uses all others
};

}  // namespace sightline::dds
