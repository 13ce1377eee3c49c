/// Discovered writers and readers of a domain, and findings about a robot.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bridges/dds/fleet/finding.hpp"
#include "bridges/dds/topics/channel.hpp"

namespace sightline::dds {

/// Writers and readers of a domain at one time, our own included.
struct Surroundings {
  std::vector<SeenWriter> writers, readers;

  /// Writers of a topic.
  /// @param topic  as on the wire
  std::vector<const SeenWriter*> writers_of(std::string_view topic) const {
    std::vector<const SeenWriter*> all;
    for (const SeenWriter& writer : writers)
      if (writer.topic == topic) all.push_back(&writer);
    return all;
  }
};

/// Reason why no message arrives on a topic, as the end of a sentence.
inline std::string why_nothing_comes(const RawReader& reader, const Surroundings& around) {
  const std::vector<const SeenWriter*> writers = around.writers_of(reader.topic());
  if (writers.empty()) return "it has no publisher";
  const auto other = std::find_if(writers.begin(), writers.end(),
                                  [&](const SeenWriter* writer) { return writer->type != reader.type(); });
  if (other != writers.end()) return fmt::format("it is written as {}", (*other)->type);
  return "nothing comes from who writes it";
}

/// Reason why no reader receives our messages, as the end of a sentence.
inline std::string why_stale(const RawWriter& writer, const Surroundings& around) {
  const auto other =
      std::find_if(around.readers.begin(), around.readers.end(), [&](const SeenWriter& reader) {
        return reader.topic == writer.topic() && reader.type != writer.type();
      });
  return other == around.readers.end() ? "it has no subscriber"
                                       : fmt::format("it is read as {}", other->type);
}

/// Snapshots of the discovered endpoints, at any rate. Single thread.
class DiscoveryMonitor {
 public:
  /// @throws std::runtime_error if the built-in topics cannot be read
  explicit DiscoveryMonitor(dds_entity_t participant)
      : writers_(participant), readers_(participant, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION) {}
  Surroundings look() { return {writers_.look(), readers_.look()}; }

 private:
  WriterList writers_, readers_;
};

/// Findings about one robot, in order of insertion.
class FindingList {
 public:
  explicit FindingList(std::string robot) : robot_(std::move(robot)) {}

  template <class... Args>
  void add(Aspect aspect, Light light, fmt::format_string<Args...> format, Args&&... args) {
    findings_.push_back({robot_, aspect, light, fmt::format(format, std::forward<Args>(args)...)});
  }
  /// Adds a green finding if the aspect has no finding yet.
  template <class... Args>
  void add_green(Aspect aspect, fmt::format_string<Args...> format, Args&&... args) {
    if (!has(aspect)) add(aspect, Light::green, format, std::forward<Args>(args)...);
  }
  bool has(Aspect aspect) const {
    return std::any_of(findings_.begin(), findings_.end(),
                       [&](const Finding& finding) { return finding.aspect == aspect; });
  }
  /// Returns the findings, sorted by aspect.
  std::vector<Finding> take() {
    std::stable_sort(findings_.begin(), findings_.end(),
                     [](const Finding& a, const Finding& b) { return a.aspect < b.aspect; });
    return std::move(findings_);
  }

 private:
  std::string robot_;
  std::vector<Finding> findings_;
};

}  // namespace sightline::dds
