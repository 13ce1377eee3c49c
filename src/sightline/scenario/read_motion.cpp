#include "sightline/scenario/read_motion.hpp"

#include <fmt/format.h>

#include <array>

#include "sightline/scenario/read_part.hpp"

namespace sightline {
namespace {

using FindAgent = std::function<AgentId(const TomlTable&)>;

constexpr Range speed_range = positive("> 0 m/s");
constexpr Range length_range = not_negative(">= 0 m");

Motion read_path(const TomlTable& at, const FindAgent&) {
  PathMotion path;
  at.read({{"speed", &path.speed, speed_range}}, {"points", "end"});
  for (const auto& p : at.rows("points", TomlTable::any_length, 3)) path.points.push_back({p[0], p[1], p[2]});
  constexpr std::array<std::string_view, 2> ends = {"rest", "round"};
  if (at.has("end"))
    path.end = at.word("end", ends) == "rest" ? PathMotion::End::rest : PathMotion::End::round;
  return path;
}

Motion read_circle(const TomlTable& at, const FindAgent&) {
  CircleMotion circle;
  at.read({{"radius", &circle.radius, length_range}, {"rate", &circle.rate}, {"phase", &circle.phase}},
          {"centre"});
  circle.centre = at.vec3("centre");
  return circle;
}

Motion read_chase(const TomlTable& at, const FindAgent& agent) {
  ChaseMotion chase;
  at.read({{"speed", &chase.speed, speed_range}, {"standoff", &chase.standoff, length_range}}, {"agent"});
  chase.agent = agent(at);
  return chase;
}

Motion read_cross(const TomlTable& at, const FindAgent& agent) {
  CrossMotion cross;
  at.read({{"at", &cross.at, time_range}, {"speed", &cross.speed, speed_range}, {"miss", &cross.miss}},
          {"agent"});
  cross.agent = agent(at);
  return cross;
}

Motion read_hand(const TomlTable& at, const FindAgent& agent) {
  HandMotion hand;
  at.read({{"at", &hand.at, time_range},
           {"speed", &hand.speed, speed_range},
           {"standoff", &hand.standoff, length_range}},
          {"agent", "from"});
  hand.agent = agent(at);
  hand.from = at.vec3("from");
  return hand;
}

Motion read_adversary(const TomlTable& at, const FindAgent& agent) {
  AdversaryMotion adversary;
  at.read({{"speed", &adversary.speed, speed_range},
           {"every", &adversary.every, {1e-3, largest_number, ">= 0.001 s"}},
           {"aim", &adversary.aim, {0.0, 1.0, "in [0, 1]"}}},
          {"agent", "within"});
  adversary.agent = agent(at);
  constexpr std::array<std::string_view, 2> where = {"plane", "space"};
  if (at.has("within")) {
    const bool plane = at.word("within", where) == "plane";
    adversary.within = plane ? AdversaryMotion::Within::plane : AdversaryMotion::Within::space;
  }
  return adversary;
}

using ReadMotion = Motion (*)(const TomlTable& at, const FindAgent& agent);
constexpr std::array motions = {
    Named<ReadMotion>{PathMotion::name, read_path},
    Named<ReadMotion>{CircleMotion::name, read_circle},
    Named<ReadMotion>{ChaseMotion::name, read_chase},
    Named<ReadMotion>{CrossMotion::name, read_cross},
    Named<ReadMotion>{HandMotion::name, read_hand},
    Named<ReadMotion>{AdversaryMotion::name, read_adversary},
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

  constexpr std::array<std::string_view, 2> known = {"measured", "unknown"};
  if (at.has("velocity")) {
    const bool measured = at.word("velocity", known) == "measured";
    uncooperative.velocity = measured ? SeenVelocity::measured : SeenVelocity::unknown;
  }
  // A body without a velocity is assumed to stay, unless a link reports its pose.
  if (!uncooperative.motion && norm(read.v) == 0 && !at.has("link")) uncooperative.speed_max = 0.0;
  if (at.has("speed_max")) uncooperative.speed_max = at.number("speed_max", not_negative(">= 0 m/s"));
  if (at.has("d_hard")) uncooperative.d_hard = at.number("d_hard", positive("> 0 m"));
  return read;
}

std::string in_words(const UncooperativeBody& uncooperative, const Team& team) {
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
