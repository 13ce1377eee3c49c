/// Action `move = { obstacle = "box", p = [1.0, 0.0, 1.2] }`: a target or obstacle moves.
#pragma once

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>

#include "sightline/ocp/event/team_change.hpp"

namespace sightline {

/// A target or an obstacle moves to a place, over the ramp, and stays there; for a simulated world.
struct MoveBody {
  static constexpr std::string_view key = "move";
  static constexpr bool changes_surroundings = true;
  static constexpr std::array<std::string_view, 2> kinds = {"target", "obstacle"};
  static constexpr std::array<std::string_view, 1> beside = {"p"};
  static constexpr double usual_ramp = 1.0;

  BodyId body;
  Vec3<double> p;  ///< in G [m]

  std::string apply(const TeamChange& change) const {
    if (change.is_robot(body))
      return fmt::format("\"{}\" is a robot, expected a target or an obstacle", change.name(body));
    if (!change.is_there(body))
      return fmt::format("\"{}\" is not there, expected a body that is", change.name(body));
    auto& moves = change.now.around.moves;
    std::erase_if(moves, [&](const Surroundings::Move& move) { return move.body == body; });
    moves.push_back({body, p, change.t, change.ramp});
    return {};
  }
  std::string subject(const Team& all) const {
    return fmt::format("the place of {}", body_subject(all, body));
  }
  std::string describe(const Team& all) const {
    return fmt::format("move {} to {:.4g}, {:.4g}, {:.4g}", all.name(body), p.x, p.y, p.z);
  }

  template <class Text>
  static MoveBody read(const Text& move, std::string_view kind) {
    move.expect_only({kind, "p"});
    return {move.body_of_kind(kind), move.vec3("p")};
  }
};

}  // namespace sightline
