#include "sightline/solver/generator.hpp"

#include <gtest/gtest.h>

#include "sightline/model/robots.hpp"
#include "sightline/potential/distance.hpp"

namespace sightline {
namespace {

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (std::size_t i = text.find(word); i != std::string::npos; i = text.find(word, i + 1)) ++n;
  return n;
}

TEST(Generator, EachStructureIsPrintedOnce) {
  Generator generator(Generator::For::user);
  generator.add(Multirotor{}, Seen::pose);
  generator.add(Multirotor{.b_psi = 1.7}, Seen::pose);
  generator.add(AngleMultirotor{}, Seen::pose);
  generator.add({0.4 * KeepOut{}});
  generator.add({0.3 * KeepOut{}});
  EXPECT_EQ(count(generator.text(), "struct Stage_"), 2u);
  EXPECT_EQ(count(generator.text(), "struct Formula_"), 2u) << "between robots, and around what is not one";
}

TEST(Generator, AUsersFileRegistersAndTheLibrarysIsAskedFor) {
  EXPECT_EQ(count(Generator(Generator::For::user).text(), "register_kernels(table)"), 1u);
  EXPECT_EQ(count(Generator(Generator::For::library).text(), "built_in_kernels()"), 1u);
}

TEST(Generator, AFileThatCannotBeWrittenIsSaid) {
  EXPECT_FALSE(Generator(Generator::For::user).write("/no/such/folder/kernels.cpp"));
}

}  // namespace
}  // namespace sightline
