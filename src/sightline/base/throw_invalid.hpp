/// What refuses an argument: a sentence with what is wrong, its value, and what was expected.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace sightline {

/// @throws std::invalid_argument with the sentence, always
template <class... Args>
[[noreturn]] void throw_invalid(fmt::format_string<Args...> sentence, Args&&... args) {
  throw std::invalid_argument(fmt::format(sentence, std::forward<Args>(args)...));
}

}  // namespace sightline
