/// Action `retune = { agent = "uav1", R = [...] }`: new weights, u_ref or limits of a robot.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/range.hpp"
#include "sightline/ocp/event/team_change.hpp"

namespace sightline {

/// Values that are left out do not change.
struct RetuneAgent {
  static constexpr std::string_view key = "retune";
  static constexpr std::array<std::string_view, 1> kinds = {"agent"};
  static constexpr std::array<std::string_view, 6> beside = {"Q", "R", "Q_f", "u_ref", "u_min", "u_max"};

  AgentId agent;
  std::optional<std::vector<double>> Q{}, R{}, Q_f{}, u_ref{};
  std::optional<InputLimits> limits{};

  std::string apply(const TeamChange& change) const {
    Agent next = change.agent(agent);
    if (Q) next.Q = *Q;
    if (R) next.R = *R;
    if (Q_f) next.Q_f = *Q_f;
    if (u_ref) next.u_ref = *u_ref;
    if (limits) next.limits = *limits;
    return change.tune(agent, std::move(next));
  }
  std::string subject(const Team& all) const {
    return fmt::format("the tuning of {}", body_subject(all, agent));
  }
  std::string describe(const Team& all) const {
    std::vector<std::string_view> changed;
    if (Q) changed.push_back("Q");
    if (R) changed.push_back("R");
    if (Q_f) changed.push_back("Q_f");
    if (u_ref) changed.push_back("u_ref");
    if (limits) changed.push_back("limits");
    return fmt::format("retune {} of {}", fmt::join(changed, ", "), all.name(agent));
  }

  template <class Text>
  static RetuneAgent read(const Text& retune, std::string_view kind) {
    retune.expect_only({"agent", "Q", "R", "Q_f", "u_ref", "u_min", "u_max"});
    RetuneAgent read{.agent = retune.robot(kind)};
    const Agent& now = retune.agent(read.agent);
    const auto numbers = [&](std::string_view of, std::size_t length, const Range& range) {
      return retune.has(of) ? std::optional(retune.numbers(of, length, range)) : std::nullopt;
    };
    read.Q = numbers("Q", now.Q.size(), not_negative(">= 0"));
    read.R = numbers("R", now.R.size(), positive("> 0"));
    read.Q_f = numbers("Q_f", now.Q_f.size(), not_negative(">= 0"));
    read.u_ref = numbers("u_ref", now.u_ref.size(), any_number());
    if (retune.has("u_min") || retune.has("u_max")) {
      for (const std::string_view of : {"u_min", "u_max"}) {
        if (!retune.has(of) && now.limits.times().size() > 1) {
          retune.throw_invalid(of, "both u_min and u_max, the limits of this robot change over time");
        }
      }
      const auto& u_min = now.limits.u_min().front();
      const auto& u_max = now.limits.u_max().front();
      const auto low = numbers("u_min", u_min.size(), any_number()).value_or(u_min);
      const auto high = numbers("u_max", u_max.size(), any_number()).value_or(u_max);
      read.limits = retune.checked([&] { return InputLimits(low, high); });
    }
    if (retune.size() == 1) retune.throw_invalid("one of Q, R, Q_f, u_ref, u_min, u_max beside agent");
    return read;
  }
};

}  // namespace sightline
