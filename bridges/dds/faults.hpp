/// What goes wrong at a robot that is stood in for: in what it says, and on the way out.
#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/conversion.hpp"
#include "sightline/scenario/link_fault.hpp"
#include "sightline/world/disturbance.hpp"

namespace sightline::dds {

class FaultyWriter;

/// How many messages it happened to.
struct FaultCounts {
  std::int64_t dropped = 0, duplicated = 0, reordered = 0, not_finite = 0;
  bool operator==(const FaultCounts&) const = default;
};

/// Of one robot, for as long as it is stood in for. The same seed, faults and messages give the same counts.
class Faults {
 public:
  explicit Faults(std::uint64_t seed) : seed_(seed), random_(seed, StreamId::fault, 0) {}
  Faults(const Faults&) = delete;
  Faults& operator=(const Faults&) = delete;

  // Of any thread.
  void begin(LinkFaultKind kind, double size);
  void begin(LinkFaultKind kind) { begin(kind, text_of(kind).fallback); }
  void end(LinkFaultKind kind);
  bool on(LinkFaultKind kind) const { return of(kind).on; }
  double size(LinkFaultKind kind) const { return of(kind).size; }

  // Of the thread that steps the robot.
  /// Whether it began or ended since this was asked last.
  bool changed(LinkFaultKind kind);
  /// What its estimator says of a motion: frozen, off, not finite.
  Motion said(Motion motion);
  /// How often it told that it jumped.
  int resets() const { return resets_; }
  /// Sends what was late and is due.
  void pass_on();
  FaultCounts counts() const;

 private:
  friend class FaultyWriter;
  struct One {
    std::atomic<bool> on{false};
    std::atomic<double> size{0.0};
    std::atomic<int> changes{0};
    int seen = 0;  // of the changes
  };
  One& of(LinkFaultKind kind) { return all_[static_cast<std::size_t>(kind)]; }
  const One& of(LinkFaultKind kind) const { return all_[static_cast<std::size_t>(kind)]; }

  std::uint64_t seed_;
  RandomStream random_;
  std::array<One, link_fault_kinds> all_{};
  std::optional<Motion> frozen_;
  int resets_ = 0;
  mutable std::mutex lock_;  // of those below
  std::vector<FaultyWriter*> writers_;
  int writers_made_ = 0;
  FaultCounts counts_;
};

/// "12 messages lost, 3 twice, ..."; empty: none.
std::string in_words(const FaultCounts& counts);

/// A writer whose messages are lost, late, twice or out of order, as the faults say. Of any thread.
class FaultyWriter {
 public:
  /// @param type  strings and sequences in its messages are not copied: they stay as they are while the writer lives
  /// @param faults  outlives it
  /// @throws std::runtime_error as RawWriter
  FaultyWriter(dds_entity_t participant, const dds_topic_descriptor_t& type, const std::string& topic,
               Quality quality, Faults& faults);
  ~FaultyWriter();

  void write(const void* message);

 private:
  friend class Faults;
  struct Late {
    std::int64_t due;
    std::vector<std::uint64_t> message;
  };
  void pass_on(std::int64_t now);

  Faults& faults_;
  std::size_t size_;
  std::mutex lock_;  // of all below
  RandomStream random_;
  std::deque<Late> late_;  // in the order in which they were written
  RawWriter writer_;
};

}  // namespace sightline::dds
