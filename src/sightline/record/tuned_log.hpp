/// What was tuned in a flight, in its log: the events that came behind the scenario's own, as the scenario would say them.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "sightline/record/mcap.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// Writes the topic /tuned, {time, number, name, text}: each event as it happens, with its place behind those of the script.
class TunedLog {
 public:
  /// The words "sightline" of a log that has the topic say "tuned".
  static constexpr const char* word = "tuned";

  /// @param to  outlives it; a flight that is not tuned leaves it as it is
  TunedLog(const Scenario& scenario, MessageSink& to);
  void add(const Sample& sample);

 private:
  std::shared_ptr<const TunedScript> tuned_;
  std::size_t script_;  // events of it
  MessageSink& to_;
  std::optional<McapChannel> channel_{};
};

/// The [[event]]s that were tuned, to stand behind the scenario's text. One that could not be enters a stage of its own, so that every
/// event has the place that the log knows it by.
/// @throws std::runtime_error where the log cannot be read
std::string tuned_events(const std::filesystem::path& log);

}  // namespace sightline
