/// Sinks of a test's own: one sample, used again each period.
#pragma once

#include <utility>
#include <vector>

#include "sightline/loop.hpp"

namespace sightline::test {

/// Takes samples and forgets them.
class SampleSink : public Sink<Sample> {
 public:
  explicit SampleSink(Sample prototype) : sample_(std::move(prototype)) {}
  Sample* claim() noexcept override { return &sample_; }
  void publish() noexcept override {}
  void close() noexcept override {}

 protected:
  Sample sample_;
};

/// Keeps all samples.
class AllSamples : public SampleSink {
 public:
  using SampleSink::SampleSink;
  void publish() noexcept override { all.push_back(sample_); }

  std::vector<Sample> all;
};

}  // namespace sightline::test
