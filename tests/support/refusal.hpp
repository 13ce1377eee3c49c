/// What a call that should be refused says.
#pragma once

#include <fmt/format.h>

#include <limits>
#include <stdexcept>
#include <string>

namespace sightline {

inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
inline constexpr double infinite = std::numeric_limits<double>::infinity();

/// The sentence of the `Error` that `call` throws; empty where it throws none.
template <class Error = std::invalid_argument, class Call>
std::string refusal_of(Call&& call) {
  try {
    call();
  } catch (const Error& refusal) {
    return refusal.what();
  }
  return "";
}

}  // namespace sightline
