#include <array>

#include "sightline/base.hpp"
#include "sightline/potential.hpp"
#include "sightline/world.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

void check_window(double from, double until, double delay) {
  require(from >= 0, "fault", "from", from, ">= 0 s");
  const double end = until < std::numeric_limits<double>::infinity() ? until : from + 1.0;
  require(end > from, "fault", "until", end, "> from");
  require(delay >= 0 && delay <= longest_fault_delay, "fault", "delay", delay, "0 to 10 s");
}

}  // namespace

std::string_view to_string(FaultKind kind) {
  constexpr std::array<std::string_view, 5> names = {"dropout", "delay", "freeze", "nan", "jump"};
  return names[static_cast<std::size_t>(kind)];
}

void Fault::check() const {
  check_window(from, until, delay);
  require(probability >= 0 && probability <= 1, "fault", "probability", probability, "0 to 1");
  for (const double d : {offset.x, offset.y, offset.z}) require(true, "fault", "offset", d, "finite m");
}

bool Fault::strikes(BodyId at, double t) const noexcept {
  return (body.index < 0 || body == at) && t >= from - same_time && t < until - same_time;
}

void LatePlan::check() const { check_window(from, until, delay); }

bool LatePlan::strikes(double t) const noexcept { return t >= from - same_time && t < until - same_time; }

}  // namespace sightline
