#include "sightline/base/sentence.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <variant>

namespace sightline {
namespace {

namespace fs = std::filesystem;

/// What is said of what `act` throws.
template <class Act>
std::string said(Act&& act) {
  try {
    act();
  } catch (const std::exception& error) {
    return sentence_of(error);
  }
  return "nothing was thrown";
}

TEST(Sentence, OurOwnWordsStayAndThoseOfLibrariesAreTranslated) {
  EXPECT_EQ(said([] { throw std::invalid_argument("a = 1, expected 2"); }), "a = 1, expected 2");
  const fs::path folder = fs::temp_directory_path() / "sightline_sentence_test";
  fs::remove_all(folder);
  fs::create_directories(folder);
  fs::create_symlink("b", folder / "a");
  fs::create_symlink("a", folder / "b");
  EXPECT_EQ(said([&] { (void)fs::is_directory(folder / "a"); }),
            (folder / "a").native() +
                ": cannot be used (Too many levels of symbolic links), expected a file or a folder");
  fs::remove_all(folder);
  EXPECT_EQ(said([] { (void)std::get<int>(std::variant<int, double>(0.5)); }), "a value is of another kind");
  EXPECT_EQ(said([] { const auto read = nlohmann::json::parse("{\"a\": nothing}"); }),
            "no JSON from byte 8 on");
  EXPECT_EQ(said([] { (void)nlohmann::json::parse("{}").at("a"); }),
            "a value of the JSON is missing or of another kind");
  EXPECT_EQ(said([] { (void)nlohmann::json::parse("3").get<std::string>(); }),
            "a value of the JSON is missing or of another kind");
  EXPECT_EQ(said([] { throw std::bad_alloc(); }), "there is not enough memory");
}

}  // namespace
}  // namespace sightline
