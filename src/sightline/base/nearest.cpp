#include "sightline/base/nearest.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace sightline {
namespace {

/// Length of the common leading key parts, "agent.uav0.", in bytes.
std::size_t shared_parts(std::string_view a, std::string_view b) {
  const auto differs = std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first;
  const std::string_view same = a.substr(0, static_cast<std::size_t>(differs - a.begin()));
  const std::size_t dot = same.rfind('.');
  return dot == std::string_view::npos ? 0 : dot + 1;
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
  std::iota(row.begin(), row.end(), 0U);
  for (std::size_t i = 0; i < a.size(); ++i) {
    next[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      next[j + 1] = std::min({row[j] + (a[i] == b[j] ? 0U : 1U), next[j] + 1, row[j + 1] + 1});
      if (i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j])
        next[j + 1] = std::min(next[j + 1], before[j - 1] + 1);
    }
    before.swap(row);
    row.swap(next);
  }
  return row.back();
}

std::optional<std::string_view> nearest(std::string_view name, std::span<const std::string_view> known) {
  std::optional<std::string_view> found;
  std::size_t least = 0;
  for (const std::string_view one : known) {
    const std::size_t shared = shared_parts(name, one);
    const std::string_view a = name.substr(shared), b = one.substr(shared);
    const std::size_t distance = edit_distance(a, b);
    if (3 * distance > std::max(a.size(), b.size()) || (found && distance >= least)) continue;
    found = one;
    least = distance;
  }
  return found;
}

std::string hint(std::string_view name, std::span<const std::string_view> known) {
  if (const auto near = nearest(name, known)) return fmt::format(", the nearest is \"{}\"", *near);
  if (known.empty()) return {};
  const auto shown = known.first(std::min(known.size(), hint_names));
  return fmt::format(
      ": {}{}", fmt::join(shown, ", "),
      shown.size() < known.size() ? fmt::format(" and {} more", known.size() - shown.size()) : std::string());
}

}  // namespace sightline
