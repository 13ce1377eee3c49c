/// Lock that gives one process exclusive write access to a folder.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string_view>

namespace sightline {

/// Keeps every other process from writing into a folder during the lifetime of this object. The
/// kernel holds the lock, so it ends with the process, also after a crash. The file `.lock`
/// contains the process id; an orderly end removes it.
class FolderLock {
 public:
  /// Creates the folder if necessary and checks that it can be written. Changes no other file in
  /// the folder.
  /// @param files  names of the files that will be written in the folder; each must be a regular
  ///   file or absent
  /// @throws std::invalid_argument naming the folder or the file and the fault; for a locked
  ///   folder, the process that holds the lock
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

/// True if a process writes into the folder now.
bool is_written(const std::filesystem::path& folder);

}  // namespace sightline
