#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "sightline/log.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

std::string lock_refusal(const fs::path& folder, std::initializer_list<std::string_view> files = {}) {
  return refusal_of([&] { const FolderLock lock(folder, files); });
}

TEST(FolderLock, MakesTheFolderAndIsGoneWithoutATrace) {
  const fs::path folder = test::fresh_folder() / "a" / "b";
  {
    const FolderLock lock(folder, {"run.mcap"});
    EXPECT_EQ(lock.folder(), folder);
    EXPECT_THAT(lock_refusal(folder),
                AllOf(HasSubstr(folder.native()), HasSubstr(fmt::format("{}", ::getpid()))));
  }
  EXPECT_TRUE(fs::is_empty(folder));
  EXPECT_EQ(lock_refusal(folder), "");
}

TEST(FolderLock, WhoLooksOnKnowsWhetherSomebodyWrites) {
  const fs::path folder = test::fresh_folder();
  EXPECT_FALSE(is_written(folder));
  EXPECT_FALSE(is_written(folder / "none"));
  {
    const FolderLock lock(folder, {});
    EXPECT_TRUE(is_written(folder));
    EXPECT_TRUE(is_written(folder));
  }
  EXPECT_FALSE(is_written(folder));
  EXPECT_TRUE(fs::is_empty(folder));
}

// As long as nobody writes, a writer comes in, however many look.
TEST(FolderLock, ThoseWhoLookOnDoNotKeepAWriterOut) {
  const fs::path folder = test::fresh_folder();
  std::ofstream(folder / ".lock") << "1\n";
  std::atomic<bool> done{false};
  std::thread looks([&] {
    while (!done) (void)is_written(folder);
  });
  for (int i = 0; i < 50; ++i) {
    std::ofstream(folder / ".lock") << "1\n";
    EXPECT_EQ(lock_refusal(folder), "");
  }
  done = true;
  looks.join();
}

TEST(FolderLock, AFolderOfTwoNamesIsOne) {
  const fs::path folder = test::fresh_folder(), name = folder / "other";
  fs::create_directory(folder / "one");
  fs::create_directory_symlink(folder / "one", name);
  const FolderLock lock(folder / "one", {});
  EXPECT_THAT(lock_refusal(name), HasSubstr("another sightline"));
}

TEST(FolderLock, EndsWithItsProcessWhateverEndsThat) {
  const fs::path folder = test::fresh_folder();
  int locked[2];
  ASSERT_EQ(::pipe(locked), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const FolderLock lock(folder, {});
    if (::write(locked[1], "x", 1) == 1) ::pause();
    ::_exit(0);
  }
  char byte = 0;
  ASSERT_EQ(::read(locked[0], &byte, 1), 1);
  EXPECT_THAT(lock_refusal(folder), AllOf(HasSubstr(folder.native() + ": another sightline"),
                                          HasSubstr(fmt::format("(process {})", child))));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_TRUE(fs::exists(folder / ".lock")) << "left behind, and no longer locked";
  EXPECT_EQ(lock_refusal(folder), "");
  ::close(locked[0]);
  ::close(locked[1]);
}

TEST(FolderLock, OfManyAtOnceOneHasTheFolderAtATime) {
  const fs::path folder = test::fresh_folder();
  std::ofstream(folder / "count") << "x";
  constexpr int processes = 4, turns = 50;
  for (int i = 0; i < processes; ++i) {
    if (::fork() != 0) continue;
    int bad = 0;
    for (int turn = 0; turn < turns;) {
      try {
        const FolderLock lock(folder, {"count"});
        // Nobody else may have taken the name away.
        if (::rename((folder / "count").c_str(), (folder / "taken").c_str()) != 0) ++bad;
        if (::rename((folder / "taken").c_str(), (folder / "count").c_str()) != 0) ++bad;
        ++turn;
      } catch (const std::invalid_argument&) {
      }
    }
    ::_exit(bad == 0 ? 0 : 1);
  }
  for (int i = 0; i < processes; ++i) {
    int status = -1;
    ::wait(&status);
    EXPECT_EQ(status, 0);
  }
}

TEST(FolderLock, WhatIsNoFileIsRefusedBeforeItIsOpened) {
  const fs::path folder = test::fresh_folder();
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0666), 0);
  fs::create_directory(folder / "folder");
  fs::create_symlink("/dev/full", folder / "device");
  std::ofstream(folder / "file") << "x";
  fs::create_symlink("nowhere", folder / "dangling");
  EXPECT_THAT(lock_refusal(folder, {"pipe"}), HasSubstr("/pipe: a pipe, expected a regular file or none"));
  EXPECT_THAT(lock_refusal(folder, {"folder"}), HasSubstr("/folder: a folder, expected"));
  EXPECT_THAT(lock_refusal(folder, {"device"}), HasSubstr("/device: a device or a socket, expected"));
  EXPECT_EQ(lock_refusal(folder, {"file", "none", "dangling"}), "");
  ASSERT_EQ(::mkfifo((folder / ".lock").c_str(), 0666), 0);
  EXPECT_THAT(lock_refusal(folder), HasSubstr("/.lock: a pipe"));
}

// Of a file system that takes no files from anybody, root included.
TEST(FolderLock, AFolderThatCannotBeWrittenIsRefused) {
  EXPECT_THAT(lock_refusal("/proc/self"), HasSubstr("/proc/self: cannot be written ("));
  EXPECT_THAT(lock_refusal("/proc/self/none"), HasSubstr("/proc/self/none: "));
  const fs::path file = test::fresh_folder() / "file";
  std::ofstream(file) << "x";
  EXPECT_THAT(lock_refusal(file), HasSubstr(": Not a directory, expected a folder that can be made"));
}

}  // namespace
}  // namespace sightline
