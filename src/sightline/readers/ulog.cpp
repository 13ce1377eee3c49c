#include "sightline/readers/ulog.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>
#include <type_traits>

#include "sightline/base.hpp"
#include "sightline/base/nearest.hpp"
#include "sightline/readers/packed_file.hpp"

namespace sightline {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as ULog stores them");
using namespace std::string_view_literals;

constexpr std::string_view ulog_magic = "ULog\x01\x12\x35";
constexpr std::string_view sync_bytes = "\x2f\x73\x13\x20\x25\x0c\xbb\x12";
constexpr std::size_t file_header = 16, message_header = 3, id_size = 2;  // [bytes]
constexpr std::size_t message_max = 65535, nested_max = 16;
constexpr std::size_t definitions_max = std::size_t{1}
                                        << 20;  // fields, keys and topics: each takes 100 bytes or more

/// Basic types; a field of any other type has the fields of the format with that name.
enum class Basic { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64, truth, character };
struct BasicType {
  std::string_view name;
  std::size_t size;  // [bytes]
};
constexpr std::array<BasicType, 12> basic_types = {{{"int8_t", 1},
                                                    {"uint8_t", 1},
                                                    {"int16_t", 2},
                                                    {"uint16_t", 2},
                                                    {"int32_t", 4},
                                                    {"uint32_t", 4},
                                                    {"int64_t", 8},
                                                    {"uint64_t", 8},
                                                    {"float", 4},
                                                    {"double", 8},
                                                    {"bool", 1},
                                                    {"char", 1}}};

std::optional<std::size_t> basic_type(std::string_view name) {
  for (std::size_t i = 0; i < basic_types.size(); ++i)
    if (basic_types[i].name == name) return i;
  return {};
}

template <class T>
T number_at(const char* at) {
  T value{};
  std::memcpy(&value, at, sizeof(T));
  return value;
}

/// The number at a place; empty if T does not hold every number of the type.
template <class T>
std::optional<T> value_at(const char* at, std::size_t type) {
  const auto as = [at]<class Stored>(Stored) -> std::optional<T> {
    constexpr bool holds = std::is_floating_point_v<T> ||
                           (std::is_integral_v<Stored> &&
                            (std::is_signed_v<T> ? std::is_signed_v<Stored> || sizeof(Stored) < sizeof(T)
                                                 : std::is_unsigned_v<Stored>));
    if constexpr (holds) return static_cast<T>(number_at<Stored>(at));
    return std::nullopt;
  };
  switch (static_cast<Basic>(type)) {
    case Basic::i8:
      return as(std::int8_t{});
    case Basic::u8:
    case Basic::truth:
    case Basic::character:
      return as(std::uint8_t{});
    case Basic::i16:
      return as(std::int16_t{});
    case Basic::u16:
      return as(std::uint16_t{});
    case Basic::i32:
      return as(std::int32_t{});
    case Basic::u32:
      return as(std::uint32_t{});
    case Basic::i64:
      return as(std::int64_t{});
    case Basic::u64:
      return as(std::uint64_t{});
    case Basic::f32:
      return as(float{});
    case Basic::f64:
      return as(double{});
  }
  return {};
}

bool is_name(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '/';
  });
}

/// The part of `text` before a mark, which is removed from it with the mark.
std::string_view taken_before(std::string_view& text, char mark) {
  const std::size_t end = std::min(text.find(mark), text.size());
  const std::string_view part = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return part;
}

/// A type with its array length, of `least` at least: "float[3]"; empty if it is none.
struct ArrayType {
  std::string_view type;
  std::size_t count = 1;
  bool is_array = false;
};
std::optional<ArrayType> array_type(std::string_view text, std::size_t least = 1) {
  ArrayType read{text.substr(0, text.find('['))};
  if (!is_name(read.type)) return {};
  text.remove_prefix(read.type.size());
  if (text.empty()) return read;
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + text.size(), read.count);
  if (error != std::errc() ||
      std::string_view(end, static_cast<std::size_t>(text.data() + text.size() - end)) != "]" ||
      read.count < least || read.count > message_max)
    return {};
  read.is_array = true;
  return read;
}

}  // namespace

std::string ULog::Topic::shown() const {
  return instance == 0 ? name : fmt::format("{}[{}]", name, instance);
}

/// Reads the messages of a log one after the other.
class ULog::Parser {
 public:
  explicit Parser(ULog& log) : log_(log), topic_of_id_(message_max + 1, none) {}

  void run() {
    const std::string_view magic(log_.bytes_.data(), std::min(log_.bytes_.size(), ulog_magic.size()));
    if (magic != ulog_magic.substr(0, magic.size()) || magic.empty())
      refuse(0, "the file does not begin as ULogs do");
    if (log_.bytes_.size() < file_header) {
      log_.truncated_ = true;
      return;
    }
    std::size_t at = file_header;
    read_section(at, log_.bytes_.size(), true);
    // Sections that were appended after a crash begin where the flags say; the one before may be cut.
    for (std::size_t i = 0; i < appended_.size(); ++i)
      read_section(appended_[i], i + 1 < appended_.size() ? appended_[i + 1] : log_.bytes_.size(), false);
  }

 private:
  static constexpr std::size_t none = ~std::size_t{0};

  /// Counts what takes more memory than the file.
  void define(std::size_t at) {
    if (++definitions_ > definitions_max)
      refuse(at, fmt::format("more than {} fields, keys and topics", definitions_max));
  }

  [[noreturn]] void refuse(std::size_t at, std::string_view what) const {
    throw_invalid("{}: byte {}: {}", log_.file_, at, what);
  }

  void read_section(std::size_t at, std::size_t end, bool first) {
    for (bool begins = first; at < end; begins = false) {
      if (end - at < message_header) {
        log_.truncated_ = true;
        return;
      }
      const auto size = number_at<std::uint16_t>(&log_.bytes_[at]);
      const char kind = log_.bytes_[at + 2];
      if (end - at - message_header < size) {
        if (!is_kind(kind)) refuse_kind(at, kind);
        log_.truncated_ = true;
        return;
      }
      read_message(at, kind, std::string_view(log_.bytes_).substr(at + message_header, size), begins);
      if (begins && !appended_.empty()) end = std::min(end, appended_.front());
      at += message_header + size;
    }
  }

  /// Kinds that later versions add are letters, too; a reader leaves them out.
  static bool is_kind(char kind) { return (kind >= 'A' && kind <= 'Z') || (kind >= 'a' && kind <= 'z'); }
  [[noreturn]] void refuse_kind(std::size_t at, char kind) const {
    refuse(at, fmt::format("a message of kind {:#04x}, expected a letter", static_cast<unsigned char>(kind)));
  }

  void read_message(std::size_t at, char kind, std::string_view content, bool first) {
    const auto need = [&](std::size_t least) {
      if (content.size() < least)
        refuse(at,
               fmt::format("a message {} of {} bytes, expected at least {}", kind, content.size(), least));
    };
    switch (kind) {
      case 'B':
        need(40);
        if (!first) refuse(at, "flag bits, expected them in the first message alone");
        return read_flags(at, content);
      case 'F':
        return read_format(at, content);
      case 'I':
        need(2);
        return read_info(at, content, false);
      case 'M':
        need(3);
        return read_info(at, content.substr(1), content[0] != 0);
      case 'P':
        need(2);
        return read_parameter(at, content);
      case 'A':
        need(4);
        return subscribe(at, content);
      case 'R':
        need(id_size);
        topic_of_id_[number_at<std::uint16_t>(content.data())] = none;
        return;
      case 'D':
        need(id_size);
        return read_data(at, content);
      case 'S':
        if (content != sync_bytes) refuse(at, "a synchronisation mark with other bytes than its own");
        return;
      case 'O':
        need(2);
        log_.dropouts_.push_back(number_at<std::uint16_t>(content.data()));
        return;
      default:
        if (!is_kind(kind)) refuse_kind(at, kind);
    }
  }

  void read_flags(std::size_t at, std::string_view content) {
    const std::string_view incompatible = content.substr(8, 8);
    const bool known = (static_cast<unsigned char>(incompatible[0]) & ~1U) == 0 &&
                       incompatible.substr(1) == "\0\0\0\0\0\0\0"sv;
    if (!known) refuse(at, "flags of a newer format that this reader does not know");
    if (incompatible[0] == 0) return;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto offset = number_at<std::uint64_t>(content.data() + 16 + 8 * i);
      if (offset == 0) return;
      const std::size_t after = appended_.empty() ? at + message_header + content.size() : appended_.back();
      if (offset < after)
        refuse(at, fmt::format("data appended at byte {}, expected at byte {} or later", offset, after));
      if (offset > log_.bytes_.size()) {
        log_.truncated_ = true;
        return;
      }
      appended_.push_back(static_cast<std::size_t>(offset));
    }
  }

  void read_format(std::size_t at, std::string_view content) {
    const std::string_view name = taken_before(content, ':');
    if (!is_name(name)) refuse(at, "a format without a name");
    Format format;
    while (!content.empty()) {
      std::string_view text = taken_before(content, ';');
      if (text.empty()) continue;
      const std::optional<ArrayType> type = array_type(taken_before(text, ' '));
      if (!type || !is_name(text))
        refuse(at, fmt::format("a field of the format {} that has no type and name", name));
      define(at);
      format.fields.push_back({std::string(type->type), std::string(text), type->count, type->is_array});
    }
    if (format.fields.empty()) refuse(at, fmt::format("the format {} has no fields", name));
    const auto [known, is_new] = log_.formats_.try_emplace(std::string(name), std::move(format));
    if (!is_new) refuse(at, fmt::format("the format {} is defined twice", name));
  }

  /// Determines the size of a format and of those that it is made of.
  Format& sized(std::size_t at, std::string_view name, std::size_t depth) {
    const auto known = log_.formats_.find(name);
    if (known == log_.formats_.end())
      refuse(at, fmt::format("the type {}, which no format before defines", name));
    Format& format = known->second;
    if (format.size > 0) return format;
    if (depth > nested_max)
      refuse(at, fmt::format("the format {} nests more than {} formats", name, nested_max));
    std::size_t size = 0, least = 0;
    for (const Field& field : format.fields) {
      const std::optional<std::size_t> basic = basic_type(field.type);
      const std::size_t one = basic ? basic_types[*basic].size : sized(at, field.type, depth + 1).size;
      size += one * field.count;
      if (!field.name.starts_with("_padding")) least = size;
      if (size > message_max)
        refuse(at, fmt::format("the format {} has more than {} bytes", name, message_max));
    }
    format.size = size, format.least = least;
    return format;
  }

  void subscribe(std::size_t at, std::string_view content) {
    const auto id = number_at<std::uint16_t>(content.data() + 1);
    const std::string name(content.substr(3));
    if (!is_name(name)) refuse(at, "a subscription without a name");
    Format& format = sized(at, name, 0);
    if (!format.has_time) {
      const Place time = log_.place_of(name, "timestamp");
      format.has_time = time.found && static_cast<Basic>(time.type) == Basic::u64;
    }
    if (!format.has_time) refuse(at, fmt::format("the format {} has no uint64_t timestamp", name));
    const int instance = static_cast<unsigned char>(content[0]);
    const auto [known, is_new] = log_.topic_of_.try_emplace({name, instance}, log_.topics_.size());
    if (is_new) {
      define(at);
      log_.topics_.push_back({name, instance});
      least_.push_back(format.least), most_.push_back(format.size);
    }
    if (topic_of_id_[id] != none && topic_of_id_[id] != known->second)
      refuse(at, fmt::format("{} under the number {}, which {} has", name, id,
                             log_.topics_[topic_of_id_[id]].shown()));
    topic_of_id_[id] = known->second;
  }

  void read_data(std::size_t at, std::string_view content) {
    const auto id = number_at<std::uint16_t>(content.data());
    const std::size_t topic = topic_of_id_[id], size = content.size() - id_size;
    if (topic == none) refuse(at, fmt::format("data of the number {}, to which no topic belongs", id));
    if (size < least_[topic] || size > most_[topic])
      refuse(at,
             fmt::format("{} bytes of {}, expected {}", size, log_.topics_[topic].shown(), least_[topic]));
    log_.topics_[topic].at.push_back(static_cast<std::uint32_t>(at + message_header + id_size));
  }

  struct Pair {
    ArrayType type;
    std::string_view name, value;
  };
  Pair read_pair(std::size_t at, std::string_view content) const {
    const std::size_t length = static_cast<unsigned char>(content[0]);
    if (length > content.size() - 1)
      refuse(at, fmt::format("a key of {} bytes where {} are left", length, content.size() - 1));
    std::string_view key = content.substr(1, length);
    // PX4 logs empty texts, char[0], and keys with a dash, perf_counter_preflight-00.
    const std::optional<ArrayType> type = array_type(taken_before(key, ' '), 0);
    const bool printable =
        !key.empty() && std::all_of(key.begin(), key.end(), [](char c) { return c > ' ' && c <= '~'; });
    if (!type || !printable) refuse(at, "a key that has no type and name");
    return {*type, key, content.substr(1 + length)};
  }

  void read_info(std::size_t at, std::string_view content, bool continues) {
    const Pair pair = read_pair(at, content);
    define(at);
    const std::optional<std::size_t> type = basic_type(pair.type.type);
    std::string text;
    if (pair.type.type == "char") {
      text = pair.value;
    } else if (type && pair.value.size() == basic_types[*type].size * pair.type.count) {
      for (std::size_t i = 0; i < pair.type.count; ++i)
        text += fmt::format("{}{}", i > 0 ? " " : "",
                            *value_at<double>(&pair.value[i * basic_types[*type].size], *type));
    } else {
      return;  // of a type that a later version adds
    }
    std::vector<std::string>& texts = log_.info_[std::string(pair.name)];
    if (continues && !texts.empty()) {
      texts.back() += text;
    } else {
      texts.push_back(std::move(text));
    }
  }

  void read_parameter(std::size_t at, std::string_view content) {
    const Pair pair = read_pair(at, content);
    define(at);
    const std::optional<std::size_t> type = basic_type(pair.type.type);
    if (!type || pair.type.is_array || pair.value.size() != basic_types[*type].size)
      refuse(at, fmt::format("the parameter {}, expected one number", pair.name));
    log_.parameters_[std::string(pair.name)] = *value_at<double>(pair.value.data(), *type);
  }

  ULog& log_;
  std::vector<std::size_t> topic_of_id_, least_, most_;
  std::vector<std::size_t> appended_;  // where sections begin [bytes]
  std::size_t definitions_ = 0;
};

ULog::ULog(std::string bytes, std::string file) : bytes_(std::move(bytes)), file_(std::move(file)) {
  Parser(*this).run();
}

const ULog::Topic* ULog::find(std::string_view name, int instance) const {
  const auto found = topic_of_.find({std::string(name), instance});
  return found == topic_of_.end() ? nullptr : &topics_[found->second];
}

const ULog::Topic& ULog::topic(std::string_view name, int instance) const {
  if (const Topic* const found = find(name, instance)) return *found;
  std::vector<std::string_view> known;
  for (const Topic& one : topics_) known.push_back(one.name);
  throw_invalid("{}: no topic {}, expected a logged one{}", file_, Topic{std::string(name), instance}.shown(),
                hint(name, known));
}

std::size_t ULog::size_of(const Field& field) const {
  const std::optional<std::size_t> basic = basic_type(field.type);
  return basic ? basic_types[*basic].size : formats_.find(field.type)->second.size;
}

ULog::Place ULog::place_of(std::string_view format, std::string_view path) const {
  const std::string_view first = path.substr(0, path.find_first_of("[."));
  path.remove_prefix(first.size());
  Place place;
  for (const Field& field : formats_.find(format)->second.fields) {
    const std::size_t one = size_of(field);
    if (field.name != first) {
      place.offset += one * field.count;
      continue;
    }
    if (field.is_array) {
      std::size_t element = 0;
      if (!path.starts_with('[')) return {};
      const auto [end, error] = std::from_chars(path.data() + 1, path.data() + path.size(), element);
      path.remove_prefix(static_cast<std::size_t>(end - path.data()));
      if (error != std::errc() || !path.starts_with(']') || element >= field.count) return {};
      path.remove_prefix(1);
      place.offset += one * element;
    }
    if (const std::optional<std::size_t> basic = basic_type(field.type)) {
      place.type = *basic;
      place.found = path.empty();
      return place;
    }
    if (!path.starts_with('.')) return {};
    const Place inner = place_of(field.type, path.substr(1));
    return {place.offset + inner.offset, inner.type, inner.found};
  }
  return {};
}

std::vector<std::string_view> ULog::fields_of(const Topic& topic) const {
  std::vector<std::string_view> names;
  for (const Field& field : formats_.find(topic.name)->second.fields) names.push_back(field.name);
  return names;
}

bool ULog::has(const Topic& topic, std::string_view field) const { return place_of(topic.name, field).found; }

template <class T>
std::vector<T> ULog::column(const Topic& topic, std::string_view field) const {
  const Place place = place_of(topic.name, field);
  const bool stored =
      place.found && place.offset + basic_types[place.type].size <= formats_.find(topic.name)->second.least;
  if (!stored)
    throw_invalid("{}: {} has no number {}, expected a field of it{}", file_, topic.shown(), field,
                  hint(field, fields_of(topic)));
  std::vector<T> values;
  values.reserve(topic.at.size());
  for (const std::uint32_t at : topic.at) {
    const std::optional<T> value = value_at<T>(&bytes_[at + place.offset], place.type);
    if (!value)
      throw_invalid("{}: {} of {} is of the type {}, expected {}", file_, field, topic.shown(),
                    basic_types[place.type].name,
                    std::is_unsigned_v<T> ? "an unsigned whole number" : "a whole number");
    values.push_back(*value);
  }
  return values;
}

template std::vector<double> ULog::column(const Topic&, std::string_view) const;
template std::vector<std::int64_t> ULog::column(const Topic&, std::string_view) const;
template std::vector<std::uint64_t> ULog::column(const Topic&, std::string_view) const;

ULog read_ulog(const std::filesystem::path& file) { return {read_packed_file(file), file.native()}; }

}  // namespace sightline
