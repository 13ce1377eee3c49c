/// Action by which an observer of a choice (view_choice.hpp) turns to another target. Made by
/// shapes only.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "sightline/ocp/event/add_term.hpp"

namespace sightline {

/// Couplings of these names fade out, if they are in force; others of the same names fade in.
struct HandOver {
  AgentId observer{};
  std::vector<std::string> names{};
  std::vector<Coupling> couplings{};  ///< empty: no target

  std::string apply(const TeamChange& change) const {
    TeamState before = change.now;
    for (const std::string& name : names) {
      const auto found = change.find(change.now.couplings, name);
      if (found != change.now.couplings.end())
        change.fade_out(change.now.couplings, static_cast<std::size_t>(found - change.now.couplings.begin()));
    }
    for (const Coupling& coupling : couplings) {
      if (std::string refusal = AddCoupling{coupling}.apply(change); !refusal.empty()) {
        change.now = std::move(before);
        return refusal;
      }
    }
    return {};
  }
  std::string subject(const Team& all) const {
    return fmt::format("whom {} observes", body_subject(all, observer));
  }
  std::string describe(const Team& all) const {
    if (couplings.empty()) return fmt::format("{} observes no body", all.name(observer));
    return fmt::format("{} observes {}", all.name(observer), all.name(couplings.front().between.second));
  }
};

}  // namespace sightline
