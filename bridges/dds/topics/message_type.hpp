/// Message types of the IDL: names, sizes and hashes on the wire.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sightline::dds {

enum class Many { one, array, sequence };

struct Field {
  std::string type;  ///< IDL type "float", "string", or a message type "std_msgs/msg/Header"
  std::string name;
  Many many = Many::one;
  std::size_t length = 1;  ///< of an array

  bool nested() const { return type.find('/') != std::string::npos; }
  bool operator==(const Field&) const = default;
};

struct MessageType {
  std::string idl_name;  ///< px4_msgs::msg::dds_::VehicleStatus_16_; the name in the descriptor
  std::string name;      ///< ROS 2 name, px4_msgs/msg/VehicleStatus
  std::vector<Field> fields;
};

/// All message types of the bridge.
const std::vector<MessageType>& message_types();
/// One of message_types().
/// @param idl_name  as MessageType::idl_name
/// @throws std::invalid_argument if there is none of this name
const MessageType& message_type(std::string_view idl_name);

/// Type name on the wire, without the release suffix: px4_msgs::msg::dds_::VehicleStatus_.
std::string wire_type(std::string_view idl_name);
/// "rt/a/b" of the topic /a/b.
std::string wire_topic(std::string_view topic);
/// "rq/a/sRequest" and "rr/a/sReply" of the service /a/s.
std::string wire_request(std::string_view service);
std::string wire_reply(std::string_view service);

/// Offset of each field in an XCDR1 payload without header, followed by the end of the last field
/// [bytes]. None for a message with strings, sequences or nested messages.
std::optional<std::vector<std::size_t>> payload_layout(const MessageType& type);
/// Payload size of such a message [bytes], before padding to a multiple of 4.
std::optional<std::size_t> payload_size(const MessageType& type);

/// ROS 2 type hash since Iron (REP 2016): RIHS01_ and 64 hexadecimal digits.
std::string type_hash(const MessageType& type);
/// Hash of PX4's message_format_response: FNV-1a over "type name\n" of each field.
std::uint32_t px4_hash(const MessageType& type);

}  // namespace sightline::dds
