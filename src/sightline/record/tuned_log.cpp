#include "sightline/record/tuned_log.hpp"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/log.hpp"
#include "sightline/record/log_table.hpp"

namespace sightline {
namespace {

constexpr LogTopic tuned_topic = log_topic("/tuned");

nlohmann::json json_of(const McapMessage& message) {
  return nlohmann::json::parse(
      std::string_view(reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()));
}

}  // namespace

TunedLog::TunedLog(const Scenario& scenario, MessageSink& to)
    : tuned_(scenario.tuned), script_(scenario.script.events.size()), to_(to) {
  if (tuned_ == nullptr) return;
  channel_ = tuned_topic.open(to, tuned_topic.add_schema(to));
}

void TunedLog::add(const Sample& sample) {
  if (!channel_) return;
  for (int i = 0; i < sample.event_count; ++i) {
    const Event& event = sample.events[size(i)];
    if (event.kind != EventKind::event_occurred || event.value < static_cast<double>(script_)) continue;
    const std::size_t number = static_cast<std::size_t>(event.value) - script_;
    if (number >= tuned_->size()) continue;
    const std::string message = json_text(nlohmann::ordered_json{{"time", event.time},
                                                                 {"number", number},
                                                                 {"name", tuned_->event(number).name},
                                                                 {"text", tuned_->text(number, event.time)}});
    to_.message(channel_->id, channel_->sequence++, nanoseconds(sample.time),
                std::as_bytes(std::span(message)));
  }
}

std::string tuned_events(const std::filesystem::path& log) {
  McapReader mcap(log);
  std::map<std::size_t, std::pair<double, std::string>> texts;
  std::set<double> ignored;
  std::size_t script = 0;
  try {
    mcap.visit([&](const McapMessage& message) {
      if (message.topic == tuned_topic.topic) {
        const nlohmann::json reported = json_of(message);
        texts[reported.at("number").get<std::size_t>()] = {reported.at("time").get<double>(),
                                                           reported.at("text").get<std::string>()};
      } else if (message.topic == "/events") {
        const nlohmann::json reported = json_of(message);
        if (reported.at("kind").get<std::string>() == to_string(EventKind::event_ignored))
          ignored.insert(reported.at("value").get<double>());
      }
    });
    const auto words = mcap.metadata().find("sightline");
    if (words != mcap.metadata().end())
      script =
          nlohmann::json::parse(words->second.at("team")).value("events", nlohmann::json::array()).size();
  } catch (const std::exception& error) {
    throw std::runtime_error(
        fmt::format("{}: what was tuned cannot be read: {}", log.string(), sentence_of(error)));
  }
  if (!mcap.ok()) throw std::runtime_error(mcap.error());
  std::string text;
  for (const auto& [number, reported] : texts) {
    const bool was_ignored = ignored.contains(static_cast<double>(script + number));
    text += was_ignored ? fmt::format("\n[[event]]\nat = {}\nenter = \"tuned:{}\"\n", reported.first, number)
                        : reported.second;
  }
  return text;
}

}  // namespace sightline
