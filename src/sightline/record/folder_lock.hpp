/// A folder for one writer.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string_view>

namespace sightline {

/// Keeps every other process from writing into a folder, as long as this lives. The kernel holds the lock, so it
/// ends with the process, whatever ends that; the file `.lock`, which says who it is, is gone after an orderly end.
class FolderLock {
 public:
  /// Makes the folder if need be, and sees that it can be written. Nothing in it is touched.
  /// @param files  of the folder, which will be written: none may be anything but a regular file
  /// @throws std::invalid_argument naming the folder or the file and what is wrong with it; of a folder that is
  ///                               taken the process that has it
  FolderLock(std::filesystem::path folder, std::initializer_list<std::string_view> files);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  const std::filesystem::path& folder() const { return folder_; }

 private:
  void lock();

  std::filesystem::path folder_, file_;
  int lock_ = -1;
};

/// Whether some process writes into the folder now.
bool is_written(const std::filesystem::path& folder);

}  // namespace sightline
