/// A copy of a run's log in which some messages are other ones.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "sightline/log.hpp"

namespace sightline::test {

/// @param edit  changes the text of a message of a topic, or empties it, which leaves it out
inline void copy_log(const std::filesystem::path& from, const std::filesystem::path& to,
                     const std::function<void(std::string_view topic, std::string& text)>& edit) {
  McapReader reader(from);
  McapWriter writer(to, "ros2", "copy");
  for (const auto& [name, words] : reader.metadata()) writer.metadata(name, words);
  std::map<std::string, ChannelId, std::less<>> channels;
  std::string text;
  reader.visit([&](const McapMessage& message) {
    auto channel = channels.find(message.topic);
    if (channel == channels.end()) {
      const SchemaId schema = writer.schema(message.schema, "jsonschema", "{}");
      channel =
          channels.emplace(message.topic, writer.channel(schema, message.topic, message.encoding, {})).first;
    }
    text.assign(reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size());
    if (message.encoding == "json") edit(message.topic, text);
    if (!text.empty())
      writer.message(channel->second, message.sequence, message.log_time, std::as_bytes(std::span(text)));
  });
  writer.close();
}

}  // namespace sightline::test
