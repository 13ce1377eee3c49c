/// Action `add = "uav2"`, `add = { obstacle = "door" }`: a body joins.
#pragma once

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>

#include "sightline/ocp/event/team_change.hpp"

namespace sightline {

/// The body joins at its start, with its couplings to bodies that are present.
struct AddBody {
  static constexpr std::string_view key = "add", expected = "the name of a body, or a table";
  static constexpr std::array<std::string_view, 3> kinds = {"agent", "target", "obstacle"};

  BodyId body;

  std::string apply(const TeamChange& change) const {
    Presence& presence = change.presence(body);
    const bool robot = change.is_robot(body), was_there = change.is_there(body);
    if (presence == Presence::steered || (!robot && was_there)) {
      return fmt::format("\"{}\" is there already, expected one that is not", change.name(body));
    }
    presence = robot ? Presence::steered : Presence::hold;
    for (Coupling& c : change.now.couplings) {
      const bool of_it = c.between.first == body || c.between.second == body || c.third == body;
      const bool felt_before = was_there && (c.felt_by.size() > 1 || c.felt_by[0] != body);
      if (of_it && c.ramp.lasts() && !felt_before) c.ramp = change.fading_in();
    }
    for (Constraint& c : change.now.constraints) {
      if (c.agent == body && c.ramp.lasts()) c.ramp = change.fading_in();
    }
    return {};
  }
  std::string subject(const Team& all) const { return body_subject(all, body); }
  std::string describe(const Team& all) const { return fmt::format("add {}", all.name(body)); }

  static AddBody named(BodyId body) { return {body}; }
  template <class Text>
  static AddBody read(const Text& add, std::string_view kind) {
    return {add.body_of_kind(kind)};
  }
};

}  // namespace sightline
