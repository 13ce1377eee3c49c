#include "sightline/run/sample.hpp"

namespace sightline {

std::string_view to_string(EventKind kind) {
  constexpr std::array<std::string_view, 4> names = {"missed_period", "solver_status", "input_refused",
                                                     "samples_dropped"};
  return names[static_cast<std::size_t>(kind)];
}

}  // namespace sightline
