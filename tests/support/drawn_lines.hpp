/// Lines of text with numbers that are drawn.
#pragma once

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <utility>

#include "tests/support/random.hpp"

namespace sightline::test {

class DrawnLines {
 public:
  explicit DrawnLines(std::uint64_t seed) : random_(seed) {}

  const std::string& text() const { return text_; }

 protected:
  template <class... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
    text_ += '\n';
  }
  bool chance(double p) { return uniform(random_, 0, 1) < p; }
  std::size_t below(std::size_t n) { return std::size_t{random_()} % n; }
  template <class List>
  const auto& any(const List& list) {
    return list[below(std::size(list))];
  }
  double between(double low, double high) { return uniform(random_, low, high); }
  std::string number(double low, double high) { return fmt::format("{:.3f}", between(low, high)); }

  Random random_;
  std::string text_;
};

}  // namespace sightline::test
