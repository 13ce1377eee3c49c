/// Files that appear only when complete: written under a temporary name, then renamed.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace sightline {

/// Temporary name of a file until it is renamed: its name and ".part".
std::filesystem::path beside(const std::filesystem::path& file);

/// Writes text to disk by write(2), under the temporary name until settle(). error() keeps the
/// first failure, and later writes do nothing. No disk failure throws.
class TextFile {
 public:
  explicit TextFile(std::filesystem::path path);
  ~TextFile() { close(); }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;

  void write(std::string_view text);
  /// Renames the file to its final name, replacing an existing file; later writes go to the same
  /// file.
  void settle();
  void close();
  const std::string& error() const { return error_; }  ///< The first failure, a sentence; empty if none.

 private:
  void fail(std::string_view what);

  std::filesystem::path path_, now_;  // now_: present name
  std::string error_;
  int file_;
};

/// Writes a file completely, or leaves the existing file unchanged.
/// @throws std::runtime_error naming the file and the reason
void write_text(const std::filesystem::path& file, std::string_view text);

}  // namespace sightline
