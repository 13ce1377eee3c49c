#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "sightline/scenario.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

std::filesystem::path scratch() {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "sightline_text" / test->name();
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

TEST(ScenarioText, ARefusalStaysOneLineWhateverItQuotes) {
  EXPECT_EQ(one_line("a\nb\tc\rd\x1b[31m\x7f"), "a\\nb\\tc\\rd\\u001b[31m\\u007f");
  EXPECT_EQ(one_line("\xc2\x85 \xe2\x80\xa8 \xe2\x80\xa9"), "\\u0085 \\u2028 \\u2029");
  EXPECT_EQ(one_line("κ_G m² \xf0\x9f\x9a\x81"), "κ_G m² \xf0\x9f\x9a\x81");
  EXPECT_EQ(one_line("\xff\xc0\xaf\xed\xa0\x80\xe2\x80"), "\\xff\\xc0\\xaf\\xed\\xa0\\x80\\xe2\\x80");
}

TEST(ScenarioText, ShorteningNeverCutsACharacter) {
  const std::string text = "abκκκκ";
  for (std::size_t size = 0; size <= text.size(); ++size) {
    const std::string cut = shortened(text, size);
    EXPECT_EQ(one_line(cut), cut) << size;
    EXPECT_LE(cut.size(), size + 3);
  }
  EXPECT_EQ(shortened(text, text.size()), text);
}

TEST(ScenarioText, AFileIsReadAsItIs) {
  const auto file = scratch() / "a.toml";
  const std::string text = "\xef\xbb\xbf# comment\r\n\ta = 1\n";
  std::ofstream(file, std::ios::binary) << text;
  EXPECT_EQ(read_text(file), text);
}

TEST(ScenarioText, WhatIsNoFileIsRefusedWithoutWaiting) {
  const auto folder = scratch();
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  ASSERT_EQ(::symlink("loop", (folder / "loop").c_str()), 0);
  const auto say = [](const std::filesystem::path& p) {
    return refusal_of<ScenarioError>([&] { read_text(p); });
  };
  EXPECT_EQ(say(folder), folder.string() + ":1: this is a directory, expected a scenario file");
  EXPECT_EQ(say(folder / "pipe"),
            (folder / "pipe").string() + ":1: this is a pipe, expected a scenario file");
  EXPECT_EQ(say("/dev/zero"), "/dev/zero:1: this is a device, expected a scenario file");
  EXPECT_EQ(say(folder / "loop").find((folder / "loop").string() + ":1: cannot be read ("), 0U);
  EXPECT_EQ(say(folder / "no\nne"),
            folder.string() +
                "/no\\nne:1: cannot be read (No such file or directory), expected a scenario "
                "file");
  EXPECT_EQ(say(""), ":1: cannot be read (No such file or directory), expected a scenario file");
}

TEST(ScenarioText, AFileAboveTheLimitIsRefusedBeforeItIsRead) {
  const auto file = scratch() / "large.toml";
  std::ofstream(file).close();
  std::filesystem::resize_file(file, 100'000'000);
  EXPECT_EQ(refusal_of<ScenarioError>([&] { read_text(file); }),
            file.string() + ":1: too large, expected at most 10000000 bytes");
  std::filesystem::resize_file(file, scenario_size_max);
  EXPECT_EQ(read_text(file).size(), scenario_size_max);
}

TEST(ScenarioText, WhatIsNoTextIsRefusedAtItsLine) {
  const auto say = [](const std::string& text) {
    return refusal_of<ScenarioError>([&] { check_text(text, "a"); });
  };
  EXPECT_EQ(say(""), "a:1: the file is empty, expected at least one [agent.NAME]");
  EXPECT_EQ(say("# one\n# two \xff\n"), "a:2: the byte 0xff is not UTF-8, expected text");
  EXPECT_EQ(say("\xff\xfe[\0"), "a:1: the byte 0xff is not UTF-8, expected text");
  EXPECT_EQ(say(std::string("a = 1\n\n\0", 8)), "a:3: the control character 0x00, expected text");
  EXPECT_EQ(say("\x1b[31m"), "a:1: the control character 0x1b, expected text");
  EXPECT_EQ(say("# \xc0\xaf"), "a:1: the byte 0xc0 is not UTF-8, expected text");
  EXPECT_EQ(say("# \xed\xa0\x80"), "a:1: the byte 0xed is not UTF-8, expected text");
  EXPECT_EQ(say("# κ_G [1/m²]\r\n\ta = 1\n"), "");
}

TEST(ScenarioText, KeysHaveAtMostSixteenPartsWhereverTheyHide) {
  const auto key = [](int parts, const std::string& part) {
    std::string k = part;
    for (int i = 1; i < parts; ++i) k += " . " + part;
    return k;
  };
  const auto say = [](const std::string& text) {
    return refusal_of<ScenarioError>([&] { check_text(text, "a"); });
  };
  const std::string refused = "the key has too many parts, expected at most 16";
  for (const std::string part : {"a", "\"=\"", "'#'", "\"\\\"[\"", "''"}) {
    const std::string longer = key(17, part);
    EXPECT_EQ(say(key(16, part) + " = 1\n"), "") << part;
    EXPECT_EQ(say("x = 1\n" + longer + " = 1\n"), "a:2: " + refused) << part;
    EXPECT_EQ(say("[" + longer + "]\n"), "a:1: " + refused) << part;
    EXPECT_EQ(say("x = \"\"\"\n\"\"\" \n" + longer + " = 1\n"), "a:3: " + refused) << part;
    EXPECT_EQ(say("x = '''''a'''''\n" + longer + " = 1\n"), "a:2: " + refused) << part;
  }
}

TEST(ScenarioText, DotsInTextsCommentsAndNumbersAreNoParts) {
  const std::string dots(100, '.');
  for (const std::string before : {"# ", "x = \"", "x = '", "x = \"\"\"\n", "x = '''\n\\"}) {
    std::string after = before.substr(before.find_first_of("\"'#"));
    after = after[0] == '#' ? "" : after.substr(0, after.find_first_not_of(after[0]));
    EXPECT_NO_THROW(check_text(before + dots + after + "\n", "a")) << before;
  }
  std::string numbers = "x = [0.1";
  for (int i = 0; i < 100; ++i) numbers += ", 0.1";
  EXPECT_NO_THROW(check_text(numbers + "]\n", "a"));
}

}  // namespace
}  // namespace sightline
