/// Actions `remove = "uav2"`, `remove = { agent = "uav2", then = "hold" }`: a body leaves.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "sightline/ocp/event/team_change.hpp"

namespace sightline {

/// Behaviour of a robot that leaves the team.
enum class Afterwards {
  vanish,  ///< it is removed
  hold,    ///< it brakes and stays; its couplings still act on the other robots
  land,    ///< it brakes and descends to the ground
};

struct RemoveBody {
  static constexpr std::string_view key = "remove", expected = "the name of a body, or a table";
  static constexpr std::array<std::string_view, 3> kinds = {"agent", "target", "obstacle"};
  static constexpr std::array<std::string_view, 1> beside = {"then"};

  BodyId body;
  Afterwards afterwards = Afterwards::vanish;  ///< of a robot; other bodies vanish

  std::string apply(const TeamChange& change) const {
    Presence& presence = change.presence(body);
    const bool stays = change.is_robot(body) && afterwards != Afterwards::vanish;
    if (presence == Presence::absent) {
      return fmt::format("\"{}\" is not there, expected one that is", change.name(body));
    }
    if (stays && presence != Presence::steered) {
      return fmt::format("\"{}\" is not steered any more, expected a robot that is", change.name(body));
    }
    const auto& all = change.now.presence;
    if (presence == Presence::steered && std::count(all.begin(), all.end(), Presence::steered) == 1) {
      return fmt::format("\"{}\" is the last robot, expected another to be left", change.name(body));
    }
    if (stays) {
      presence = afterwards == Afterwards::hold ? Presence::hold : Presence::land;
      return {};
    }
    presence = Presence::absent;
    if (change.ramp == 0) return {};
    // Copies of its couplings fade out for the other robots; the originals stay for its return.
    auto& couplings = change.now.couplings;
    for (std::size_t i = 0, n = couplings.size(); i < n; ++i) {
      Coupling ghost = couplings[i];
      const auto& [first, second] = ghost.between;
      if (!ghost.ramp.lasts() || (first != body && second != body && ghost.third != body)) continue;
      couplings.push_back(std::move(ghost));
      change.fade_out(couplings, couplings.size() - 1);
    }
    return {};
  }
  std::string subject(const Team& all) const { return body_subject(all, body); }
  std::string describe(const Team& all) const {
    constexpr std::array<std::string_view, 3> how = {"", ", which holds", ", which lands"};
    return fmt::format("remove {}{}", all.name(body), how[static_cast<std::size_t>(afterwards)]);
  }

  static RemoveBody named(BodyId body) { return {body}; }
  template <class Text>
  static RemoveBody read(const Text& remove, std::string_view kind) {
    if (kind != "agent" && remove.has("then")) remove.throw_invalid("then", "no such key but beside agent");
    RemoveBody read{remove.body_of_kind(kind)};
    constexpr std::array<std::string_view, 3> words = {"vanish", "hold",
                                                       "land"};  // in the order of Afterwards
    if (remove.has("then")) {
      const auto word = std::find(words.begin(), words.end(), remove.word("then", words)) - words.begin();
      read.afterwards = static_cast<Afterwards>(word);
    }
    return read;
  }
};

}  // namespace sightline
