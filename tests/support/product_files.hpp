/// The sources of the product, for tests of what none of them may have.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/tree.hpp"

namespace sightline::test {

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream text(file);
  return {std::istreambuf_iterator<char>(text), {}};
}

/// Without comments.
inline std::string without_comments(const std::string& text) {
  static const std::regex comment("//[^\n]*|/\\*[\\s\\S]*?\\*/");
  return std::regex_replace(text, comment, "");
}

inline std::vector<std::filesystem::path> product_files() {
  std::vector<std::filesystem::path> files;
  for (const char* folder : {"src", "worlds", "bridges", "cli", "python", "bench", "examples"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(tree / folder)) {
      const std::filesystem::path extension = entry.path().extension();
      if (extension == ".hpp" || extension == ".cpp") files.push_back(entry.path());
    }
  }
  return files;
}

}  // namespace sightline::test
