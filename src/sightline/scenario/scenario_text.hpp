/// Reads and checks the text of a scenario before it is parsed, and defines ScenarioError.
#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

namespace sightline {

/// An invalid scenario. what() is one line, `file:line: key = value, expected ...`; within a
/// formula `file:line:column: ...`, columns in characters.
class ScenarioError : public std::runtime_error {
 public:
  /// Escapes control characters and bytes that are not UTF-8, so that what() stays one line.
  /// @param line  0 for an error that belongs to no line of the file
  ScenarioError(std::string_view file, std::size_t line, std::string_view sentence);
  ScenarioError(std::string_view file, std::size_t line, std::size_t column, std::string_view sentence);

  /// The file, or the name of another layer, "--set KEY=VALUE".
  const std::string& file() const { return file_; }
  /// The error, without its place.
  const std::string& sentence() const { return sentence_; }

 private:
  ScenarioError(std::string_view file, const std::string& place, std::string_view sentence);

  std::string file_, sentence_;
};

/// Largest size of a scenario [bytes].
inline constexpr std::size_t scenario_size_max = 10'000'000;

/// Greatest number of parts of a dotted key or header, `a.b.c`; bounds the recursion of the parser.
inline constexpr int key_parts_max = 16;

/// The text with control characters, line separators and bytes that are not UTF-8 as \n, \u0007 or
/// \xff.
std::string one_line(std::string_view text);

/// At most `size` bytes of the text, cut between two characters and marked with "...".
std::string shortened(std::string_view text, std::size_t size);
inline constexpr std::size_t shown_size = 60;  ///< of a key or a value in a message [bytes]

/// The content of a regular file; never waits on a pipe or a device.
/// @throws ScenarioError if the file is not regular, cannot be read or is too large
std::string read_text(const std::filesystem::path& file);

/// Texts of files that a scenario names, by these names.
using FileTexts = std::map<std::string, std::string>;

/// @throws ScenarioError if the text is not UTF-8, is empty, or has control characters or keys with
/// too many parts
void check_text(std::string_view text, std::string_view file);

}  // namespace sightline
