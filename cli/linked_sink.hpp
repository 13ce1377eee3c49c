/// Sinks between a flight and its log.
#pragma once

#include <atomic>
#include <cstddef>

#include "bridges/dds/fleet/bridge.hpp"
#include "sightline/loop.hpp"

namespace sightline::cli {

/// Watches each period of a flight on its way to the log.
class WatchingSink : public Sink<Sample> {
 public:
  explicit WatchingSink(Sink<Sample>& sink) : sink_(sink) {}

  Sample* claim() noexcept override { return sample_ = sink_.claim(); }
  bool takes_between() const noexcept override { return sink_.takes_between(); }
  Sample* claim_between() noexcept override { return sample_ = sink_.claim_between(); }
  void publish() noexcept override {
    if (sample_->of == Sample::Of::update) watch(*sample_);
    sink_.publish();
  }
  void drop(const Sample& sample) noexcept override {
    watch(sample);
    sink_.drop(sample);
  }
  void close() noexcept override { sink_.close(); }
  bool is_abandoned() const noexcept override { return sink_.is_abandoned(); }

 private:
  virtual void watch(const Sample& sample) noexcept = 0;

  Sink<Sample>& sink_;
  Sample* sample_ = nullptr;
};

/// Publishes each period, and ends the flight if the fallback of a robot of the team requires
/// landing or a landing is requested. The link then lands all robots.
class LinkedSink final : public WatchingSink {
 public:
  /// @param stop  ends the loop
  LinkedSink(Sink<Sample>& sink, LinkedWorld& world, std::atomic<bool>& stop)
      : WatchingSink(sink), world_(world), stop_(stop) {}

  /// Whether a fallback level required landing because its data were too old.
  bool too_old() const { return too_old_; }

 private:
  void watch(const Sample& sample) noexcept override {
    for (std::size_t i = 0; i < sample.levels.size(); ++i) {
      const Presence presence = sample.presence[i];
      const bool flies = presence == Presence::steered || presence == Presence::hold;
      too_old_ = too_old_ || (flies && sample.levels[i] >= FallbackLevel::land);
    }
    if (too_old_ || world_.requested_to_land()) stop_.store(true, std::memory_order_relaxed);
    world_.show(sample);
  }

  LinkedWorld& world_;
  std::atomic<bool>& stop_;
  bool too_old_ = false;
};

}  // namespace sightline::cli
