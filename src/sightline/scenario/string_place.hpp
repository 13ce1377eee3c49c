/// Where a byte of a string's content stands in the file that holds the string.
#pragma once

#include <cstddef>
#include <string_view>

namespace sightline {

/// Counted from 1, columns in characters.
struct TextPlace {
  std::size_t line = 1, column = 1;

  bool operator==(const TextPlace&) const = default;
};

/// The place of byte `offset` of `content`; escapes, several lines and characters of several bytes are seen
/// through.
///
/// @param document  TOML
/// @param quote     place of the first quote of the string, of any of the four kinds
/// @param content   what the string means; where the document says otherwise, the answer is `quote`
TextPlace place_in_string(std::string_view document, TextPlace quote, std::string_view content,
                          std::size_t offset);

}  // namespace sightline
