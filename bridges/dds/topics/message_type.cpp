#include "bridges/dds/topics/message_type.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <stdexcept>

#include "bridges/dds/idl/idl_fields.hpp"
#include "bridges/dds/topics/sha256.hpp"

namespace sightline::dds {
namespace {

/// Simple IDL types: size in bytes, type number in ROS 2 type descriptions, PX4 name.
struct Simple {
  std::string_view word;
  std::size_t bytes;
  int id;
  std::string_view px4;
};
constexpr std::array<Simple, 14> simple_types = {{{"int8", 1, 2, "int8"},
                                                  {"uint8", 1, 3, "uint8"},
                                                  {"char", 1, 3, "char"},
                                                  {"int16", 2, 4, "int16"},
                                                  {"uint16", 2, 5, "uint16"},
                                                  {"int32", 4, 6, "int32"},
                                                  {"uint32", 4, 7, "uint32"},
                                                  {"int64", 8, 8, "int64"},
                                                  {"uint64", 8, 9, "uint64"},
                                                  {"float", 4, 10, "float32"},
                                                  {"double", 8, 11, "float64"},
                                                  {"boolean", 1, 15, "bool"},
                                                  {"octet", 1, 16, "byte"},
                                                  {"string", 0, 17, "string"}}};
constexpr int nested_id = 1, array_id = 48, sequence_id = 144;
constexpr std::string_view call_header = "rmw_cyclonedds/msg/CallHeader";

const Simple* simple(std::string_view word) {
  const auto found =
      std::find_if(simple_types.begin(), simple_types.end(), [&](const Simple& s) { return s.word == word; });
  return found != simple_types.end() ? &*found : nullptr;
}

bool all_digits(std::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// VehicleStatus_16_ -> VehicleStatus, Trigger_Request_ -> Trigger_Request.
std::string without_release(std::string_view structure) {
  std::string_view name = structure.substr(0, structure.size() - (structure.ends_with('_') ? 1 : 0));
  const std::size_t bar = name.rfind('_');
  if (bar != std::string_view::npos && all_digits(name.substr(bar + 1))) name = name.substr(0, bar);
  return std::string(name);
}

/// px4_msgs::msg::dds_::VehicleStatus_16_ -> px4_msgs/msg/VehicleStatus.
std::string ros_name(std::string_view idl_name) {
  const std::size_t first = idl_name.find("::"), second = idl_name.find("::", first + 2),
                    last = idl_name.rfind("::");
  return fmt::format("{}/{}/{}", idl_name.substr(0, first), idl_name.substr(first + 2, second - first - 2),
                     without_release(idl_name.substr(last + 2)));
}

const MessageType& named(const std::string& ros_name) {
  const auto& all = message_types();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const MessageType& t) { return t.name == ros_name; });
  if (found == all.end()) throw std::invalid_argument(fmt::format("{} is no message of ours", ros_name));
  return *found;
}

/// Collects the names of nested types, recursively.
void collect(const MessageType& type, std::set<std::string>& names) {
  for (const Field& field : type.fields)
    if (field.nested() && names.insert(field.type).second) collect(named(field.type), names);
}

std::string description(const MessageType& type) {
  std::string fields;
  for (const Field& field : type.fields) {
    const Simple* const s = simple(field.type);
    const int kind = field.many == Many::array ? array_id : field.many == Many::sequence ? sequence_id : 0;
    const int id = kind + (s != nullptr ? s->id : nested_id);
    fields += fmt::format(
        R"({}{{"name": "{}", "type": {{"type_id": {}, "capacity": {}, "string_capacity": 0, "nested_type_name": "{}"}}}})",
        fields.empty() ? "" : ", ", field.name, id, field.many == Many::array ? field.length : 0,
        s == nullptr ? field.type : "");
  }
  return fmt::format(R"({{"type_name": "{}", "fields": [{}]}})", type.name, fields);
}

}  // namespace

const std::vector<MessageType>& message_types() {
  static const std::vector<MessageType> all = [] {
    std::vector<MessageType> types;
    for (const auto& [message, type, name, many, length] : idl_fields) {
      if (types.empty() || types.back().idl_name != message)
        types.push_back({std::string(message), ros_name(message), {}});
      types.back().fields.push_back(
          {simple(type) != nullptr ? std::string(type) : ros_name(type), std::string(name), many, length});
    }
    return types;
  }();
  return all;
}

const MessageType& message_type(std::string_view idl_name) {
  const auto& all = message_types();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const MessageType& t) { return t.idl_name == idl_name; });
  if (found == all.end()) throw std::invalid_argument(fmt::format("{} is no message of ours", idl_name));
  return *found;
}

std::string wire_type(std::string_view idl_name) {
  const std::size_t last = idl_name.rfind("::") + 2;
  return fmt::format("{}{}_", idl_name.substr(0, last), without_release(idl_name.substr(last)));
}
std::string wire_topic(std::string_view topic) { return fmt::format("rt{}", topic); }
std::string wire_request(std::string_view service) { return fmt::format("rq{}Request", service); }
std::string wire_reply(std::string_view service) { return fmt::format("rr{}Reply", service); }

std::optional<std::vector<std::size_t>> payload_layout(const MessageType& type) {
  std::vector<std::size_t> places;
  std::size_t end = 0;
  for (const Field& field : type.fields) {
    const Simple* const s = simple(field.type);
    if (s == nullptr || s->bytes == 0 || field.many == Many::sequence) return std::nullopt;
    const std::size_t begin = (end + s->bytes - 1) / s->bytes * s->bytes;
    places.push_back(begin);
    end = begin + s->bytes * field.length;
  }
  places.push_back(end);
  return places;
}

std::optional<std::size_t> payload_size(const MessageType& type) {
  const auto places = payload_layout(type);
  return places ? std::optional(places->back()) : std::nullopt;
}

std::string type_hash(const MessageType& type) {
  if (type.fields.size() == 2 && type.fields[0].type == call_header)
    return type_hash(named(type.fields[1].type));
  std::set<std::string> names;
  collect(type, names);
  std::string referenced;
  for (const std::string& name : names)
    referenced += (referenced.empty() ? "" : ", ") + description(named(name));
  return "RIHS01_" + sha256(fmt::format(R"({{"type_description": {}, "referenced_type_descriptions": [{}]}})",
                                        description(type), referenced));
}

std::uint32_t px4_hash(const MessageType& type) {
  std::uint32_t hash = 0x811c9dc5;
  const auto add = [&](std::string_view text) {
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x01000193U;
  };
  for (const Field& field : type.fields) {
    const Simple* const s = simple(field.type);
    add(s != nullptr ? s->px4 : std::string_view(field.type));
    if (field.many == Many::array) add(fmt::format("[{}]", field.length));
    if (field.many == Many::sequence) add("[]");
    add(fmt::format(" {}\n", field.name));
  }
  return hash;
}

}  // namespace sightline::dds
