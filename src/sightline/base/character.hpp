/// Characters of texts.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// A character of UTF-8; size 0: the byte begins none.
struct Character {
  char32_t code = 0;
  std::size_t size = 0;
};

/// The character at the begin of a text, which must not be empty.
Character first_character(std::string_view text);

/// The pieces of a text between separators, in order; without a separator one, the text.
std::vector<std::string_view> split(std::string_view text, char separator);

/// The text without the characters of `around` at its ends.
std::string_view trimmed(std::string_view text, std::string_view around);

/// The text with a to z in place of A to Z.
std::string lower_case(std::string text);

}  // namespace sightline
