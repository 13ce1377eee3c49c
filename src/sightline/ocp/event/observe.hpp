/// Action `observe = { observer = "uav2", target = "uav0" }`: a robot observes another target.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/ocp/event/team_change.hpp"
#include "sightline/potential/protection.hpp"

namespace sightline {

/// The robot observes another body from now on. Its couplings with a sensor move to the new target,
/// and so do those that hold it to the previous target. Couplings that keep the two apart
/// (protection.hpp) stay, and the new target gets the same if it has none. If a region does both,
/// its limits that keep them apart stay behind.
struct Observe {
  static constexpr std::string_view key = "observe", expected = "a table with observer and target";
  static constexpr double usual_ramp = 1.0;  ///< [s]

  AgentId observer;
  BodyId target;

  std::string apply(const TeamChange& change) const;
  std::string subject(const Team& all) const {
    return fmt::format("whom {} observes", body_subject(all, observer));
  }
  std::string describe(const Team& all) const {
    return fmt::format("{} observes {}", all.name(observer), all.name(target));
  }
  /// Bodies that must be present.
  std::vector<BodyId> needs() const { return {target}; }

  template <class Text>
  static Observe read(const Text& observe, std::string_view /*kind*/) {
    observe.expect_only({"observer", "target"});
    const Observe read{observe.robot("observer"), observe.body("target", "the name of a body")};
    if (read.observer == read.target) observe.throw_invalid("target", "another body than observer");
    if (!observe.has_sensor(read.observer)) observe.throw_invalid("observer", "a robot with a sensor");
    return read;
  }

 private:
  static bool joins(const Coupling& c, BodyId a, BodyId b) {
    return (c.between.first == a && c.between.second == b) || (c.between.first == b && c.between.second == a);
  }
  bool is_kept_off(BodyId whom, const std::vector<Coupling>& couplings, std::size_t n, std::size_t but,
                   const std::vector<AgentId>& felt_by) const;
};

/// Whether one of the first n couplings other than `but` keeps the observer off the body `whom` and
/// acts on all agents of `felt_by`.
inline bool Observe::is_kept_off(BodyId whom, const std::vector<Coupling>& couplings, std::size_t n,
                                 std::size_t but, const std::vector<AgentId>& felt_by) const {
  for (std::size_t j = 0; j < n; ++j) {
    const Coupling& c = couplings[j];
    const bool felt = std::all_of(felt_by.begin(), felt_by.end(), [&](AgentId agent) {
      return std::find(c.felt_by.begin(), c.felt_by.end(), agent) != c.felt_by.end();
    });
    if (j != but && felt && c.ramp.lasts() && c.term.weight > 0 && joins(c, observer, whom) &&
        !keep_outs(c.term.potential).empty()) {
      return true;
    }
  }
  return false;
}

inline std::string Observe::apply(const TeamChange& change) const {
  if (observer == target) return fmt::format("\"{}\" cannot observe itself", change.name(observer));
  auto& couplings = change.now.couplings;
  const auto looks = std::find_if(couplings.begin(), couplings.end(), [&](const Coupling& c) {
    return c.ramp.lasts() && c.between.first == observer && observes(c.term.potential);
  });
  if (looks == couplings.end()) {
    return fmt::format("\"{}\" has no sensor on anything, expected a robot that observes",
                       change.name(observer));
  }
  const BodyId before = looks->between.second;
  if (before == target) {
    return fmt::format("\"{}\" observes \"{}\" already, expected another", change.name(observer),
                       change.name(target));
  }
  for (std::size_t i = 0, n = couplings.size(); i < n; ++i) {
    if (!couplings[i].ramp.lasts() || !joins(couplings[i], observer, before)) continue;
    // The previous target observes the observer by this coupling, with its own sensor: it stays.
    if (couplings[i].between.first == before && observes(couplings[i].term.potential)) continue;
    const bool stays = keeps_apart(couplings[i].term.potential);
    Coupling next = couplings[i];
    BodyId& end = next.between.first == before ? next.between.first : next.between.second;
    end = target;
    if (change.is_robot(target)) {
      std::replace(next.felt_by.begin(), next.felt_by.end(), AgentId{before}, AgentId{target});
    } else {
      std::erase(next.felt_by, AgentId{before});
    }
    if (next.third == target) next.felt_by.clear();  // the potential would look past its own target
    if (stays) {
      if (next.felt_by.empty() || is_kept_off(target, couplings, n, i, next.felt_by)) continue;
      next.name.clear();
      next.ramp = change.fading_in();
      couplings.push_back(std::move(next));
      continue;
    }
    // A coupling that moves leaves behind its limits that keep the two apart.
    if (!is_kept_off(before, couplings, n, i, couplings[i].felt_by)) {
      for (Potential& limit : keep_outs(couplings[i].term.potential)) {
        Coupling apart = couplings[i];
        apart.term.potential = std::move(limit);
        if (!apart.term.potential.sees_third()) apart.third = {};
        apart.name.clear();
        apart.ramp = change.fading_in();
        couplings.push_back(std::move(apart));
      }
    }
    if (next.felt_by.empty()) {
      change.fade_out(couplings, i);
    } else {
      change.replace(couplings, i, std::move(next));
    }
  }
  return {};
}

}  // namespace sightline
