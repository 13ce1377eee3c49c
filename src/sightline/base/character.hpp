/// Characters of texts.
#pragma once

#include <cstddef>
#include <string_view>

namespace sightline {

/// A character of UTF-8; size 0: the byte begins none.
struct Character {
  char32_t code = 0;
  std::size_t size = 0;
};

/// The character at the begin of a text, which must not be empty.
Character first_character(std::string_view text);

}  // namespace sightline
