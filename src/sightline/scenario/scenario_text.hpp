/// The text of a scenario before its meaning: is it a file, is it text, can its refusal be said in one line.
#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

namespace sightline {

/// A scenario that was refused; what() is one line, `file:line: key = value, expected ...`; within a formula
/// `file:line:column: ...`, columns in characters.
class ScenarioError : public std::runtime_error {
 public:
  /// Control characters and bytes that are not UTF-8 are escaped, so that it stays one line.
  /// @param line  0 for what stands in no line of the file
  ScenarioError(std::string_view file, std::size_t line, std::string_view sentence);
  ScenarioError(std::string_view file, std::size_t line, std::size_t column, std::string_view sentence);

  /// The file, or the name of another layer, "--set KEY=VALUE".
  const std::string& file() const { return file_; }
  /// What is wrong, without its place.
  const std::string& sentence() const { return sentence_; }

 private:
  ScenarioError(std::string_view file, const std::string& place, std::string_view sentence);

  std::string file_, sentence_;
};

/// Largest scenario that is read [bytes].
inline constexpr std::size_t scenario_size_max = 10'000'000;

/// Most parts of a dotted key or header, `a.b.c`; the parser's own recursion is bounded by this.
inline constexpr int key_parts_max = 16;

/// The text with control characters, separators of lines and bytes that are not UTF-8 as \n, \u0007 or \xff.
std::string one_line(std::string_view text);

/// At most `size` bytes of the text, cut between two characters and marked with "...".
std::string shortened(std::string_view text, std::size_t size);
inline constexpr std::size_t shown_size = 60;  ///< of a key or a value in a message [bytes]

/// The content of a regular file; never waits on a pipe or a device.
/// @throws ScenarioError where it is none, cannot be read or is too large
std::string read_text(const std::filesystem::path& file);

/// Texts of files that a scenario names, by the names it gives them.
using FileTexts = std::map<std::string, std::string>;

/// @throws ScenarioError where the text is empty, not UTF-8, has control characters or keys of too many parts
void check_text(std::string_view text, std::string_view file);

}  // namespace sightline
