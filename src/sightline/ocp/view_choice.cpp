#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/events.hpp"

namespace sightline {
namespace {

constexpr double unseen = std::numeric_limits<double>::infinity();

void check_each_once(std::string_view what, const std::string& name, const std::vector<BodyId>& bodies,
                     const Team& team) {
  for (auto body = bodies.begin(); body != bodies.end(); ++body) {
    if (std::find(bodies.begin(), body, *body) != body)
      throw_invalid("\"{}\" stands twice among the {} of {}, expected once", team.name(*body), what, name);
  }
}

}  // namespace

double ViewVariance::at(double distance) const noexcept {
  const double place = distance / step;
  if (values.empty() || !(place >= 0) || place > static_cast<double>(values.size() - 1)) return unseen;
  const auto i = static_cast<std::size_t>(place);
  if (i + 1 >= values.size()) return values.back();
  const double share = place - static_cast<double>(i);
  if (!std::isfinite(values[i]) || !std::isfinite(values[i + 1])) return unseen;
  return (1 - share) * values[i] + share * values[i + 1];
}

double TurnPrice::operator()(double angle) const noexcept {
  const double t = delay + angle / rate;
  return share * (square(walk) * t + square(drift_sigma * t));
}

void ViewChoice::check(const Team& team) const {
  check_each_once("observers", name, {observers.begin(), observers.end()}, team);
  check_each_once("targets", name, targets, team);
  if (observers.empty() || targets.empty())
    throw_invalid("{} has {} observers and {} targets, expected one or more", name, observers.size(),
                  targets.size());
  const bool anchored = std::any_of(targets.begin(), targets.end(), [&](BodyId target) {
    return std::find(observers.begin(), observers.end(), target) == observers.end();
  });
  if (!anchored)
    throw_invalid("all targets of {} are observers, expected one that knows its place without looking", name);
  if (variances.size() != observers.size() * targets.size())
    throw_invalid("{} has {} variances, expected one of each observer and target, {}", name, variances.size(),
                  observers.size() * targets.size());
  if (first.size() != observers.size())
    throw_invalid("{} has {} first targets, expected {}, one of each observer", name, first.size(),
                  observers.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (first[i] >= static_cast<int>(targets.size()) ||
        (first[i] >= 0 && targets[size(first[i])] == observers[i]))
      throw_invalid("the first target of \"{}\" in {} is {}, expected the place of another body",
                    team.name(observers[i]), name, first[i]);
  }
  if (at_most < 1) throw_invalid("{}.at_most = {}, expected >= 1", name, at_most);
  if (!(margin >= 0 && std::isfinite(margin))) throw_invalid("{}.margin = {}, expected >= 0 m", name, margin);
  if (!(dwell > 0 && std::isfinite(dwell))) throw_invalid("{}.dwell = {}, expected > 0 s", name, dwell);
}

ViewChooser::ViewChooser(const ViewChoice& choice)
    : choice_(choice),
      node_of_target_(choice.targets.size(), -1),
      want_(choice.observers.size(), ViewChoice::nobody),
      present_(choice.first),
      trial_(want_),
      used_(choice.targets.size()),
      count_(choice.targets.size()),
      since_(want_.size(), unseen),
      turned_(want_.size(), -unseen),
      changed_(want_.size()),
      due_(want_.size()) {
  for (std::size_t i = 0; i < choice_.observers.size(); ++i)
    nodes_.push_back({.body = choice_.observers[i], .observer = static_cast<int>(i)});
  for (std::size_t j = 0; j < choice_.targets.size(); ++j) {
    auto node = std::find_if(nodes_.begin(), nodes_.end(),
                             [&](const Node& one) { return one.body == choice_.targets[j]; });
    if (node == nodes_.end()) node = nodes_.insert(nodes_.end(), {.body = choice_.targets[j]});
    node->target = static_cast<int>(j);
    node_of_target_[j] = static_cast<int>(node - nodes_.begin());
  }
  order_.reserve(want_.size());
}

/// Takes this target if the path to a known position has a lower cost by it.
void ViewChooser::consider(Node& of, const Node& target) noexcept {
  const std::size_t i = size(of.observer), j = size(target.target);
  if (used_[j] >= choice_.at_most) return;
  const double distance = norm(target.sight.p - of.sight.p);
  double cost = target.cost + choice_.variances[i * choice_.targets.size() + j].at(distance);
  if (!(cost < of.cost)) return;
  if (present_[i] != target.target) {
    const Vec3<double> way = target.sight.p - of.sight.p;
    const Vec2<double>& d = of.sight.d;
    cost += square(choice_.margin) +
            choice_.price(std::abs(atan2(d.x * way.y - d.y * way.x, d.x * way.x + d.y * way.y)));
  }
  if (!(cost < of.cost)) return;
  of.cost = cost;
  want_[i] = target.target;
}

void ViewChooser::plan(const EventInstant& now) noexcept {
  for (Node& node : nodes_) {
    const bool observes = node.observer >= 0;
    node.there = observes ? now.is_steered(node.body) : now.is_there(node.body);
    node.cost = observes || !node.there ? unseen : 0.0;
    node.done = false;
    if (node.there) node.sight = now.sight(node.body);
  }
  std::fill(want_.begin(), want_.end(), ViewChoice::nobody);
  std::fill(used_.begin(), used_.end(), 0);
  order_.clear();
  for (;;) {
    Node* next = nullptr;
    for (Node& node : nodes_) {
      if (!node.done && node.cost < (next == nullptr ? unseen : next->cost)) next = &node;
    }
    if (next == nullptr) return;
    next->done = true;
    if (next->observer >= 0) {
      const int its = want_[size(next->observer)];
      order_.push_back(size(next->observer));
      if (++used_[size(its)] >= choice_.at_most) {
        // The target is full: other observers of it choose again among the finished nodes.
        for (Node& other : nodes_) {
          if (other.done || other.observer < 0 || want_[size(other.observer)] != its) continue;
          other.cost = unseen;
          want_[size(other.observer)] = ViewChoice::nobody;
          for (const Node& known : nodes_) {
            if (known.done && known.target >= 0 && &known != next) consider(other, known);
          }
        }
      }
    }
    if (next->target < 0) continue;
    for (Node& other : nodes_) {
      if (!other.done && other.observer >= 0 && other.there) consider(other, *next);
    }
  }
}

/// Whether no target has too many observers and no observer is in a cycle.
bool ViewChooser::can_be(std::span<const int> targets) const noexcept {
  std::fill(count_.begin(), count_.end(), 0);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (targets[i] >= 0 && ++count_[size(targets[i])] > choice_.at_most) return false;
    std::size_t steps = 0;
    for (int on = static_cast<int>(i); on >= 0 && targets[size(on)] >= 0;) {
      on = nodes_[size(node_of_target_[size(targets[size(on)])])].observer;
      if (++steps > targets.size()) return false;
    }
  }
  return true;
}

void ViewChooser::turn(std::size_t observer, int target, double t) noexcept {
  present_[observer] = target;
  changed_[observer] = 1;
  turned_[observer] = t;
  since_[observer] = unseen;
}

void ViewChooser::look(const EventInstant& now) noexcept {
  const double t = now.known.t;
  plan(now);
  bool any = false;
  std::copy(present_.begin(), present_.end(), trial_.begin());
  for (std::size_t i = 0; i < want_.size(); ++i) {
    changed_[i] = due_[i] = 0;
    const bool has = present_[i] >= 0 && now.is_there(choice_.targets[size(present_[i])]);
    // An observer without a path, or not steered, leaves its target only if others need the place.
    const bool leaves = want_[i] >= 0 || (present_[i] >= 0 && used_[size(present_[i])] >= choice_.at_most);
    if (want_[i] == present_[i] || !leaves) {
      since_[i] = unseen;
      continue;
    }
    since_[i] = std::min(since_[i], t);
    const double waited = has ? t - since_[i] : unseen;
    if (std::min(waited, t - turned_[i]) < choice_.dwell - same_time) continue;
    due_[i] = 1;
    trial_[i] = want_[i];
    any = true;
  }
  if (!any) return;
  if (can_be(trial_)) {
    for (std::size_t i = 0; i < want_.size(); ++i) {
      if (due_[i] != 0) turn(i, want_[i], t);
    }
    return;
  }
  // One by one: first those that free a place, then those nearest to a known position.
  std::copy(present_.begin(), present_.end(), trial_.begin());
  const auto attempt = [&](std::size_t i) {
    if (due_[i] == 0) return;
    trial_[i] = want_[i];
    if (can_be(trial_)) return turn(i, want_[i], t);
    trial_[i] = present_[i];
  };
  for (std::size_t i = 0; i < want_.size(); ++i) {
    if (want_[i] == ViewChoice::nobody) attempt(i);
  }
  for (const std::size_t i : order_) attempt(i);
}

std::vector<int> ViewChooser::first(const ViewChoice& choice, const Team& all, const EventContext& known) {
  ViewChoice none = choice;
  none.first.assign(choice.observers.size(), ViewChoice::nobody);
  ViewChooser chooser(none);
  ConditionState state;
  chooser.look({all, known, 0.0, false, state});
  return chooser.present_;
}

}  // namespace sightline
