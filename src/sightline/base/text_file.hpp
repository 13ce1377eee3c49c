/// Files that appear whole: they are written beside their place and take it when they are worth it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace sightline {

/// Where a file is written until it takes its place: its name and ".part".
std::filesystem::path beside(const std::filesystem::path& file);

/// Text that goes to disk by write(2), beside its place until settle(). The first failure is kept, and nothing is
/// written after it; nothing throws for the disk's sake.
class TextFile {
 public:
  explicit TextFile(std::filesystem::path path);
  ~TextFile() { close(); }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;

  void write(std::string_view text);
  /// Takes its place, and that of what stood there; what is written later is there at once.
  void settle();
  void close();
  const std::string& error() const { return error_; }  ///< The first failure, a sentence; empty if none.

 private:
  void fail(std::string_view what);

  std::filesystem::path path_, now_;  // now_: what it is called so far
  std::string error_;
  int file_;
};

/// Writes a file whole, or leaves what stood there.
/// @throws std::runtime_error naming the file, and why it cannot be written
void write_text(const std::filesystem::path& file, std::string_view text);

}  // namespace sightline
