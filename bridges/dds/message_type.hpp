/// What the messages are made of, read from the IDL that they are compiled from: names, sizes and hashes on the wire.
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
  std::string type;  ///< of IDL: "float", "string"; or a message, "std_msgs/msg/Header"
  std::string name;
  Many many = Many::one;
  std::size_t length = 1;  ///< of an array

  bool nested() const { return type.find('/') != std::string::npos; }
  bool operator==(const Field&) const = default;
};

struct MessageType {
  std::string idl_name;  ///< px4_msgs::msg::dds_::VehicleStatus_16_; what a descriptor is called
  std::string name;      ///< px4_msgs/msg/VehicleStatus, as ROS 2 says it
  std::vector<Field> fields;
};

/// The messages of an IDL: modules of ROS 2's form, structs of numbers, strings, arrays, sequences and structs before them.
/// @throws std::invalid_argument with the line, for what is none of that
std::vector<MessageType> parse_idl(std::string_view idl);

/// All that the bridge speaks, parsed once.
const std::vector<MessageType>& message_types();
/// Among them.
/// @param idl_name  as MessageType::idl_name
/// @throws std::invalid_argument for none of them
const MessageType& message_type(std::string_view idl_name);

/// The name of the type on the wire: without the ending that says a release, px4_msgs::msg::dds_::VehicleStatus_.
std::string wire_type(std::string_view idl_name);
/// "rt/a/b" of the topic /a/b.
std::string wire_topic(std::string_view topic);
/// "rq/a/sRequest" and "rr/a/sReply" of the service /a/s.
std::string wire_request(std::string_view service);
std::string wire_reply(std::string_view service);

/// Where each field begins in a payload of XCDR1, without its header, and where the last one ends [bytes]; none of a message with
/// strings, sequences or other messages in it.
std::optional<std::vector<std::size_t>> payload_layout(const MessageType& type);
/// Of such a message [bytes], before it is filled up to a multiple of 4.
std::optional<std::size_t> payload_size(const MessageType& type);

/// RIHS01_ and 64 hexadecimal digits: the type's hash from ROS 2 Iron on (REP 2016).
std::string type_hash(const MessageType& type);
/// The hash of PX4's message_format_response, FNV-1a over "type name\n" of each field.
std::uint32_t px4_hash(const MessageType& type);

}  // namespace sightline::dds
