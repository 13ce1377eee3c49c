#include "sightline/base/text_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/support/command.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using test::read_file;
using testing::HasSubstr;

TEST(TextFile, TakesItsPlaceWholeAndIsWrittenOnThere) {
  const fs::path file = test::fresh_folder() / "a.txt";
  std::ofstream(file) << "an earlier text";
  TextFile text(file);
  text.write("begun");
  EXPECT_EQ(read_file(file), "an earlier text");
  text.settle();
  EXPECT_EQ(read_file(file), "begun");
  text.write(", gone on");
  text.close();
  EXPECT_EQ(read_file(file), "begun, gone on");
  EXPECT_FALSE(fs::exists(beside(file)));
  EXPECT_EQ(text.error(), "");
}

TEST(TextFile, WhatCannotTakeItsPlaceLeavesNothingAndIsSaidOnce) {
  const fs::path folder = test::fresh_folder(), file = folder / "a.txt";
  fs::create_directories(file / "full");
  TextFile text(file);
  text.write("lost");
  text.settle();
  EXPECT_THAT(text.error(), HasSubstr("a.txt cannot be put in its place: "));
  const std::string said = text.error();
  text.write("more");
  text.settle();
  text.close();
  EXPECT_EQ(text.error(), said);
  EXPECT_FALSE(fs::exists(beside(file)));
}

// A pipe that nobody reads would hold up whoever opens it.
TEST(TextFile, WhatStandsBesideItsPlaceIsNeitherOpenedNorFollowed) {
  const fs::path folder = test::fresh_folder(), file = folder / "a.txt", elsewhere = folder / "elsewhere";
  ASSERT_EQ(::mkfifo(beside(file).c_str(), 0666), 0);
  write_text(file, "one");
  EXPECT_EQ(read_file(file), "one");
  std::ofstream(elsewhere) << "of others";
  fs::create_symlink(elsewhere, beside(file));
  write_text(file, "two");
  EXPECT_EQ(read_file(file), "two");
  EXPECT_EQ(read_file(elsewhere), "of others");
}

TEST(TextFile, ATextThatCannotBeWrittenIsNamed) {
  try {
    write_text(test::fresh_folder() / "nowhere" / "page.html", "");
    FAIL() << "expected a refusal";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("nowhere/page.html cannot be written: No such file"));
  }
}

}  // namespace
}  // namespace sightline
