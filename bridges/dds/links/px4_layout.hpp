/// PX4 messages whose layout differs between releases, accessed by field name.
#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

#include "bridges/dds/topics/message_type.hpp"

namespace sightline::dds {

/// Descriptors of all PX4 messages of the bridge, each layout once.
std::span<const dds_topic_descriptor_t* const> px4_descriptors();

/// Layout of one message in a release. The layout in memory equals that on the wire.
class Px4Layout {
 public:
  /// @param message  "VehicleStatus", "VehicleLocalPosition", "FailsafeFlags", "BatteryStatus" or a
  ///   message with a single layout
  /// @throws std::invalid_argument if the bridge does not support the message
  Px4Layout(std::string_view message, int release);

  const MessageType& type() const { return type_; }
  const dds_topic_descriptor_t& descriptor() const { return descriptor_; }
  std::size_t size() const { return places_.back(); }  ///< on the wire [bytes]
  bool has(std::string_view field) const;
  /// Offset of the field [bytes].
  /// @throws std::invalid_argument if the message has no such field
  std::size_t place(std::string_view field) const;

 private:
  const MessageType& type_;
  const dds_topic_descriptor_t& descriptor_;
  std::vector<std::size_t> places_;
};

/// Reads a number at a byte offset of a message.
template <class Number>
Number read_at(const void* message, std::size_t place) noexcept {
  Number number;
  std::memcpy(&number, static_cast<const char*>(message) + place, sizeof number);
  return number;
}

/// A message whose fields are set by name; initially all zero.
class Px4Message {
 public:
  explicit Px4Message(const Px4Layout& layout)
      : layout_(layout), words_((layout.descriptor().m_size + 7) / 8) {}

  /// `Number` must match the field's type in the layout.
  template <class Number>
  void set(std::string_view field, Number number) {
    std::memcpy(reinterpret_cast<char*>(words_.data()) + layout_.place(field), &number, sizeof number);
  }
  const void* data() const { return words_.data(); }

 private:
  const Px4Layout& layout_;
  std::vector<std::uint64_t> words_;
};

}  // namespace sightline::dds
