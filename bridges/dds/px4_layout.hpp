/// Messages of PX4 whose layout differs between releases, by the names of their fields.
#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

#include "bridges/dds/message_type.hpp"

namespace sightline::dds {

/// Of all messages of PX4 that are spoken, each layout once.
std::span<const dds_topic_descriptor_t* const> px4_descriptors();

/// One message in the layout of a release. In memory a message lies as on the wire.
class Px4Layout {
 public:
  /// @param message  "VehicleStatus", "VehicleLocalPosition", "FailsafeFlags", "BatteryStatus" or a message of one layout
  /// @throws std::invalid_argument for one that nobody speaks
  Px4Layout(std::string_view message, int release);

  const MessageType& type() const { return type_; }
  const dds_topic_descriptor_t& descriptor() const { return descriptor_; }
  std::size_t size() const { return places_.back(); }  ///< on the wire [bytes]
  bool has(std::string_view field) const;
  /// Where the field begins [bytes].
  /// @throws std::invalid_argument for a field that it does not have
  std::size_t place(std::string_view field) const;

 private:
  const MessageType& type_;
  const dds_topic_descriptor_t& descriptor_;
  std::vector<std::size_t> places_;
};

/// A number at a place of a message.
template <class Number>
Number read_at(const void* message, std::size_t place) noexcept {
  Number number;
  std::memcpy(&number, static_cast<const char*>(message) + place, sizeof number);
  return number;
}

/// A message to be filled by the names of its fields; all zero.
class Px4Message {
 public:
  explicit Px4Message(const Px4Layout& layout)
      : layout_(layout), words_((layout.descriptor().m_size + 7) / 8) {}

  /// Of the type that the layout says.
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
