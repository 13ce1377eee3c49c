#include "bridges/dds/topics/message_type.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <map>
#include <set>
#include <stdexcept>

#include "bridges/dds/idl/idl_texts.hpp"
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

class IdlParser {
 public:
  explicit IdlParser(std::string_view text) : text_(text) { next(); }

  std::vector<MessageType> parse() {
    while (!token_.empty()) {
      if (token_ == "#") {  // skips #include: all messages share one list
        rest_of_line();
      } else if (token_ == "module") {
        next();
        modules_.push_back(word());
        expect("{");
      } else if (token_ == "struct") {
        structure();
      } else if (token_ == "}" && !modules_.empty()) {
        next();
        expect(";");
        modules_.pop_back();
      } else {
        throw_invalid("module, struct or }");
      }
    }
    if (!modules_.empty()) throw_invalid("the end of module " + modules_.back());
    return std::move(types_);
  }

 private:
  [[noreturn]] void throw_invalid(std::string_view expected) const {
    throw std::invalid_argument(
        fmt::format("idl:{}: {}, expected {}", line_, token_.empty() ? "the end" : token_, expected));
  }
  void next() {
    skip_blank();
    const std::size_t from = at_;
    const auto of_word = [&](std::size_t i) {
      const unsigned char c = static_cast<unsigned char>(text_[i]);
      return std::isalnum(c) != 0 || c == '_' || c == ':';
    };
    while (at_ < text_.size() && of_word(at_)) ++at_;
    if (at_ == from && at_ < text_.size()) ++at_;
    token_ = text_.substr(from, at_ - from);
  }
  void skip_blank() {
    for (; at_ < text_.size(); ++at_) {
      if (text_.substr(at_, 2) == "//") at_ = std::min(text_.find('\n', at_), text_.size());
      if (at_ == text_.size()) return;
      if (text_[at_] == '\n')
        ++line_;
      else if (std::isspace(static_cast<unsigned char>(text_[at_])) == 0)
        return;
    }
  }
  void rest_of_line() {
    at_ = std::min(text_.find('\n', at_), text_.size());
    next();
  }
  void expect(std::string_view token) {
    if (token_ != token) throw_invalid(token);
    next();
  }
  std::string word() {
    if (token_.empty() || (std::isalpha(static_cast<unsigned char>(token_[0])) == 0)) throw_invalid("a name");
    std::string name(token_);
    next();
    return name;
  }

  void structure() {
    next();
    MessageType type;
    for (const std::string& module : modules_) type.idl_name += module + "::";
    type.idl_name += word();
    if (modules_.size() != 3) throw_invalid("a struct in module PACKAGE { module msg { module dds_ {");
    type.name = ros_name(type.idl_name);
    expect("{");
    while (token_ != "}") fields(type);
    next();
    expect(";");
    types_.push_back(std::move(type));
  }

  void fields(MessageType& type) {
    Field field;
    if (token_ == "sequence") {
      next();
      expect("<");
      field.many = Many::sequence;
      field.type = type_word();
      expect(">");
    } else {
      field.type = type_word();
    }
    const Many many = field.many;
    for (bool more = true; more;) {
      field.name = word();
      field.many = many;
      field.length = 1;
      if (token_ == "[") {
        next();
        if (!all_digits(token_) || many == Many::sequence) throw_invalid("the length of an array");
        std::from_chars(token_.data(), token_.data() + token_.size(), field.length);
        field.many = Many::array;
        next();
        expect("]");
      }
      type.fields.push_back(field);
      more = token_ == ",";
      if (more) next();
    }
    expect(";");
  }

  std::string type_word() {
    std::string name = word();
    if (simple(name) != nullptr) return name;
    if (name.find("::") == std::string::npos) throw_invalid("a simple type, or a message by its whole name");
    return ros_name(name);
  }

  std::string_view text_, token_;
  std::size_t at_ = 0;
  int line_ = 1;
  std::vector<std::string> modules_;
  std::vector<MessageType> types_;
};

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

std::vector<MessageType> parse_idl(std::string_view idl) { return IdlParser(idl).parse(); }

const std::vector<MessageType>& message_types() {
  static const std::vector<MessageType> all = [] {
    std::vector<MessageType> types;
    for (const std::string_view text : idl_texts) {
      std::vector<MessageType> more = parse_idl(text);
      types.insert(types.end(), more.begin(), more.end());
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
