/// The exchange of one part of a team with the others, over DDS: rt/sightline/TEAM/PART/prediction, best effort, the newest counts.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/conversion.hpp"
#include "sightline/base/service_thread.hpp"
#include "sightline/run/spsc_queue.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/solver/distributed/part_solver.hpp"

namespace sightline::dds {

/// How far a part is.
enum class PartPhase : std::uint8_t { ground, rising, holding, task, landing };

/// "/sightline/TEAM/PART/prediction", a topic of ROS.
std::string prediction_topic(std::string_view team, std::string_view part);

/// receive(), send(), stand() and the questions are the control thread's: they allocate, lock, throw and print nothing. Messages are
/// written by a thread of its own.
class PredictionExchange final : public PartExchange {
 public:
  /// @param scenario  of a part
  /// @throws std::runtime_error where a topic cannot be had
  PredictionExchange(const Scenario& scenario, dds_entity_t participant);
  ~PredictionExchange();  ///< Once the last is sent.
  PredictionExchange(const PredictionExchange&) = delete;
  PredictionExchange& operator=(const PredictionExchange&) = delete;

  /// Time 0 of the flight, of the monotonic clock.
  void begin(Nanoseconds origin) noexcept { origin_ = origin; }
  void receive(double t, Subteam& receiver) noexcept override;
  void send(double t, std::span<const Prediction> predictions) noexcept override;
  /// Beside the task: where the own robots are, going on as they move; they keep no distances. Takes what came, too.
  void stand(PartPhase phase, std::span<const double> states) noexcept;
  /// Whether no part that is heard is still on its way to where it holds.
  bool all_hold() const noexcept;
  /// When the task begins, by the monotonic clock, as agreed with those that hold: once all do, each says when, and the earliest
  /// that one of them said counts. None before.
  std::optional<Nanoseconds> begins() const noexcept { return begins_; }
  /// The parts that it waits for, in words.
  std::string awaited() const;

  bool receives_from(BodyId robot, BodyId other) const noexcept override;
  bool is_received(BodyId body) const noexcept override;

  /// What became of other parts since the last call, a sentence each; by one thread.
  std::vector<std::string> news();
  /// What was sent, received and lost, a line for each part.
  std::vector<std::string> counts() const;

 private:
  struct OtherPart {
    std::string name;
    std::vector<BodyId> robots;  // of our team, in the order of the part
    std::vector<std::string> names;
    std::unique_ptr<SpscQueue<PartMessage>> came;  // filled by the thread that receives
    PartMessage newest;
    bool has_newest = false;
    bool used = false;                                // the planner has it
    std::atomic<PeerState> state{PeerState::silent};  // at the last look
    std::atomic<std::int64_t> offset{0};              // of its clock [ns]
    PeerState received = PeerState::silent;
    std::atomic<std::int64_t> garbled{0};
    std::unique_ptr<RawReader> reader{};  // last: it ends before what it fills
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
  std::vector<std::unique_ptr<OtherPart>> others_;  // of each part; of our own: nothing
  std::vector<int> part_of_;                        // of each body; -1: of none
  std::vector<BodyId> robots_;                      // our own
  std::vector<double> no_input_;
  ExchangeOptions exchange_;
  Peers peers_;
  Nanoseconds origin_ = 0;
  std::optional<Nanoseconds> begins_;
  std::uint64_t session_, number_ = 0;
  std::atomic<std::int64_t> sent_{0};
  RawWriter writer_;
  SpscQueue<PartMessage> waiting_;                       // to be written
  ServiceThread thread_{"the messages to other parts"};  // last: it uses all of it
};

}  // namespace sightline::dds
