/// A folder of this process alone, gone at its end.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

namespace sightline::test {

class Folder {
 public:
  explicit Folder(std::string_view name)
      : path_(std::filesystem::path(testing::TempDir()) /
              (std::string(name) + "_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A path in the process's own folder, the same whenever it is asked for.
inline std::filesystem::path place(std::string_view name) {
  static const Folder folder("sightline_test");
  return folder.path() / name;
}

/// An empty folder for the running test, within the process's own.
inline std::filesystem::path fresh_folder() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  auto path = place(info->test_suite_name()) / info->name();
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path;
}

}  // namespace sightline::test
