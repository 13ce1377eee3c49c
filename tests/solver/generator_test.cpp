#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "sightline/kernels.hpp"
#include "sightline/model.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/folder.hpp"

namespace sightline {
namespace {

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (std::size_t i = text.find(word); i != std::string::npos; i = text.find(word, i + 1)) ++n;
  return n;
}

TEST(Generator, EachStructureIsPrintedOnceWhateverItsParameters) {
  Generator generator;
  generator.add(Multirotor{}, Seen::pose);
  generator.add(Multirotor{.b_z = 0.7, .b_psi = 1.7, .a_f = -0.3, .b_f = 1, .a_s = -2, .b_s = 3}, Seen::pose);
  generator.add(AngleMultirotor{}, Seen::pose);
  generator.add({0.4 * KeepOut{}});
  generator.add({0.3 * KeepOut{}});
  EXPECT_EQ(count(generator.text(), "struct Stage_"), 2u);
  EXPECT_EQ(count(generator.text(), "struct Formula_"), 4u)
      << "derivatives and value, between robots, and around what is not one";
}

TEST(Generator, AFileThatHoldsTheTextIsLeftAsItIs) {
  const std::string path = test::fresh_folder() / "kernels.cpp";
  ASSERT_TRUE(write_text(path, "one"));
  std::filesystem::last_write_time(path,
                                   std::filesystem::file_time_type::clock::now() - std::chrono::hours(1));
  const auto written = std::filesystem::last_write_time(path);
  EXPECT_TRUE(write_text(path, "one"));
  EXPECT_EQ(std::filesystem::last_write_time(path), written);
  EXPECT_TRUE(write_text(path, "two"));
  EXPECT_NE(std::filesystem::last_write_time(path), written);
  EXPECT_FALSE(write_text("/no/such/folder/kernels.cpp", "one"));
}

}  // namespace
}  // namespace sightline
