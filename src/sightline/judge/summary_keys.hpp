/// Keys of summary.json, which its writers use and docs/reference.md shows.
#pragma once

#include <cstddef>
#include <string_view>

namespace sightline {

/// A table in Markdown; `.max` continues the key before it.
inline constexpr std::string_view summary_keys = R"(| key | meaning [unit] |
|---|---|
| `scenario`, `seed`, `version`, `solver` | configuration of the run |
| `settle`, `updates` | begin of evaluation [s]; number of control updates |
| `cost` | Σ Δt l(x_k, u_k, t_k) of the applied inputs, all weights, masked or not [s] |
| `solve_us.mean`, `.median`, `.p99`, `.max` | time of one solve; beyond 65 536 solves, median and p99 within 0.5 % [µs] |
| `allocations_per_update` | most allocations in one update, from state to command |
| `status`, `not_finite` | updates by status; updates that were not finite |
| `without_plan.longest`, `.from`, `.status` | longest time without a plan (0: never), its begin, its first status (null: never) [s] |
| `input_violations`, `applied_violations` | components beyond a limit by more than 1e-9: of the solver's raw u, of the applied u |
| `max_abs_input` | largest absolute component of the raw u [as u] |
| `min_distance` | least distance of a robot to any other body, also between samples [m] |
| `pairs_active_max`, `pairs_left_out_max` | with `[[keep_apart]]`: most near pairs in one update; most beyond `pairs_max`, not kept apart |
| `pairs[].observer`, `.target`, `.sensor`, `.distance.min`, `.max`, `.view_angle_max` | names, that of the camera if it has one; D [m] and largest α_t [rad] after settle |
| `pairs[].view_angle_mean` | mean α_t after settle; this and the next only if the observer is a vehicle or its camera is fixed to the body [rad] |
| `pairs[].planned_view_angle.mean`, `.rms`, `.ahead` | mean α_t planned the time `.ahead` [s] before; RMS of flown minus planned [rad] |
| `agents[].tilt_max`, `agents[].planned_tilt.max`, `.rms`, `.ahead` | tilt of such a robot after settle: largest; largest planned, RMS of flown minus planned [rad] |
| `pairs[].in_view_from` | first time from which α_t ≤ α until the end of the time in force; null if never [s] |
| `pairs[].in_view_fraction` | share of the time after settle with α_t ≤ α |
| `pairs[].in_force.from`, `.to`, `.total` | first and last time in force, duration; omitted if the whole run; also of `limits[]`, `safety.hard_distances[]` [s] |
| `idle_observers[].observer`, `.in_force` | an observer without present target, and when [s] |
| `agents[].name`, `.rms_position_error` | name; RMS of \|p - p*\| from `rms_from` on (10 s) [m] |
| `agents[].position_offset`, `.tracking_error` | its steady part, \|mean of p - p*\|, and RMS of the remainder; only with a reference [m] |
| `agents[].rms_heading_error` | RMS heading error from `rms_from` on; only if Q weighs a heading of the reference [rad] |
| `agents[].energy` | Σ Δt u'R u of the applied input [s] |
| `agents[].input_rate_ratio` | largest rate of an applied input over `rate_max`, if given; above 1 the barrier intervened, or a limit jumped |
| `limits[].name`, `.fraction`, `.longest` | a soft limit; share of the time, longest time [s], in which it was broken |
| `limits[].worst`, `.unit` | largest excess; its unit, `m`, `rad`, or `in the unit of its formula` |
| `chatter[].agent`, `.input` | an input that reversed in 45 of 50 consecutive periods, by at least 1 % of its range |
| `chatter[].from`, `.share`, `.jump` | begin [s]; share of the time; mean change per period |
| `chatter[].region` | whether the robot feels a limit as text: a larger `smooth` (0.01) or `R` damps the oscillation |
| `drift[].agent` | a controlled robot that moved steadily away in the last 5 to 10 s: from its reference if Q weighs its position; else from the bodies along its couplings that do not move freely; else from its place. `drift` is null if less than 5 s passed since settle or the last change of the team |
| `drift[].speed`, `.velocity`, `.from_reference` | mean velocity in G; whether away from a reference [m/s] |
| `events[].time`, `.name` | the first 1000 events (the log has all); [texts](notation.md#events) [s] |
| `safety.barrier` | `off`, `on`, `report`; `safety` is present with a hard distance, a judged wall, a barrier or a certified view |
| `safety.hard_distances[].a`, `.b`, `.d_hard` | two bodies and their hard distance; the eight worst [m] |
| `safety.hard_distances[].least`, `.time`, `.kept` | least distance [m] while both were present (else null), also between samples; its time [s]; whether `d_hard` was kept (to 1e-9 m) |
| `safety.walls[].name`, `.wall`, `.limit` | a robot and a `floor`, `ceiling` or `world`; the eight worst of each [m] |
| `safety.walls[].worst`, `.time`, `.kept` | extreme height, \|p_x\| or \|p_y\| [m], also between samples; its time [s]; whether the limit was kept (to 1e-6 m). A landing robot has no floor |
| `safety.zones[].name`, `.zone`, `.keep` | a robot, the index of a `[[safety.zone]]`, and the side to keep, `inside` or `outside`; the eight worst |
| `safety.zones[].least`, `.time`, `.kept` | least distance to the boundary, negative on the wrong side, also between samples (to 1e-4 m) [m]; its time [s]; whether the side was kept (to 1e-6 m). For a landing robot a room has no floor |
| `safety.hard_distances[].broken_for`, `.outside_at_start`, also of `safety.walls[]`, `safety.zones[]` | how long the limit was broken; with `start_outside`, until it was first kept (omitted if 0) [s] |
| `safety.unseen_periods` | missed periods without known true states, [safety.md](safety.md) |
| `localization[].agent`, `.known_from`, `.rmse`, `.heading_rmse`, `.anees`, `.sigma_max` | a vision-localized robot; first estimate [s]; errors after settle [m, rad], null if the truth is unknown; 4 is consistent; largest standard deviation of the position [m] |
| `localization[].detections`, `.rejected`, `.restarts`, `.longest_without_sight` | of the filter: detections, those beyond its gate, its restarts; longest time between two accepted [s] |
| `safety.agents[].barrier_active`, `.barrier_conflict` | share of the updates in which the barrier changed the command; in which no command satisfied all conditions |
| `safety.views[].observer`, `.target`, `.speed_max` | a certified view, and the speed of the target for which it is [m/s] |
| `safety.views[].in_force` | share of the updates in which it was in force |
| `safety.views[].certified`, `.active`, `.reserve` | share of these updates in which it was certified; in which its filter changed the command; least reserve of its set while certified, null if never [m] |
| `safety.views[].uncertified` | number of events `view_uncertified` |
| `real_time.periods`, `.missed`, `.wake_us`, `.arrival_us`, `.cpu` | of a flight over links, [flying.md](flying.md) [µs, cores] |
)";

/// A word of these keys; any other does not compile.
consteval const char* operator""_key(const char* word, std::size_t size) {
  constexpr std::string_view table = summary_keys;
  for (std::size_t i = table.find(word, table.find("\n")); i < table.size(); i = table.find(word, i + 1)) {
    const std::size_t line = table.rfind('\n', i);
    const bool in_keys = table.substr(line, i - line).find(" | ") == table.npos;
    if (in_keys && std::string_view("`.").find(table[i - 1]) != table.npos &&
        std::string_view("`.[").find(table[i + size]) != table.npos)
      return word;
  }
  throw "a key without a description";
}

}  // namespace sightline
