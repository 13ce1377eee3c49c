/// Action `retune = { couple = "sees1", weight = 0.8 }`: a new weight or potential of a term.
#pragma once

#include <fmt/format.h>

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "sightline/base/range.hpp"
#include "sightline/ocp/event/team_change.hpp"

namespace sightline {

/// Of a coupling or constraint; values that are left out do not change.
struct RetuneTerm {
  static constexpr std::string_view key = "retune";
  static constexpr std::array<std::string_view, 2> kinds = {"couple", "constrain"};
  static constexpr std::array<std::string_view, 2> beside = {"weight", "potential"};

  std::string name;
  std::optional<double> weight{};
  std::optional<Potential> potential{};

  std::string apply(const TeamChange& change) const {
    if (weight && !(*weight >= 0 && *weight <= std::numeric_limits<double>::max())) {
      return fmt::format("weight = {}, expected >= 0", *weight);
    }
    std::string refusal = no_such_term(name);
    const auto swap = [&](auto& terms) {
      const auto found = change.find(terms, name);
      if (found == terms.end()) return;
      refusal.clear();
      auto next = *found;
      if (weight) next.term.weight = *weight;
      if (potential && potential->is_pair() != next.term.potential.is_pair()) {
        refusal = fmt::format("{} is of another kind than \"{}\", expected one between as many bodies",
                              potential->name(), name);
        return;
      }
      if (potential && potential->sees_third() != next.term.potential.sees_third()) {
        refusal = fmt::format("{} looks past {} third body, \"{}\" past {}, expected one that does alike",
                              potential->name(), potential->sees_third() ? "a" : "no", name,
                              potential->sees_third() ? "none" : "one");
        return;
      }
      if (potential) next.term.potential = *potential;
      change.replace(terms, static_cast<std::size_t>(found - terms.begin()), std::move(next));
    };
    swap(change.now.couplings);
    if (!refusal.empty()) swap(change.now.constraints);
    return refusal;
  }
  std::string subject(const Team& /*all*/) const { return term_subject(name); }
  std::string describe(const Team& /*all*/) const {
    std::string text = fmt::format("retune {}", name);
    if (weight) text += fmt::format(", weight {}", *weight);
    if (potential) text += fmt::format(", another {}", potential->name());
    return text;
  }

  template <class Text>
  static RetuneTerm read(const Text& retune, std::string_view kind) {
    retune.expect_only({kind, "weight", "potential"});
    const auto& term = retune.term(kind);
    RetuneTerm read{.name = term.name};
    if (retune.has("weight")) read.weight = retune.number("weight", not_negative(">= 0"));
    if (retune.has("potential")) {
      read.potential = retune.potential(term.observer);
      if (read.potential->is_pair() != term.is_pair) {
        retune.throw_invalid(
            "potential", term.is_pair ? "a potential between two bodies" : "a potential of one robot alone");
      }
    }
    if (retune.size() == 1) retune.throw_invalid("weight", "weight or potential, whatever changes");
    return read;
  }
};

}  // namespace sightline
