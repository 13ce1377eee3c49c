#include "sightline/scenario/templates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <sstream>

#include "sightline/base.hpp"
#include "sightline/scenario/layers.hpp"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 3> sections = {"agent", "target", "obstacle"};

/// The numbered names of "uav{00..31}".
std::optional<std::vector<std::string>> names_of(std::string_view text) {
  const std::size_t open = text.find('{'), dots = text.find("..", open), close = text.find('}', dots);
  if (open == text.npos || dots == text.npos || close == text.npos) return {};
  const auto number = [](std::string_view digits) -> std::optional<int> {
    int value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool whole = error == std::errc() && end == digits.data() + digits.size() && value >= 0;
    return whole && digits.size() <= 6 ? std::optional(value) : std::nullopt;
  };
  const std::string_view low = text.substr(open + 1, dots - open - 1),
                         high = text.substr(dots + 2, close - dots - 2);
  const auto first = number(low), last = number(high);
  if (!first || !last || *first > *last || *last - *first >= range_max) return {};
  const std::size_t width = low.size() > 1 && low[0] == '0' ? low.size() : 0;
  std::vector<std::string> names;
  for (int i = *first; i <= *last; ++i)
    names.push_back(fmt::format("{}{:0{}}{}", text.substr(0, open), i, width, text.substr(close + 1)));
  return names;
}

/// Rounds placements to readable numbers: millimetres and microradians.
double rounded(double value, double per_unit) { return std::round(value * per_unit) / per_unit + 0.0; }

/// One of the robots of a range, with its index.
class Instance {
 public:
  Instance(const TomlDocument& document, int index, int count)
      : document_(document), index_(index), count_(count) {}

  /// Replaces the tables { place = ... }, { face = ... } and { each = [...] } by values.
  void fill(toml::table& robot, const std::string& path) {
    if (toml::table* start = robot["start"].as_table()) find_start(*start, path + ".start");
    fill_all(robot, path);
  }

 private:
  void find_start(toml::table& start, const std::string& path) {
    const toml::node* p = start.get("p");
    if (p == nullptr) return;
    if (p->is_table() && p->as_table()->contains("place")) {
      start_ = place(TomlTable(document_, *p->as_table(), path + ".p"));
      return;
    }
    if (auto value = value_of(*p, path + ".p")) start.insert_or_assign("p", std::move((*value)[0]));
    const toml::array* numbers = start["p"].as_array();
    if (numbers != nullptr && numbers->size() == 3 && numbers->is_homogeneous() && (*numbers)[0].is_number())
      start_ = TomlTable(document_, start, path).vec3("p");
  }

  void fill_all(toml::node& node, const std::string& path) {
    if (toml::table* table = node.as_table()) {
      for (auto&& [key, inner] : *table) {
        const std::string name(key.str()), below = fmt::format("{}.{}", path, name);
        if (name == "robot") continue;  // its states have names of their own
        if (auto value = value_of(inner, below)) {
          table->insert_or_assign(name, std::move((*value)[0]));
        } else {
          fill_all(inner, below);
        }
      }
    } else if (toml::array* array = node.as_array()) {
      for (std::size_t i = 0; i < array->size(); ++i) {
        const std::string below = fmt::format("{}[{}]", path, i);
        if (auto value = value_of((*array)[i], below)) {
          array->replace(array->cbegin() + static_cast<std::ptrdiff_t>(i), std::move((*value)[0]));
        } else {
          fill_all((*array)[i], below);
        }
      }
    }
  }

  /// The value of a placement, as the only item of an array; none for any other node.
  std::optional<toml::array> value_of(const toml::node& node, const std::string& path) const {
    const toml::table* table = node.as_table();
    if (table == nullptr) return {};
    const TomlTable at(document_, *table, path);
    if (at.has("place")) {
      const Vec3<double> p = place(at);
      toml::array holder;
      holder.push_back(toml::array{rounded(p.x, 1e3), rounded(p.y, 1e3), rounded(p.z, 1e3)});
      return holder;
    }
    if (at.has("face")) return toml::array{heading(at)};
    if (!at.has("each")) return {};
    at.expect_only({"each"});
    const toml::array* each = (*table)["each"].as_array();
    if (each == nullptr || each->size() != size(count_))
      at.throw_invalid("each", fmt::format("a list of {}, one for each robot", count_));
    toml::array holder;
    holder.push_back((*each)[sightline::at(index_)]);
    return holder;
  }

  Vec3<double> place(const TomlTable& at) const {
    constexpr std::array<std::string_view, 3> kinds = {"line", "circle", "grid"};
    const std::string_view kind = at.word("place", kinds);
    const double i = index_;
    if (kind == "line") {
      at.expect_only({"place", "from", "to"});
      const Vec3<double> from = at.vec3("from"), to = at.vec3("to");
      return from + (count_ > 1 ? i / (count_ - 1) : 0.0) * (to - from);
    }
    if (kind == "circle") {
      at.expect_only({"place", "centre", "radius", "from"});
      const double radius = at.number("radius", positive("> 0 m")),
                   from = at.has("from") ? at.number("from") : 0.0,
                   angle = from + 2 * std::numbers::pi * i / count_;
      return at.vec3("centre") + radius * Vec3<double>{std::cos(angle), std::sin(angle), 0.0};
    }
    at.expect_only({"place", "corner", "step", "columns"});
    const Vec3<double> step = at.vec3("step");
    const auto columns = static_cast<int>(at.integer("columns", 1, range_max));
    const int column = index_ % columns, row = index_ / columns;
    return at.vec3("corner") + Vec3<double>{step.x * column, step.y * row, step.z * i};
  }

  double heading(const TomlTable& at) const {
    at.expect_only({"face"});
    const std::vector<double> to = at.numbers("face", 2);
    if (!start_) at.throw_invalid("face", "a start.p of three numbers or a place, from which it is faced");
    const double x = to[0] - start_->x, y = to[1] - start_->y;
    if (x == 0 && y == 0) at.throw_invalid("face", "another point than the start");
    return rounded(std::atan2(y, x), 1e6);
  }

  const TomlDocument& document_;
  int index_, count_;
  std::optional<Vec3<double>> start_;  // not rounded
};

/// Adds the keys that a table lacks. Tables that select one of several are taken whole.
void merge(toml::table& into, toml::table&& from) {
  constexpr std::array<std::string_view, 4> by_key = {"start", "parameters", "sensor", "sensors"};
  for (auto&& [key, node] : from) {
    toml::node* own = into.get(key.str());
    if (own == nullptr) {
      into.insert_or_assign(toml::key(key), std::move(node));
    } else if (own->is_table() && node.is_table() &&
               std::find(by_key.begin(), by_key.end(), key.str()) != by_key.end()) {
      merge(*own->as_table(), std::move(*node.as_table()));
    }
  }
}

/// Whether a table needs no expansion, so that a document without templates stays unchanged.
bool stands_for_itself(const toml::node& node) {
  if (const toml::table* table = node.as_table()) {
    for (const std::string_view word : {"inherits", "place", "face", "each"}) {
      if (table->contains(word)) return false;
    }
    return std::all_of(table->begin(), table->end(), [](const auto& entry) {
      return entry.first.str().find_first_of("{}") == std::string_view::npos &&
             stands_for_itself(entry.second);
    });
  }
  if (const toml::array* array = node.as_array()) {
    return std::all_of(array->begin(), array->end(), [](const toml::node& item) {
      return stands_for_itself(item) && !(item.is_string() && names_of(item.as_string()->get()));
    });
  }
  return true;
}

class Expansion {
 public:
  explicit Expansion(TomlDocument& document) : document_(document), root_(document) {
    for (const auto& [name, at] : root_.named_tables("template")) templates_.push_back(name);
  }

  void run() {
    for (const std::string_view section : sections) expand_section(std::string(section));
    for (const auto& [name, at] : root_.named_tables("template")) {
      if (!used_.contains(name)) at.throw_invalid("a robot, target, obstacle or template that inherits it");
    }
    document_.root.erase("template");
    for (auto&& [key, node] : document_.root) {
      if (std::find(sections.begin(), sections.end(), key.str()) == sections.end())
        expand_lists(node, std::string(key.str()));
    }
  }

 private:
  void expand_section(const std::string& section) {
    if (!root_.has(section)) return;
    const TomlTable all = root_.table(section);
    toml::table& into = *document_.root[section].as_table();
    toml::table expanded;
    for (const std::string& name : all.keys()) {
      const TomlTable at = all.table(name);
      const auto range = names_of(name);
      if (!range && name.find_first_of("{}") != name.npos)
        at.throw_invalid(fmt::format("a name, or a range of at most {} as in \"uav{{0..7}}\"", range_max));
      const std::vector<std::string> names = range.value_or(std::vector{name});
      if (!range && stands_for_itself(*into[name].as_table())) {
        expanded.insert_or_assign(key_of(into, name, 0, name), std::move(*into[name].as_table()));
        continue;
      }
      for (std::size_t i = 0; i < names.size(); ++i) {
        // Each robot from a parse of its own: moved nodes keep their lines, copied ones lose them.
        TomlDocument own = as_written(document_);
        toml::table robot = std::move(*own.root[section][name].as_table());
        const std::string path = fmt::format("{}.{}", section, names[i]);
        inherit(robot, own, TomlTable(document_, *into[name].as_table(), path), {});
        Instance(document_, static_cast<int>(i), static_cast<int>(names.size())).fill(robot, path);
        if (expanded.contains(names[i]) || (range && into.contains(names[i])))
          at.throw_invalid(fmt::format("names of their own, {} is there already", names[i]));
        expanded.insert_or_assign(key_of(into, name, i, names[i]), std::move(robot));
      }
    }
    into.clear();
    for (auto&& [key, node] : expanded) into.insert_or_assign(toml::key(key), std::move(node));
  }

  /// A key with the place of its table in the file; keys of one range follow each other.
  static toml::key key_of(const toml::table& section, const std::string& name, std::size_t i,
                          const std::string& of) {
    const auto found = section.find(name);
    toml::source_region place = found->first.source();
    constexpr toml::source_index room = 2 * range_max, last = 1'000'000;
    place.begin.column = std::min(place.begin.column, last) * room + static_cast<toml::source_index>(i);
    return toml::key(of, place);
  }

  void inherit(toml::table& robot, TomlDocument& own, const TomlTable& at, std::vector<std::string> above) {
    if (!at.has("inherits")) return;
    const std::string name(at.word("inherits", templates_views(), "a template"));
    if (std::find(above.begin(), above.end(), name) != above.end())
      at.throw_invalid("inherits", fmt::format("a template that does not inherit itself, {} does",
                                               fmt::join(above, " inherits ")));
    above.push_back(name);
    used_.insert(name);
    robot.erase("inherits");
    toml::table of = std::move(*own.root["template"][name].as_table());
    inherit(of, own, root_.table("template").table(name), above);
    merge(robot, std::move(of));
  }

  std::vector<std::string_view> templates_views() const { return {templates_.begin(), templates_.end()}; }

  /// Expands ranges in lists of names.
  void expand_lists(toml::node& node, const std::string& path) {
    if (toml::table* table = node.as_table()) {
      for (auto&& [key, inner] : *table) expand_lists(inner, path + '.' + std::string(key.str()));
      return;
    }
    toml::array* array = node.as_array();
    for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
      const auto* text = (*array)[i].as_string();
      const auto names = text != nullptr ? names_of(text->get()) : std::nullopt;
      if (!names) {
        expand_lists((*array)[i], path);
        continue;
      }
      array->erase(array->cbegin() + static_cast<std::ptrdiff_t>(i));
      array->insert(array->cbegin() + static_cast<std::ptrdiff_t>(i), names->begin(), names->end());
      i += names->size() - 1;
    }
  }

  TomlDocument& document_;
  TomlTable root_;
  std::vector<std::string> templates_;
  std::set<std::string> used_;
};

class Printer {
 public:
  explicit Printer(const TomlDocument& document) : document_(document) { print(document.root, ""); }
  std::string text() { return std::move(text_); }

 private:
  static std::string key_of(std::string_view key) {
    const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
             c == '-';
    });
    return bare ? std::string(key) : quoted(key);
  }
  static std::string quoted(std::string_view text) {
    std::ostringstream out;
    const toml::value<std::string> value{std::string(text)};
    out << toml::toml_formatter(value, toml::format_flags::none);
    return out.str();
  }

  std::string value_of(const toml::node& node) const {
    if (const auto* text = node.as_string()) return quoted(text->get());
    if (const auto* real = node.as_floating_point()) {
      const std::string digits = fmt::format("{}", real->get());
      return digits.find_first_not_of("-0123456789") == digits.npos ? digits + ".0" : digits;
    }
    std::string list;
    const auto add = [&](const std::string& item) { list += (list.empty() ? "" : ", ") + item; };
    if (const toml::array* array = node.as_array()) {
      for (const toml::node& item : *array) add(value_of(item));
      return fmt::format("[{}]", list);
    }
    if (const toml::table* table = node.as_table()) {
      for (const auto& [key, item] : entries(*table))
        add(fmt::format("{} = {}", key_of(key), value_of(*item)));
      return list.empty() ? "{}" : fmt::format("{{ {} }}", list);
    }
    std::ostringstream out;
    out << toml::toml_formatter(node);
    return out.str();
  }

  /// In the order of the file; entries without a place come first.
  std::vector<std::pair<std::string_view, const toml::node*>> entries(const toml::table& table) const {
    std::vector<std::pair<const toml::key*, const toml::node*>> found;
    for (const auto& [key, node] : table) found.emplace_back(&key, &node);
    std::stable_sort(found.begin(), found.end(), [this](const auto& a, const auto& b) {
      return stands_before(document_, a.first->source(), b.first->source());
    });
    std::vector<std::pair<std::string_view, const toml::node*>> list;
    for (const auto& [key, node] : found) list.emplace_back(key->str(), node);
    return list;
  }

  static bool is_section(const toml::node& node) { return node.is_table() && !node.as_table()->is_inline(); }
  static bool is_list_of_sections(const toml::node& node) {
    const toml::array* array = node.as_array();
    return array != nullptr && !array->empty() && std::all_of(array->begin(), array->end(), is_section);
  }

  void print(const toml::table& table, const std::string& path) {
    for (const auto& [key, node] : entries(table)) {
      if (!is_section(*node) && !is_list_of_sections(*node))
        text_ += fmt::format("{} = {}\n", key_of(key), value_of(*node));
    }
    for (const auto& [key, node] : entries(table)) {
      const std::string below = path.empty() ? key_of(key) : path + '.' + key_of(key);
      if (is_section(*node)) {
        const toml::table& inner = *node->as_table();
        const bool only_sections =
            !inner.empty() && std::all_of(inner.begin(), inner.end(), [](const auto& entry) {
              return is_section(entry.second) || is_list_of_sections(entry.second);
            });
        if (!only_sections) text_ += fmt::format("{}[{}]\n", text_.empty() ? "" : "\n", below);
        print(inner, below);
      } else if (is_list_of_sections(*node)) {
        for (const toml::node& item : *node->as_array()) {
          text_ += fmt::format("{}[[{}]]\n", text_.empty() ? "" : "\n", below);
          print(*item.as_table(), below);
        }
      }
    }
  }

  const TomlDocument& document_;
  std::string text_;
};

}  // namespace

void expand(TomlDocument& document) {
  if (!document.root.contains("template") && stands_for_itself(document.root)) return;
  Expansion(document).run();
}

std::string printed(const TomlDocument& document) { return Printer(document).text(); }

}  // namespace sightline
