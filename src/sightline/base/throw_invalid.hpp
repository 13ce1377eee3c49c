/// Rejects an argument: the message states the fault, the value and the expectation.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace sightline {

/// @throws std::invalid_argument with the formatted sentence, always
template <class... Args>
[[noreturn]] void throw_invalid(fmt::format_string<Args...> sentence, Args&&... args) {
  throw std::invalid_argument(fmt::format(sentence, std::forward<Args>(args)...));
}

}  // namespace sightline
