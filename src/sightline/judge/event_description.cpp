#include "sightline/judge/event_description.hpp"

#include <fmt/format.h>

#include "sightline/loop.hpp"
#include "sightline/supervisor.hpp"

namespace sightline {
namespace {

constexpr std::string_view measurement = "measurement_";

bool is_a_level(std::string_view kind) {
  for (int i = 0; i < fallback_level_count; ++i) {
    if (kind == to_string(static_cast<FallbackLevel>(i))) return true;
  }
  return false;
}

}  // namespace

bool is_of_a_body(std::string_view kind) {
  return is_a_level(kind) || kind.starts_with(measurement) ||
         kind == to_string(EventKind::barrier_conflict) || kind == to_string(EventKind::input_refused) ||
         kind == to_string(EventKind::added_too_near) || kind == to_string(EventKind::search) ||
         kind == to_string(EventKind::found) || kind == to_string(EventKind::stale) ||
         kind == to_string(EventKind::received) || kind == to_string(EventKind::robot_ready) ||
         kind == to_string(EventKind::robot_refused) || kind == to_string(EventKind::view_certified) ||
         kind == to_string(EventKind::view_uncertified) || kind == to_string(EventKind::view_handed_over);
}

bool is_of_the_script(std::string_view kind) {
  return kind == to_string(EventKind::event_occurred) || kind == to_string(EventKind::event_in_force) ||
         kind == to_string(EventKind::event_ignored);
}

std::string event_words(std::string_view kind, double value, const EventNames& names) {
  const bool counts = value >= 0 && value < 1e9;
  if (is_of_the_script(kind) && counts) {
    const std::string event = names.of_event(static_cast<int>(value));
    if (kind == to_string(EventKind::event_occurred)) return fmt::format("event \"{}\" happens", event);
    if (kind == to_string(EventKind::event_in_force)) return fmt::format("event \"{}\" in force", event);
    return fmt::format("event \"{}\" ignored: it cannot be", event);
  }
  if (kind == to_string(EventKind::pairs_left_out)) {
    return fmt::format("{} near pairs more than there is room for", value);
  }
  if (!is_of_a_body(kind) || !counts) return fmt::format("{} {}", kind, value);
  const std::string body = names.of_body(static_cast<int>(value));
  if (kind == to_string(EventKind::input_refused)) return fmt::format("{} {}", kind, body);
  if (kind.starts_with(measurement)) {
    return fmt::format("{}: measurement refused, {}", body, kind.substr(measurement.size()));
  }
  if (kind == to_string(EventKind::added_too_near)) {
    return fmt::format("{}: added nearer to another body than it may be", body);
  }
  if (kind == to_string(EventKind::search)) return fmt::format("{}: searches for what it observes", body);
  if (kind == to_string(EventKind::found)) return fmt::format("{}: has found it", body);
  if (kind == to_string(EventKind::stale)) return fmt::format("{}: no messages of its part arrive", body);
  if (kind == to_string(EventKind::received))
    return fmt::format("{}: messages of its part arrive again", body);
  if (kind == to_string(EventKind::robot_ready)) return fmt::format("{}: has taken off and can join", body);
  if (kind == to_string(EventKind::robot_refused)) return fmt::format("{}: cannot join", body);
  if (kind == to_string(EventKind::view_certified)) return fmt::format("{}: view certified", body);
  if (kind == to_string(EventKind::view_uncertified)) return fmt::format("{}: view not certified", body);
  if (kind == to_string(EventKind::view_handed_over)) return fmt::format("{}: view handed over", body);
  if (kind == to_string(EventKind::barrier_conflict)) return fmt::format("{}: barrier conflict", body);
  return fmt::format("{}: {}", body, kind);
}

}  // namespace sightline
