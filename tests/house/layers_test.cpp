/// The order of the house: who may include whom, who tests what, and how long a file may be.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/support/tree.hpp"

namespace {

using sightline::test::tree;
namespace fs = std::filesystem;

const std::vector<std::string> code_folders = {"src",    "worlds",   "bridges", "cli",
                                               "python", "examples", "bench",   "tests"};

/// Height of each layer; those of one height do not know each other.
const std::map<std::string, int> height = {
    {"base", 0},      {"math", 1},      {"plot", 1},     {"formula", 2}, {"model", 3},
    {"potential", 4}, {"ocp", 5},       {"solver", 6},   {"safety", 6},  {"estimate", 6},
    {"world", 7},     {"run", 8},       {"scenario", 9}, {"record", 10}, {"report", 11},
    {"campaign", 12}, {"analysis", 12}, {"studies", 13}, {"server", 13}};

/// What is wrong with a file of `layer` that includes `included`; empty if nothing is.
std::string include_fault(const std::string& layer, const std::string& included) {
  static const std::regex ours("sightline/(\\w+)/.*");
  std::smatch match;
  if (!included.starts_with("sightline/")) return "";
  if (!std::regex_match(included, match, ours)) return "names no layer";
  const std::string other = match[1];
  if (!height.contains(layer)) return "is included from " + layer + ", which is no layer";
  if (!height.contains(other)) return "is in " + other + ", which is no layer";
  if (other == layer || height.at(other) < height.at(layer)) return "";
  return "is in " + other + ", which is not below " + layer;
}

bool is_of_dds(const std::string& included) {
  static const std::regex dds("(dds|ddsc|ddscxx|fastdds|fastrtps|fastcdr|rclcpp|rcl|rmw)/.*");
  return std::regex_match(included, dds);
}

/// Names between the <> or "" of all #include lines.
std::vector<std::string> includes(const fs::path& file) {
  static const std::regex line_form("\\s*#\\s*include\\s*[<\"]([^>\"]+)[>\"].*");
  std::vector<std::string> names;
  std::ifstream text(file);
  std::smatch match;
  for (std::string line; std::getline(text, line);)
    if (std::regex_match(line, match, line_form)) names.push_back(match[1]);
  return names;
}

/// All C++ files below a folder of the tree, in the order of their names.
std::vector<fs::path> files_of(const std::string& folder) {
  std::vector<fs::path> files;
  if (!fs::exists(tree / folder)) return files;
  for (auto entry = fs::recursive_directory_iterator(tree / folder); entry != fs::end(entry); ++entry) {
    if (entry->path().filename() == "node_modules") entry.disable_recursion_pending();
    const fs::path extension = entry->path().extension();
    if (extension == ".hpp" || extension == ".cpp") files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<fs::path> all_files() {
  std::vector<fs::path> files;
  for (const std::string& folder : code_folders)
    for (const fs::path& file : files_of(folder)) files.push_back(file);
  return files;
}

/// Layer of a file: the folder it lies in below src/sightline, empty for <sightline/sightline.hpp>.
std::string layer_of(const fs::path& file) {
  const fs::path below = fs::relative(file, tree / "src/sightline");
  return below.has_parent_path() ? below.begin()->string() : "";
}

std::string name(const fs::path& file) { return fs::relative(file, tree).string(); }

TEST(Layers, the_rule_accepts_lower_and_refuses_higher_and_equal_layers) {
  EXPECT_EQ(include_fault("solver", "sightline/ocp/ocp.hpp"), "");
  EXPECT_EQ(include_fault("solver", "sightline/solver/continuation/gmres.hpp"), "");
  EXPECT_EQ(include_fault("math", "vector"), "");
  EXPECT_EQ(include_fault("math", "sightline/record/log.hpp"), "is in record, which is not below math");
  EXPECT_EQ(include_fault("safety", "sightline/solver/continuation/gmres.hpp"),
            "is in solver, which is not below safety");
  EXPECT_EQ(include_fault("world", "sightline/attic/old.hpp"), "is in attic, which is no layer");
  EXPECT_EQ(include_fault("world", "sightline/sightline.hpp"), "names no layer");
}

TEST(Layers, a_file_includes_its_own_or_a_lower_layer) {
  const std::vector<fs::path> files = files_of("src/sightline");
  ASSERT_FALSE(files.empty());
  for (const fs::path& file : files) {
    if (layer_of(file).empty()) continue;
    for (const std::string& included : includes(file)) {
      const std::string fault = include_fault(layer_of(file), included);
      EXPECT_TRUE(fault.empty()) << name(file) << " includes " << included << ", which " << fault;
    }
  }
}

TEST(Layers, sources_name_our_headers_from_the_root_of_the_includes) {
  for (const fs::path& file : files_of("src/sightline"))
    for (const std::string& included : includes(file))
      EXPECT_FALSE(fs::exists(file.parent_path() / included) || included.starts_with("../"))
          << name(file) << " includes " << included << ", expected sightline/<layer>/<file>.hpp";
}

TEST(Layers, the_library_knows_none_of_its_users) {
  for (const fs::path& file : files_of("src/sightline"))
    for (const std::string& included : includes(file))
      for (const std::string& folder : code_folders)
        EXPECT_FALSE(included.starts_with(folder + "/"))
            << name(file) << " includes " << included << ", expected nothing of " << folder;
}

TEST(Layers, a_dds_header_occurs_in_bridges_and_their_tests_alone) {
  EXPECT_TRUE(is_of_dds("dds/dds.h") && is_of_dds("fastdds/dds/domain/DomainParticipant.hpp"));
  EXPECT_FALSE(is_of_dds("sightline/record/cdr.hpp"));
  for (const fs::path& file : all_files()) {
    if (name(file).starts_with("bridges/") || name(file).starts_with("tests/dds/")) continue;
    for (const std::string& included : includes(file))
      EXPECT_FALSE(is_of_dds(included))
          << name(file) << " includes " << included << ", expected in bridges/ alone";
  }
}

// The module binds the library, and nobody knows of it.
TEST(Layers, pybind11_occurs_in_the_python_module_alone_and_nobody_includes_that) {
  int files = 0;
  for (const fs::path& file : all_files()) {
    const bool in_module = name(file).starts_with("python/");
    files += in_module ? 1 : 0;
    for (const std::string& included : includes(file)) {
      EXPECT_TRUE(in_module || !(included.starts_with("pybind11/") || included.starts_with("python/")))
          << name(file) << " includes " << included << ", expected in python/ alone";
      EXPECT_FALSE(in_module && (included.starts_with("cli/") || included.starts_with("bridges/")))
          << name(file) << " includes " << included;
    }
  }
  EXPECT_GT(files, 5);
}

// A bridge is known to programs.
TEST(Layers, a_bridge_is_known_to_programs_and_to_its_tests_alone) {
  int files = 0;
  for (const fs::path& file : all_files()) {
    const bool in_bridge = name(file).starts_with("bridges/");
    files += in_bridge ? 1 : 0;
    for (const std::string& included : includes(file)) {
      if (included != "sightline/dds.hpp" && !included.starts_with("bridges/")) continue;
      EXPECT_TRUE(in_bridge || name(file) == "cli/main.cpp" || name(file).starts_with("tests/dds/"))
          << name(file) << " includes " << included;
    }
  }
  EXPECT_GT(files, 10);
}

// A world of its own is told to the library by the program (Parts::worlds), as that of a user.
TEST(Layers, a_world_of_its_own_is_known_to_programs_and_tests_alone_and_its_engine_to_it_alone) {
  const std::string own = "worlds/", engine = "mujoco/";
  int files = 0;
  for (const fs::path& file : all_files()) {
    const bool in_world = name(file).starts_with(own);
    files += in_world ? 1 : 0;
    for (const std::string& included : includes(file)) {
      if (included.starts_with(engine)) {
        EXPECT_TRUE(name(file).starts_with("worlds/mujoco/"))
            << name(file) << " includes " << included << ", expected in worlds/mujoco/ alone";
      }
      if (included == "sightline/mujoco.hpp" || included.starts_with(own)) {
        EXPECT_TRUE(in_world || name(file) == "cli/main.cpp" || name(file).starts_with("tests/mujoco/") ||
                    name(file).starts_with("bench/"))
            << name(file) << " includes " << included;
      }
      if (in_world && included.starts_with(own)) {
        EXPECT_TRUE(fs::exists(tree / included)) << name(file) << " includes " << included;
      }
    }
  }
  EXPECT_GT(files, 0);
}

/// Classes that a file defines at the outermost level, by their namespaces; of unnamed ones, none.
std::vector<std::string> classes_of(const fs::path& file) {
  static const std::regex opens("(?:inline )?namespace ?([\\w:]*) ?\\{"),
      defines("(?:struct|class) (\\w+)(?!\\w|<|;|::).*");
  std::vector<std::string> spaces, classes;
  std::ifstream text(file);
  std::smatch match;
  for (std::string line; std::getline(text, line);) {
    if (std::regex_match(line, match, opens)) {
      spaces.push_back(match[1]);
    } else if (line.starts_with("}  // ") && line.find("namespace") != std::string::npos && !spaces.empty()) {
      spaces.pop_back();
    } else if (std::regex_match(line, match, defines) &&
               std::find(spaces.begin(), spaces.end(), "") == spaces.end()) {
      std::string path;
      for (const std::string& space : spaces) path += space + "::";
      classes.push_back(path + match[1].str());
    }
  }
  return classes;
}

/// The linker takes one of two classes of a name for both, and says nothing.
TEST(Layers, a_name_stands_for_one_class) {
  std::map<std::string, std::set<std::string>> files;
  for (const char* folder : {"src", "worlds", "bridges", "cli", "python"})
    for (const fs::path& file : files_of(folder))
      for (const std::string& named : classes_of(file)) files[named].insert(name(file));
  EXPECT_GT(files.size(), 500U);
  for (const auto& [named, where] : files)
    EXPECT_EQ(where.size(), 1U) << named << " is in " << testing::PrintToString(where);
}

TEST(Layers, every_public_header_has_a_test_of_its_name) {
  for (const fs::path& file : files_of("src/sightline")) {
    if (file.extension() != ".hpp" || layer_of(file).empty()) continue;
    const std::string test = file.stem().string() + "_test.cpp";
    const std::vector<fs::path> tests = files_of("tests/" + layer_of(file));
    const bool found =
        std::any_of(tests.begin(), tests.end(), [&](const fs::path& t) { return t.filename() == test; });
    EXPECT_TRUE(found) << name(file) << " has no test, expected tests/" << layer_of(file) << "/" << test;
  }
  std::vector<fs::path> of_components = files_of("worlds");
  for (const fs::path& file : files_of("bridges")) of_components.push_back(file);
  for (const fs::path& file : of_components) {
    if (name(file).find("/include/") == std::string::npos) continue;
    const fs::path test =
        "tests" / *std::next(fs::relative(file, tree).begin(), 1) / (file.stem().string() + "_test.cpp");
    EXPECT_TRUE(fs::exists(tree / test)) << name(file) << " has no test, expected " << test;
  }
}

}  // namespace
