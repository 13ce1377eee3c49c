/// Scenarios that must be refused, as the tables in tests/scenarios/refused state them.
///
/// A section of a table begins with `## TITLE`; then come the lines that its cases share, one of
/// them `...`. A case begins with `### NAME: SENTENCE`. Its text is that line, then the shared ones
/// with its own in place of `...`. The lines that the sentence names are counted from the line with
/// the name. Empty lines before a section are left out.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/command.hpp"

namespace sightline::test {

struct RefusedScenario {
  std::string table;  ///< file it stands in, without ".toml"
  std::string name;   ///< small letters, digits and _; no other case in any table has it
  std::string
      sentence;      ///< what is said after the file's name and a colon: "LINE: ..." or "LINE:COLUMN: ..."
  std::string text;  ///< what the parser sees
};

/// The parts of a text that begin with lines of this mark, after what stands before the first of
/// them.
inline std::vector<std::string> parts_at(std::string_view mark, const std::string& text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find(fmt::format("\n{}", mark), begin)) != std::string::npos;) {
    parts.push_back(text.substr(begin, end + 1 - begin));
    begin = end + 1;
  }
  parts.push_back(text.substr(begin));
  return parts;
}

/// Adds the cases of one table to those of other tables.
/// @throws std::invalid_argument naming the table, the line that is wrong and what was expected.
inline void add_refused(const std::string& table, const std::string& content,
                        std::vector<RefusedScenario>& cases) {
  const auto expect = [&](bool holds, const std::string& at, std::string_view what) {
    if (holds) return;
    throw std::invalid_argument(fmt::format("{}: {}, expected {}", table, at.substr(0, at.find('\n')), what));
  };
  static const std::regex head("### ([a-z0-9_]+): (.+)");
  std::vector<std::string> sections = parts_at("## ", "\n" + content);
  expect(sections[0].find("\n### ") == std::string::npos, "the first case", "a section before it");
  sections.erase(sections.begin());
  for (const std::string& section : sections) {
    std::vector<std::string> stated = parts_at("### ", section);
    const std::string shared = stated[0].substr(stated[0].find('\n'));
    const std::size_t gap = shared.find("\n...\n");
    expect(gap != std::string::npos && shared.find("\n...\n", gap + 4) == std::string::npos, section,
           "one line ... for what is a case's own");
    expect(shared.find("\n#") == std::string::npos, section, "no comments: a case would be hidden in one");
    expect(stated.size() > 1, section, "cases");
    stated.erase(stated.begin());
    for (std::string& own : stated) {
      while (own.ends_with("\n\n")) own.pop_back();
      std::smatch said;
      const std::string first = own.substr(0, own.find('\n'));
      expect(std::regex_match(first, said, head), first, "### NAME: SENTENCE");
      expect(own.find("\n#") == std::string::npos, first, "no comments: a case would be hidden in one");
      const std::string name = said[1];
      expect(std::none_of(cases.begin(), cases.end(), [&](const auto& c) { return c.name == name; }), first,
             "a name that no other case has");
      const std::size_t end = std::min(own.size(), first.size() + 1);
      cases.push_back(
          {table, name, said[2],
           own.substr(0, end) + shared.substr(1, gap) + own.substr(end) + shared.substr(gap + 5)});
    }
  }
}

/// All cases of all tables.
inline std::vector<RefusedScenario> refused_scenarios() {
  std::vector<RefusedScenario> cases;
  for (const auto& entry :
       std::filesystem::directory_iterator(SIGHTLINE_SOURCE_DIR "/tests/scenarios/refused"))
    add_refused(entry.path().stem().string(), read_file(entry.path()), cases);
  return cases;
}

}  // namespace sightline::test
