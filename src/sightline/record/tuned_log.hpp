/// Events that were tuned during a flight, in the log as scenario text.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "sightline/log.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// Writes the topic /tuned, {time, number, name, text}: each tuned event when it occurs; `number`
/// counts from 0 after the events of the script.
class TunedLog {
 public:
  /// Key in the metadata "sightline" of a log with this topic.
  static constexpr const char* word = "tuned";

  /// @param to  must outlive this object; a flight without tuning adds no topic
  TunedLog(const Scenario& scenario, MessageSink& to);
  void add(const Sample& sample);

 private:
  std::shared_ptr<const TunedScript> tuned_;
  std::size_t script_;  // number of events in the script
  MessageSink& to_;
  std::optional<McapChannel> channel_{};
};

/// Text of the tuned [[event]]s, to append to the scenario's text. A rejected event becomes one
/// that enters a stage of its own; so every event keeps its index in the log.
/// @throws std::runtime_error if the log cannot be read
std::string tuned_events(const std::filesystem::path& log);

}  // namespace sightline
