#include "bridges/dds/topics/diagnostics.hpp"

#include <fmt/format.h>

namespace sightline::dds {
namespace {

std::string yes_or_no(bool yes) { return yes ? "yes" : "no"; }

std::string_view describe_mode(AutopilotMode mode) {
  switch (mode) {
    case AutopilotMode::takeoff:
      return "take-off, or in the air after it";
    case AutopilotMode::offboard:
      return "offboard";
    case AutopilotMode::land:
      return "land";
    case AutopilotMode::other:
      break;
  }
  return "none of ours";
}

}  // namespace

Diagnosis diagnose_link(std::string_view name, const RobotShown& shown, double age, double fresh,
                        FallbackLevel level, const std::string& counts) {
  Diagnosis d = {.name = fmt::format("sightline: {}", name),
                 .message = std::string(to_string(shown.state)),
                 .hardware = std::string(name)};
  const LinkFacts& f = shown.facts;
  if (shown.reason != LinkReason::as_requested) {
    d.level = Health::error;
    d.message = fmt::format("{}: {}", to_string(shown.state), to_string(shown.reason));
  } else if (!shown.seen) {
    d.level = Health::stale;
    d.message = "no message of it arrived yet";
  } else if (!f.there) {
    d.level = Health::stale;
    d.message = fmt::format("{}: its messages are {:.1f} s old", to_string(shown.state), age);
  } else if (age > fresh || level != FallbackLevel::valid) {
    d.level = Health::warn;
    d.message = fmt::format("{}: its data are {:.0f} ms old, {}", to_string(shown.state), 1e3 * age,
                            to_string(level));
  }
  d.values = {{"state", std::string(to_string(shown.state))},
              {"level", std::string(to_string(level))},
              {"age of the pose [ms]", shown.seen ? fmt::format("{:.1f}", 1e3 * age) : "none"},
              {"mode", std::string(describe_mode(f.mode))},
              {"armed", yes_or_no(f.armed)},
              {"in the air", yes_or_no(f.airborne)},
              {"ready to be armed", yes_or_no(f.checked)},
              {"failsafe", yes_or_no(f.failsafe)},
              {"set-points of others", yes_or_no(f.contested)},
              {"messages", counts}};
  return d;
}

Diagnosis diagnose_solver(std::string_view solver, const LoopShown& loop) {
  Diagnosis d = {.name = "sightline: solver", .message = "no task yet", .hardware = std::string(solver)};
  if (!loop.begun) return d;
  d.message = std::string(to_string(loop.last.status));
  if (!gives_plan(loop.last.status))
    d.level = Health::error;
  else if (loop.missed > 0)
    d.level = Health::warn;
  d.values = {{"status", d.message},
              {"residual [1/s]", fmt::format("{:.3g}", loop.last.residual)},
              {"iterations", fmt::format("{}", loop.last.iterations)},
              {"solve time [us]", fmt::format("{:.0f}", loop.last.solve_us)},
              {"longest solve time [us]", fmt::format("{:.0f}", loop.solve_us_most)},
              {"longest update [us]", fmt::format("{:.0f}", loop.update_us_most)},
              {"periods", fmt::format("{}", loop.periods)},
              {"missed periods", fmt::format("{}", loop.missed)}};
  if (loop.missed > 0) d.message += fmt::format(", {} periods missed", loop.missed);
  return d;
}

}  // namespace sightline::dds
