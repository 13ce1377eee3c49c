#include "sightline/solver.hpp"

#include <array>

namespace sightline {

std::string_view to_string(Status status) {
  constexpr std::array<std::string_view, status_count> names = {"converged", "stepped",    "iteration_limit",
                                                                "deadline",  "not_finite", "invalid_state"};
  return names[static_cast<std::size_t>(status)];
}

}  // namespace sightline
