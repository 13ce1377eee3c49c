#include "sightline/scenario/read_motion.hpp"

#include <fmt/format.h>

#include <array>

#include "sightline/scenario/csv_lists.hpp"

namespace sightline {
namespace {

using FindAgent = std::function<AgentId(const TomlTable&)>;

template <class Kind>
Motion read_kind(const TomlTable& at, const FindAgent& agent) {
  if constexpr (requires(Kind kind) { kind.times; })
    return read_part<Kind>(ListSource(at), parameter_keys<ListFile>());
  Kind motion = read_part<Kind>(TableSource(at));
  if constexpr (requires { motion.agent; }) motion.agent = agent(at);
  return motion;
}

using ReadMotion = Motion (*)(const TomlTable& at, const FindAgent& agent);
constexpr std::array motions = {
    Named<ReadMotion>{PathMotion::name, read_kind<PathMotion>},
    Named<ReadMotion>{WaypointsMotion::name, read_kind<WaypointsMotion>},
    Named<ReadMotion>{CircleMotion::name, read_kind<CircleMotion>},
    Named<ReadMotion>{ChaseMotion::name, read_kind<ChaseMotion>},
    Named<ReadMotion>{CrossMotion::name, read_kind<CrossMotion>},
    Named<ReadMotion>{HandMotion::name, read_kind<HandMotion>},
    Named<ReadMotion>{AdversaryMotion::name, read_kind<AdversaryMotion>},
};

Motion read_motion(const TomlTable& body, const FindAgent& agent) {
  const TomlTable choice = body.table("motion");
  const std::string_view name = choice.choice(names(motions));
  const TomlTable at = choice.table(name);
  Motion motion = find(motions, name)(at, agent);
  at.checked([&] { std::visit([](const auto& m) { m.check(); }, motion); });
  return motion;
}

}  // namespace

UncooperativeStart read_uncooperative(const TomlTable& at, const FindAgent& agent) {
  at.expect_only({"p", "v", "motion", "velocity", "speed_max", "d_hard", "present", "link", "tags", "hull"});
  UncooperativeStart read;
  UncooperativeBody& uncooperative = read.uncooperative;
  std::optional<Vec3<double>> start;
  if (at.has("motion")) {
    uncooperative.motion = read_motion(at, agent);
    start = start_of(*uncooperative.motion);
    if (at.has("v")) at.throw_invalid("v", "no such key beside motion, which gives the velocity");
    if (start && at.has("p")) at.throw_invalid("p", "no such key beside this motion, which gives its start");
  }
  read.p = start ? *start : at.vec3("p");
  if (at.has("v")) read.v = at.vec3("v");

  // A body without a velocity is assumed to stay, unless a link reports its pose.
  if (!uncooperative.motion && norm(read.v) == 0 && !at.has("link")) uncooperative.speed_max = 0.0;
  read_parameters(TableSource(at), uncooperative);
  return read;
}

std::string describe(const UncooperativeBody& uncooperative, const Team& team) {
  std::string text(team.name(uncooperative.body));
  if (uncooperative.motion) {
    text += std::visit(
        [&](const auto& m) {
          if constexpr (requires { m.agent; }) return fmt::format(", {} {}", m.name, team.name(m.agent));
          return fmt::format(", {}", m.name);
        },
        *uncooperative.motion);
    text += fmt::format(" at up to {} m/s", top_speed(*uncooperative.motion));
  }
  text += fmt::format(", velocity {}, speed_max {} m/s",
                      uncooperative.velocity == SeenVelocity::measured ? "measured" : "unknown",
                      uncooperative.speed_max);
  if (uncooperative.d_hard) text += fmt::format(", d_hard {} m", *uncooperative.d_hard);
  return text;
}

}  // namespace sightline
