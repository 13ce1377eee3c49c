#include "sightline/judge/time_in_force.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "sightline/base/json_text.hpp"
#include "sightline/judge/summary_keys.hpp"

namespace sightline {

void TimeInForce::count(double time, double period) {
  if (total == 0) from = time;
  to = time + period;
  total += period;
}

bool TimeInForce::is_whole(double end) const {
  constexpr double rounding = 1e-6;  // relative error of a sum of periods
  return total >= end * (1 - rounding);
}

std::string TimeInForce::json() const {
  return json_text(nlohmann::ordered_json{{"from"_key, from}, {"to"_key, to}, {"total"_key, total}});
}

std::string time_words(std::string_view json) {
  const auto in_force = nlohmann::json::parse(json);
  const auto number = [&](const char* key) { return in_force.at(key).get<double>(); };
  return fmt::format("{:.1f} s, {:.1f} to {:.1f} s", number("total"), number("from"), number("to"));
}

}  // namespace sightline
