/// An observer of a choice (view_choice.hpp) turns to another target. No scenario calls it: shapes do.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "sightline/ocp/event/add_term.hpp"

namespace sightline {

/// The couplings of these names fade out, where they are, and others of the same names fade in.
struct HandOver {
  AgentId observer{};
  std::vector<std::string> names{};
  std::vector<Coupling> couplings{};  ///< empty: it looks at nobody

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
