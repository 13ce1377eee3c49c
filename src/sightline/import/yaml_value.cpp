#include "sightline/import/yaml_value.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

namespace sightline {
namespace {

constexpr std::size_t scalar_max = 128;  // [bytes]

std::size_t line_of(const YAML::Mark& mark) { return static_cast<std::size_t>(std::max(0, mark.line)) + 1; }

/// Refuses a nesting that the recursion of the parser could not bear.
class DepthCheck final : public YAML::EventHandler {
 public:
  explicit DepthCheck(const std::string& file) : file_(file) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark& at, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    enter(at);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& at, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    enter(at);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void enter(const YAML::Mark& at) {
    if (++depth_ > import_depth_max)
      throw ScenarioError(file_, line_of(at), fmt::format("nested deeper than {} levels", import_depth_max));
  }

  const std::string& file_;
  int depth_ = 0;
};

/// The only document of a text. LoadAll() of yaml-cpp does not end where a bracket is closed twice.
YAML::Node parsed(const std::string& text, const std::string& file) {
  try {
    DepthCheck check(file);
    std::istringstream in(text);
    YAML::Parser parser(in);
    const bool one = parser.HandleNextDocument(check);
    if (one && !parser.HandleNextDocument(check)) return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw ScenarioError(file, line_of(error.mark), fmt::format("cannot be read as YAML ({})", error.msg));
  }
  throw ScenarioError(file, 1, "this is not one YAML document, expected a file of another program");
}

}  // namespace

std::string read_import_text(const std::filesystem::path& file) {
  std::string text = read_text(file);
  if (text.size() > import_size_max)
    throw ScenarioError(file.native(), 1,
                        fmt::format("too large, expected at most {} bytes", import_size_max));
  return text;
}

YamlValue::YamlValue(std::string_view text, std::string file)
    : file_(std::make_shared<const std::string>(std::move(file))) {
  if (text.size() > import_size_max)
    throw ScenarioError(*file_, 1, fmt::format("too large, expected at most {} bytes", import_size_max));
  if (text.find('\0') != std::string_view::npos)
    throw ScenarioError(*file_, 1, "the control character 0x00, expected text");
  node_.reset(parsed(std::string(text), *file_));
  if (!node_.IsMap()) throw ScenarioError(*file_, 1, "expected a mapping of keys to values (YAML)");
}

YamlValue::YamlValue(const YamlValue& parent, YAML::Node node, const std::string& key)
    : file_(parent.file_),
      node_(std::move(node)),
      path_(parent.path_.empty() || key.starts_with('[') ? parent.path_ + key : parent.path_ + "." + key),
      line_(parent.line()) {}

std::size_t YamlValue::line() const {
  const YAML::Mark mark = node_.Mark();
  return mark.is_null() || mark.line < 0 ? line_ : line_of(mark);
}

std::optional<YamlValue> YamlValue::find(std::string_view key) const {
  if (!node_.IsMap()) return std::nullopt;
  for (const auto& entry : node_) {
    if (!entry.first.IsScalar() || entry.first.Scalar() != key) continue;
    if (entry.second.IsNull()) return std::nullopt;
    return YamlValue(*this, entry.second, std::string(key));
  }
  return std::nullopt;
}

std::optional<YamlValue> YamlValue::find_path(std::span<const std::string_view> keys) const {
  if (keys.empty()) return *this;
  const std::optional<YamlValue> value = find(keys.front());
  return value ? value->find_path(keys.subspan(1)) : std::nullopt;
}

YamlValue YamlValue::at(std::string_view key, std::string_view expected) const {
  if (const std::optional<YamlValue> value = find(key)) return *value;
  throw ScenarioError(
      *file_, line(),
      fmt::format("{}{}{} is missing, expected {}", path_, path_.empty() ? "" : ".", key, expected));
}

std::vector<std::pair<std::string, YamlValue>> YamlValue::entries(std::string_view expected) const {
  if (!node_.IsMap() || node_.size() > import_entries_max) throw_invalid(expected);
  std::vector<std::pair<std::string, YamlValue>> all;
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    if (!entry.first.IsScalar()) throw_invalid(expected);
    const std::string& key = entry.first.Scalar();
    YamlValue value(*this, entry.second, key);
    if (!seen.insert(key).second) value.throw_invalid("each key once");
    all.emplace_back(key, std::move(value));
  }
  return all;
}

std::vector<YamlValue> YamlValue::items(std::string_view expected) const {
  if (!node_.IsSequence() || node_.size() > import_entries_max) throw_invalid(expected);
  std::vector<YamlValue> all;
  for (const auto& item : node_) all.push_back({*this, item, fmt::format("[{}]", all.size())});
  return all;
}

double YamlValue::number(const Range& range) const {
  double value = 0.0;
  if (!node_.IsScalar()) throw_invalid(range.expected);
  std::string_view digits = node_.Scalar();
  if (digits.starts_with('+')) digits.remove_prefix(1);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value) ||
      !range.holds(value))
    throw_invalid(range.expected);
  return value;
}

std::int64_t YamlValue::integer(std::int64_t low, std::int64_t high) const {
  const std::string expected = fmt::format("an integer from {} to {}", low, high);
  const double value = number({static_cast<double>(low), static_cast<double>(high), expected});
  if (value != std::floor(value)) throw_invalid(expected);
  return static_cast<std::int64_t>(value);
}

bool YamlValue::boolean() const {
  constexpr std::array<std::string_view, 3> yes = {"true", "True", "TRUE"}, no = {"false", "False", "FALSE"};
  const std::string_view word = node_.IsScalar() ? std::string_view(node_.Scalar()) : "";
  if (std::find(yes.begin(), yes.end(), word) != yes.end()) return true;
  if (std::find(no.begin(), no.end(), word) == no.end()) throw_invalid("true or false");
  return false;
}

std::string YamlValue::text(std::string_view expected) const {
  if (!node_.IsScalar() || node_.Scalar().empty() || node_.Scalar().size() > scalar_max ||
      one_line(node_.Scalar()) != node_.Scalar())
    throw_invalid(expected);
  return node_.Scalar();
}

std::vector<double> YamlValue::numbers(std::size_t length, const Range& range) const {
  if (is_map()) {
    const YamlValue data = at("data", "the numbers of the matrix");
    if (data.is_map()) data.throw_invalid("a list of numbers");  // an alias may name its own map
    return data.numbers(length, range);
  }
  const std::string expected =
      length > 0 ? fmt::format("{} numbers", length) : std::string("a list of numbers");
  const std::vector<YamlValue> all = items(expected);
  if (length > 0 && all.size() != length) throw_invalid(expected);
  std::vector<double> values;
  for (const YamlValue& one : all) values.push_back(one.number(range));
  return values;
}

std::string YamlValue::value_text() const {
  constexpr std::size_t shown = 60;
  if (node_.IsScalar()) return shortened(node_.Scalar(), shown);
  if (node_.IsSequence()) return fmt::format("[... {} items]", node_.size());
  return node_.IsMap() ? "{...}" : "null";
}

void YamlValue::throw_invalid(std::string_view expected) const {
  throw ScenarioError(*file_, line(), fmt::format("{} = {}, expected {}", path_, value_text(), expected));
}

}  // namespace sightline
