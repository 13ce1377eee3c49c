/// Fault injection for simulated robots: in their reported motion and in their messages.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "bridges/dds/fleet/link_fault.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/conversion.hpp"
#include "sightline/world.hpp"

namespace sightline::dds {

class FaultyWriter;

/// Number of messages affected by each fault.
struct FaultCounts {
  std::int64_t dropped = 0, duplicated = 0, reordered = 0, not_finite = 0, requests_lost = 0;
  bool operator==(const FaultCounts&) const = default;
};

/// Faults of one simulated robot. Equal seeds, faults and messages give equal counts.
class Faults {
 public:
  explicit Faults(std::uint64_t seed)
      : seed_(seed), random_(seed, StreamId::fault, 0), of_requests_(seed, StreamId::fault, -1) {}
  Faults(const Faults&) = delete;
  Faults& operator=(const Faults&) = delete;

  // Any thread may call these.
  void begin(LinkFaultKind kind, double size);
  void begin(LinkFaultKind kind) { begin(kind, text_of(kind).fallback); }
  void end(LinkFaultKind kind);
  bool on(LinkFaultKind kind) const { return of(kind).on; }
  /// Whether the request that has come now is lost.
  bool loses_request();
  double size(LinkFaultKind kind) const { return of(kind).size; }
  /// Displacement of the faulty estimator [m].
  Vec3<double> shift() const;

  // Stepping thread only.
  /// Whether the fault began or ended since the last call.
  bool changed(LinkFaultKind kind);
  /// The motion as the faulty estimator reports it: frozen, offset, not finite.
  Motion distorted(Motion motion);
  /// Number of jumps that the estimator has reported.
  int resets() const { return resets_; }
  /// Sends the delayed messages that are due.
  void pass_on();
  FaultCounts counts() const;

 private:
  friend class FaultyWriter;
  struct One {
    std::atomic<bool> on{false};
    std::atomic<double> size{0.0};
    std::atomic<int> changes{0};
    int seen = 0;  // number of changes already handled
  };
  One& of(LinkFaultKind kind) { return all_[static_cast<std::size_t>(kind)]; }
  const One& of(LinkFaultKind kind) const { return all_[static_cast<std::size_t>(kind)]; }

  std::uint64_t seed_;
  RandomStream random_;
  std::array<One, link_fault_kinds> all_{};
  std::optional<Motion> frozen_;
  int resets_ = 0;
  mutable std::mutex lock_;  // guards the members below
  RandomStream of_requests_;
  std::vector<FaultyWriter*> writers_;
  int writers_made_ = 0;
  FaultCounts counts_;
};

/// "12 messages lost, 3 sent twice, ..."; empty: none.
std::string describe(const FaultCounts& counts);

/// Writer whose messages are lost, delayed, duplicated or reordered as the faults specify. Any
/// thread may call it.
class FaultyWriter {
 public:
  /// @param type    strings and sequences in its messages are not copied
  /// @param faults  must outlive it
  /// @throws std::runtime_error as RawWriter
  FaultyWriter(dds_entity_t participant, const dds_topic_descriptor_t& type, const std::string& topic,
               Quality quality, Faults& faults);
  ~FaultyWriter();

  /// @param pointed_to  owner of the message's strings and sequences; null: they stay unchanged while
  ///   the writer lives
  void write(const void* message, const std::shared_ptr<const void>& pointed_to = {});

 private:
  friend class Faults;
  struct Late {
    std::int64_t due;
    std::vector<std::uint64_t> message;
    std::shared_ptr<const void> pointed_to;
  };
  void pass_on(std::int64_t now);

  Faults& faults_;
  std::size_t size_;
  std::mutex lock_;  // guards the members below
  RandomStream random_;
  std::deque<Late> late_;  // in the order of writing
  RawWriter writer_;
};

}  // namespace sightline::dds
