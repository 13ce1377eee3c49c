/// Keeps what would go into a log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/log.hpp"

namespace sightline::test {

/// A message with what tells how it is to be read.
struct KeptMessage {
  std::string topic, encoding, schema;
  std::uint64_t time;
  std::string bytes;
  bool operator==(const KeptMessage&) const = default;
};

inline std::string kept_bytes(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

class KeepingSink final : public MessageSink {
 public:
  SchemaId schema(std::string_view name, std::string_view, std::string_view text) override {
    schemas.push_back({std::string(name), std::string(text)});
    return SchemaId{static_cast<std::uint16_t>(schemas.size() - 1)};
  }
  ChannelId channel(SchemaId schema, std::string_view topic, std::string_view encoding,
                    const McapWords&) override {
    channels.push_back({std::string(topic), std::string(encoding), static_cast<std::size_t>(schema)});
    return ChannelId{static_cast<std::uint16_t>(channels.size() - 1)};
  }
  void message(ChannelId channel, std::uint32_t, std::uint64_t log_time,
               std::span<const std::byte> bytes) override {
    const Channel& of = channels.at(static_cast<std::size_t>(channel));
    messages.push_back({of.topic, of.encoding, schemas[of.schema].name, log_time, kept_bytes(bytes)});
  }

  struct Schema {
    std::string name, text;
  };
  struct Channel {
    std::string topic, encoding;
    std::size_t schema;
  };
  std::vector<Schema> schemas;
  std::vector<Channel> channels;
  std::vector<KeptMessage> messages;
};

}  // namespace sightline::test
