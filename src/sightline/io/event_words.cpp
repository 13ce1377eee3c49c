#include "sightline/io/event_words.hpp"

#include <fmt/format.h>

#include "sightline/run/sample.hpp"
#include "sightline/safety/ladder.hpp"

namespace sightline {
namespace {

constexpr std::string_view measurement = "measurement_";

bool is_a_rung(std::string_view kind) {
  for (int i = 0; i < rung_count; ++i) {
    if (kind == to_string(static_cast<Rung>(i))) return true;
  }
  return false;
}

}  // namespace

bool is_of_a_body(std::string_view kind) {
  return is_a_rung(kind) || kind.starts_with(measurement) || kind == to_string(EventKind::barrier_conflict) ||
         kind == to_string(EventKind::input_refused);
}

std::string event_words(std::string_view kind, double value, const std::function<std::string(int)>& name) {
  if (!is_of_a_body(kind) || !(value >= 0 && value < 1e9)) return fmt::format("{} {}", kind, value);
  const std::string body = name(static_cast<int>(value));
  if (kind == to_string(EventKind::input_refused)) return fmt::format("{} {}", kind, body);
  if (kind.starts_with(measurement)) {
    return fmt::format("{}: measurement refused, {}", body, kind.substr(measurement.size()));
  }
  if (kind == to_string(EventKind::barrier_conflict)) return fmt::format("{}: barrier conflict", body);
  return fmt::format("{}: {}", body, kind);
}

}  // namespace sightline
