/// The language of docs/potentials.md once more, read anew at each place: what limits say without graph or compiler.
#pragma once

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace sightline::test {

/// A name's number in SI units, none for one that is unknown.
using Quantities = std::function<std::optional<double>(std::string_view name)>;

class LimitText {
 public:
  /// `parameters` may be null; they go before the quantities.
  LimitText(const toml::table* parameters, Quantities quantities)
      : parameters_(parameters), quantities_(std::move(quantities)) {}

  /// How far outside of a region one is, <= 0 inside: a comparison, or a table with limit, all_of, any_of or not.
  double excess(const toml::node& region) const {
    if (const auto text = region.value<std::string>()) return Reader{*this, *text}.comparison();
    const toml::table& table = *region.as_table();
    if (const toml::node* limit = table.get("limit")) return excess(*limit);
    if (const toml::node* inner = table.get("not")) return -excess(*inner);
    const bool all = table.contains("all_of");
    double worst = all ? -infinity : infinity;
    for (const toml::node& part : *table.get(all ? "all_of" : "any_of")->as_array()) {
      worst = all ? std::max(worst, excess(part)) : std::min(worst, excess(part));
    }
    return worst;
  }

  double formula(const toml::node& value) const {
    if (const auto number = value.value<double>(); number && !value.is_string()) return *number;
    if (const toml::table* table = value.as_table()) {
      const double number = formula(*table->get("value"));
      return number * unit(table->get("unit")->value_or<std::string>("")).value_or(1.0);
    }
    return Reader{*this, value.value_or<std::string>("")}.whole();
  }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  static std::optional<double> unit(std::string_view name) {
    constexpr std::pair<std::string_view, double> known[] = {
        {"m", 1.0},     {"cm", 0.01},  {"mm", 0.001},
        {"km", 1000.0}, {"rad", 1.0},  {"deg", std::numbers::pi / 180},
        {"s", 1.0},     {"ms", 0.001}, {"Hz", 1.0}};
    for (const auto& [word, size] : known) {
      if (word == name) return size;
    }
    return std::nullopt;
  }

  double named(std::string_view name) const {
    if (name == "pi") return std::numbers::pi;
    if (const toml::node* value = parameters_ != nullptr ? parameters_->get(name) : nullptr)
      return formula(*value);
    if (const auto value = quantities_(name)) return *value;
    throw std::runtime_error("no quantity is called " + std::string(name));
  }

  struct Reader {
    const LimitText& of;
    std::string text;
    std::size_t at = 0;

    void blanks() {
      while (at < text.size() && text[at] == ' ') ++at;
    }
    bool take(char c) {
      blanks();
      if (at >= text.size() || text[at] != c) return false;
      ++at;
      return true;
    }
    std::string name() {
      const std::size_t from = at;
      while (at < text.size() &&
             (std::isalnum(static_cast<unsigned char>(text[at])) != 0 || text[at] == '_' || text[at] == '.'))
        ++at;
      return text.substr(from, at - from);
    }
    double whole() {
      const double value = sum();
      blanks();
      if (at != text.size()) throw std::runtime_error("not a formula: " + text);
      return value;
    }
    double comparison() {
      double left = sum(), worst = -infinity;
      for (;;) {
        const bool less = take('<');
        if (!less && !take('>')) break;
        (void)take('=');
        const double right = sum();
        worst = std::max(worst, less ? left - right : right - left);
        left = right;
      }
      blanks();
      if (at != text.size()) throw std::runtime_error("not a limit: " + text);
      return worst;
    }
    double sum() {
      double value = product();
      for (;;) {
        if (take('+')) {
          value += product();
        } else if (take('-')) {
          value -= product();
        } else {
          return value;
        }
      }
    }
    double product() {
      double value = signed_power();
      for (;;) {
        if (take('*')) {
          value *= signed_power();
        } else if (take('/')) {
          value /= signed_power();
        } else {
          return value;
        }
      }
    }
    double signed_power() {
      if (take('-')) return -signed_power();
      if (take('+')) return signed_power();
      const double base = atom();
      return take('^') ? std::pow(base, signed_power()) : base;
    }
    double atom() {
      if (take('(')) {
        const double value = sum();
        if (!take(')')) throw std::runtime_error("no ) in " + text);
        return value;
      }
      blanks();
      if (at < text.size() && std::isalpha(static_cast<unsigned char>(text[at])) == 0) return number();
      const std::string word = name();
      if (!take('(')) return of.named(word);
      std::vector<double> a = {sum()};
      while (take(',')) a.push_back(sum());
      if (!take(')')) throw std::runtime_error("no ) in " + text);
      return call(word, a);
    }
    /// A number with its unit, which binds: "2 m/s".
    double number() {
      std::size_t length = 0;
      double value = std::stod(text.substr(at), &length);
      at += length;
      const std::size_t behind = at;
      blanks();
      const auto size = unit(name());
      if (!size) return at = behind, value;
      value *= *size;
      for (std::size_t end = at; take('/'); end = at) {
        const auto below = unit(name());
        if (!below) return at = end, value;
        value /= *below;
      }
      return value;
    }
    static double call(const std::string& word, const std::vector<double>& a) {
      if (word == "sqrt") return std::sqrt(a[0]);
      if (word == "abs") return std::abs(a[0]);
      if (word == "sin") return std::sin(a[0]);
      if (word == "cos") return std::cos(a[0]);
      if (word == "tan") return std::tan(a[0]);
      if (word == "exp") return std::exp(a[0]);
      if (word == "log") return std::log(a[0]);
      if (word == "atan2") return std::atan2(a[0], a[1]);
      if (word == "min") return *std::min_element(a.begin(), a.end());
      if (word == "max") return *std::max_element(a.begin(), a.end());
      double squares = 0.0;
      for (const double v : a) squares += v * v;
      if (word == "norm" || word == "hypot") return std::sqrt(squares);
      throw std::runtime_error("no function is called " + word);
    }
  };

  const toml::table* parameters_;
  Quantities quantities_;
};

}  // namespace sightline::test
