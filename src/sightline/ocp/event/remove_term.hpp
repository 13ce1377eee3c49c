/// Actions `remove = { couple = "sees1" }`, `remove = { constrain = "room" }`: a term fades out.
#pragma once

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>

#include "sightline/ocp/event/team_change.hpp"

namespace sightline {

/// Fades out a coupling or constraint, by its name.
struct RemoveTerm {
  static constexpr std::string_view key = "remove";
  static constexpr std::array<std::string_view, 2> kinds = {"couple", "constrain"};

  std::string name;

  std::string apply(const TeamChange& change) const {
    const auto fade = [&](auto& terms) {
      const auto found = change.find(terms, name);
      if (found == terms.end()) return false;
      change.fade_out(terms, static_cast<std::size_t>(found - terms.begin()));
      return true;
    };
    if (fade(change.now.couplings) || fade(change.now.constraints)) return {};
    return no_such_term(name);
  }
  std::string subject(const Team& /*all*/) const { return term_subject(name); }
  std::string describe(const Team& /*all*/) const { return fmt::format("remove {}", name); }

  template <class Text>
  static RemoveTerm read(const Text& remove, std::string_view kind) {
    if (remove.has("then")) remove.throw_invalid("then", "no such key but beside agent");
    return {remove.term(kind).name};
  }
};

}  // namespace sightline
