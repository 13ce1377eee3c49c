/// Who makes threads and gives functions to libraries of C: one file each, where nothing thrown can end a flight.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/product_files.hpp"

namespace {

using sightline::test::product_files;
using sightline::test::text_of;
using sightline::test::tree;
using sightline::test::without_comments;
namespace fs = std::filesystem;

/// What makes a thread in this code, beside the functions of base/service_thread.hpp; empty where nothing does.
std::string thread_in(const std::string& code) {
  static const std::regex made(
      "std::j?thread\\b(?!::)|std::async\\b|\\bpthread_create\\b|\\bthrd_create\\b|\\bclone3?\\s*\\(");
  std::smatch match;
  return std::regex_search(code, match, made) ? match.str() : "";
}

/// A function that a library of C gets in this code beside those of base/c_callback.hpp; empty where none does.
std::string callback_in(const std::string& code) {
  static const std::regex given(
      "(dds_lset_\\w+|dds_set_(?:log|trace)_sink|sqlite3_\\w*(?:hook|handler|function|exec)\\w*|\\batexit|"
      "\\bqsort|\\W::signal)\\s*"
      "\\(([^;]*)|(mju_user_\\w+|mjcb_\\w+|sa_handler|sa_sigaction)\\s*=\\s*([^;=]*)");
  for (auto at = std::sregex_iterator(code.begin(), code.end(), given); at != std::sregex_iterator(); ++at) {
    const std::string to = (*at)[1].matched ? (*at)[2] : (*at)[4];
    static const std::regex harmless("c_callback<|SIG_IGN|SIG_DFL|nullptr\\s*\\)|NULL\\s*\\)");
    if (!std::regex_search(to, harmless)) return at->str();
  }
  return "";
}

TEST(Threads, AreMadeByServiceThreadAlone) {
  const std::vector<fs::path> files = product_files();
  ASSERT_GT(files.size(), 300U);
  for (const fs::path& file : files) {
    if (file == tree / "src/sightline/base/service_thread.hpp") continue;
    EXPECT_EQ(thread_in(without_comments(text_of(file))), "") << file;
  }
}

TEST(Threads, LibrariesOfCGetFunctionsThatThrowNothing) {
  for (const fs::path& file : product_files())
    EXPECT_EQ(callback_in(without_comments(text_of(file))), "") << file;
}

TEST(Threads, TheRulesFindWhatTheyForbid) {
  EXPECT_EQ(thread_in(without_comments("std::thread other([] {}); // std::jthread")), "std::thread");
  EXPECT_EQ(thread_in("std::vector<std::jthread> all;"), "std::jthread");
  EXPECT_EQ(thread_in("pthread_create(&t, nullptr, run, nullptr);"), "pthread_create");
  EXPECT_EQ(thread_in("auto f = std::async(work);"), "std::async");
  EXPECT_EQ(thread_in(without_comments(
                "std::thread::hardware_concurrency(); std::this_thread::yield(); // std::thread")),
            "");
  EXPECT_NE(callback_in("dds_lset_data_available(listener.get(), on_data);"), "");
  EXPECT_NE(callback_in("mju_user_error = on_error;"), "");
  EXPECT_NE(callback_in("action.sa_handler = on_interrupt;"), "");
  EXPECT_EQ(callback_in("dds_lset_data_available(listener.get(), c_callback<on_data>);"), "");
  EXPECT_EQ(callback_in("mju_user_error = c_callback<on_error>; ::signal(SIGPIPE, SIG_IGN);"), "");
}

}  // namespace
