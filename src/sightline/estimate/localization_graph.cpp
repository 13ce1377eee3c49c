#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/estimator.hpp"

namespace sightline {
namespace {

/// Robots that localize this robot.
std::vector<int> sources_of(const Localized& robot) {
  return robot.is_anchor ? std::vector<int>{} : robot.observes;
}

void check_observed(const std::vector<Localized>& robots) {
  for (std::size_t i = 0; i < robots.size(); ++i) {
    for (const int other : sources_of(robots[i])) {
      if (other < 0 || size(other) >= robots.size())
        throw_invalid("\"{}\" observes robot {}, expected 0 to {}", robots[i].name, other, robots.size() - 1);
      if (size(other) == i) throw_invalid("\"{}\" observes itself, expected another robot", robots[i].name);
    }
  }
}

/// reach[i][j]: robot j is reachable from robot i.
std::vector<std::vector<bool>> reach_of(const std::vector<Localized>& robots) {
  std::vector<std::vector<bool>> reach(robots.size(), std::vector<bool>(robots.size()));
  for (std::size_t i = 0; i < robots.size(); ++i) {
    std::vector<int> open = sources_of(robots[i]);
    while (!open.empty()) {
      const int j = open.back();
      open.pop_back();
      if (reach[i][size(j)]) continue;
      reach[i][size(j)] = true;
      for (const int k : sources_of(robots[size(j)])) open.push_back(k);
    }
  }
  return reach;
}

/// "uav1" by "uav2", "uav2" by "uav1": a cycle through robot `start`.
std::string circle_text(const std::vector<Localized>& robots, const std::vector<std::vector<bool>>& reach,
                        std::size_t start) {
  std::string text;
  std::vector<bool> passed(robots.size());
  for (std::size_t i = start; !passed[i];) {
    passed[i] = true;
    const std::vector<int> sources = sources_of(robots[i]);
    const auto back = [&](int j) { return size(j) == start; };
    const auto onward = [&](int j) { return reach[size(j)][start] && !passed[size(j)]; };
    auto next = std::find_if(sources.begin(), sources.end(), back);
    if (next == sources.end()) next = std::find_if(sources.begin(), sources.end(), onward);
    if (next == sources.end()) break;
    text +=
        fmt::format("{}\"{}\" by \"{}\"", text.empty() ? "" : ", ", robots[i].name, robots[size(*next)].name);
    i = size(*next);
  }
  return text;
}

}  // namespace

LocalizationGraph::LocalizationGraph(std::vector<Localized> robots, Cycles cycles)
    : robots_(std::move(robots)), tier_(robots_.size(), 0), circle_(robots_.size()) {
  check_observed(robots_);
  const std::vector<std::vector<bool>> reach = reach_of(robots_);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (robots_[i].is_anchor) continue;
    bool anchored = false;
    for (std::size_t j = 0; j < robots_.size(); ++j)
      anchored = anchored || (reach[i][j] && robots_[j].is_anchor);
    if (!anchored)
      throw_invalid(
          "\"{}\" observes no localized robot, expected a path from it to a robot whose pose is "
          "known",
          robots_[i].name);
    if (reach[i][i] && cycles == Cycles::refused)
      throw_invalid("robots are localized in a circle, {}, expected none: information would be counted twice",
                    circle_text(robots_, reach, i));
  }
  // The first robot of a cycle gives the cycle its number.
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    std::size_t first = 0;
    while (first < i && !(reach[i][first] && reach[first][i])) ++first;
    circle_[i] = static_cast<int>(first);
  }
  // Longest path to an anchor, with each cycle as one node: at most as many rounds as robots.
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      for (const int j : sources_of(robots_[i])) {
        const int least = tier_[size(j)] + (circle_[i] == circle_[size(j)] ? 0 : 1);
        if (tier_[i] >= least) continue;
        tier_[i] = least;
        changed = true;
      }
    }
  }
  for (std::size_t i = 0; i < robots_.size(); ++i) order_.push_back(static_cast<int>(i));
  std::stable_sort(order_.begin(), order_.end(), [&](int a, int b) { return tier(a) < tier(b); });
}

bool LocalizationGraph::uses(int observer, int target) const noexcept {
  const Localized& of = robot(observer);
  return !of.is_anchor && std::find(of.observes.begin(), of.observes.end(), target) != of.observes.end();
}

OtherError LocalizationGraph::error_of(int observer, int target) const noexcept {
  if (robot(target).is_anchor) return OtherError::fresh;
  return circle_[size(observer)] == circle_[size(target)] ? OtherError::unknown : OtherError::lasting;
}

}  // namespace sightline
