/// Passes samples on to a log.
#pragma once

#include <functional>
#include <utility>

#include "sightline/loop.hpp"

namespace sightline::test {

/// Passes each sample on after `seen`, which may change it.
class PassingSink final : public Sink<Sample> {
 public:
  PassingSink(Sink<Sample>& log, std::function<void(Sample&)> seen) : log_(log), seen_(std::move(seen)) {}
  Sample* claim() noexcept override { return sample_ = log_.claim(); }
  bool takes_between() const noexcept override { return log_.takes_between(); }
  Sample* claim_between() noexcept override { return sample_ = log_.claim_between(); }
  void publish() noexcept override {
    seen_(*sample_);
    log_.publish();
  }
  void close() noexcept override { log_.close(); }
  bool is_abandoned() const noexcept override { return log_.is_abandoned(); }

 private:
  Sink<Sample>& log_;
  std::function<void(Sample&)> seen_;
  Sample* sample_ = nullptr;
};

}  // namespace sightline::test
