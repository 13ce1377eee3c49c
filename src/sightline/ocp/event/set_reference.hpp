/// Action `reference = { agent = "uav0", reference = {...} }`, with a reference as in [agent.NAME].
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "sightline/ocp/event/team_change.hpp"

namespace sightline {

struct SetReference {
  static constexpr std::string_view key = "reference", expected = "a table with agent and reference";

  AgentId agent;
  Reference reference;

  std::string apply(const TeamChange& change) const {
    Agent next = change.agent(agent);
    next.x_ref = reference;
    Reference before = change.now.reference(agent, change.t);
    if (std::string refusal = change.tune(agent, std::move(next)); !refusal.empty()) return refusal;
    std::erase_if(change.now.turns, [&](const Turn& turn) { return turn.agent == agent; });
    if (change.ramp > 0) change.now.turns.push_back({agent, std::move(before), change.fading_in()});
    return {};
  }
  std::string subject(const Team& all) const {
    return fmt::format("the reference of {}", body_subject(all, agent));
  }
  std::string describe(const Team& all) const {
    return fmt::format("another reference for {}", all.name(agent));
  }

  template <class Text>
  static SetReference read(const Text& change, std::string_view /*kind*/) {
    change.expect_only({"agent", "reference"});
    const AgentId agent = change.robot("agent");
    if (!change.has("reference")) change.throw_invalid("reference", "a reference as in [agent.NAME]");
    return {agent, change.reference(agent)};
  }
};

}  // namespace sightline
