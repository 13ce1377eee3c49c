/// Sinks between a flight and its log: they show the flight and end it.
#pragma once

#include <algorithm>
#include <atomic>

#include "bridges/dds/fleet/bridge.hpp"
#include "sightline/loop.hpp"
#include "sightline/server/flight_page.hpp"

namespace sightline::cli {

/// Shows each sample on a page.
class ShownSink final : public Sink<Sample> {
 public:
  ShownSink(Sink<Sample>& sink, FlightPage& page) : sink_(sink), page_(page) {}

  Sample* claim() noexcept override { return sample_ = sink_.claim(); }
  bool takes_between() const noexcept override { return sink_.takes_between(); }
  Sample* claim_between() noexcept override { return sample_ = sink_.claim_between(); }
  void publish() noexcept override {
    if (sample_->of == Sample::Of::update) page_.show(*sample_);
    sink_.publish();
  }
  void drop(const Sample& sample) noexcept override {
    page_.show(sample);
    sink_.drop(sample);
  }
  void close() noexcept override { sink_.close(); }
  bool is_abandoned() const noexcept override { return sink_.is_abandoned(); }

 private:
  Sink<Sample>& sink_;
  FlightPage& page_;
  Sample* sample_ = nullptr;
};

/// Publishes each period, and ends the flight if the fallback of a robot requires landing or a
/// landing is requested. The link then lands all robots.
class LinkedSink final : public Sink<Sample> {
 public:
  /// @param stop  ends the loop
  LinkedSink(Sink<Sample>& sink, LinkedWorld& world, std::atomic<bool>& stop)
      : sink_(sink), world_(world), stop_(stop) {}

  Sample* claim() noexcept override { return sample_ = sink_.claim(); }
  bool takes_between() const noexcept override { return sink_.takes_between(); }
  Sample* claim_between() noexcept override { return sample_ = sink_.claim_between(); }
  void publish() noexcept override {
    if (sample_->of == Sample::Of::update) look(*sample_);
    sink_.publish();
  }
  void drop(const Sample& sample) noexcept override {
    look(sample);
    sink_.drop(sample);
  }
  void close() noexcept override { sink_.close(); }
  bool is_abandoned() const noexcept override { return sink_.is_abandoned(); }

  /// Whether a fallback level required landing because its data were too old.
  bool too_old() const { return too_old_; }

 private:
  void look(const Sample& sample) noexcept {
    const auto lands = [](FallbackLevel level) { return level >= FallbackLevel::land; };
    too_old_ = too_old_ || std::any_of(sample.levels.begin(), sample.levels.end(), lands);
    if (too_old_ || world_.requested_to_land()) stop_.store(true, std::memory_order_relaxed);
    world_.show(sample);
  }

  Sink<Sample>& sink_;
  LinkedWorld& world_;
  std::atomic<bool>& stop_;
  Sample* sample_ = nullptr;
  bool too_old_ = false;
};

}  // namespace sightline::cli
