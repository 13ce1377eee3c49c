/// Finds the place in a file of a byte in a string's content.
#pragma once

#include <cstddef>
#include <string_view>

namespace sightline {

/// Counted from 1, columns in characters.
struct TextPlace {
  std::size_t line = 1, column = 1;

  bool operator==(const TextPlace&) const = default;
};

/// The place of byte `offset` of `content`. Resolves escapes, strings of several lines and
/// characters of several bytes.
///
/// @param document  TOML
/// @param quote     place of the first quote of the string, of any of the four kinds
/// @param content   parsed content of the string; if the document differs, the result is `quote`
TextPlace place_in_string(std::string_view document, TextPlace quote, std::string_view content,
                          std::size_t offset);

}  // namespace sightline
