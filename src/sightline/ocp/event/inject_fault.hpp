/// Action `fault = { kind = "dropout", body = "uav1", for = 0.5 }`: a measurement fault.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "sightline/base/range.hpp"
#include "sightline/ocp/event/team_change.hpp"

namespace sightline {

/// A fault of a body's measurements that begins now; for a simulated world.
struct InjectFault {
  static constexpr std::string_view key = "fault", expected = "a table with kind, body and for";
  static constexpr bool changes_surroundings = true;
  static constexpr std::array<std::string_view, 3> words_of_kinds = {"dropout", "freeze", "jump"};

  Surroundings::FaultKind kind;
  BodyId body;
  double lasts;           ///< [s], > 0
  Vec3<double> offset{};  ///< of a jump, in G [m]

  std::string apply(const TeamChange& change) const {
    auto& faults = change.now.around.faults;
    std::erase_if(faults, [&](const Surroundings::Fault& fault) { return fault.until <= change.t; });
    if (faults.size() >= Surroundings::faults_max)
      return fmt::format("{} faults are in force already, expected fewer", faults.size());
    faults.push_back({kind, body, offset, change.t, change.t + lasts});
    return {};
  }
  std::string subject(const Team& /*all*/) const { return {}; }
  std::string describe(const Team& all) const {
    return fmt::format("{} of {} for {} s", words_of_kinds[static_cast<std::size_t>(kind)], all.name(body),
                       lasts);
  }

  template <class Text>
  static InjectFault read(const Text& fault, std::string_view /*kind*/) {
    fault.expect_only({"kind", "body", "for", "offset"});
    const std::string_view word = fault.word("kind", words_of_kinds);
    const auto place = std::find(words_of_kinds.begin(), words_of_kinds.end(), word) - words_of_kinds.begin();
    InjectFault read{.kind = static_cast<Surroundings::FaultKind>(place),
                     .body = fault.body("body", "the name of a body"),
                     .lasts = fault.number("for", positive("> 0 s"))};
    if (read.kind == Surroundings::FaultKind::jump) {
      read.offset = fault.vec3("offset");
    } else if (fault.has("offset")) {
      fault.throw_invalid("offset", "no such key beside another kind than jump");
    }
    return read;
  }
};

}  // namespace sightline
