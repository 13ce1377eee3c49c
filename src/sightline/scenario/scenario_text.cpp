#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "sightline/base/character.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/file_kind.hpp"

namespace sightline {
namespace {

/// Index of the last character of the string that begins at `i`, of one line or of several.
std::size_t string_end(std::string_view text, std::size_t i, std::size_t& line) {
  const char quote = text[i];
  const bool multi_line = text.substr(i, 3) == std::string(3, quote);
  for (i += multi_line ? 3 : 1; i < text.size(); ++i) {
    if (text[i] == '\\' && quote == '"') {
      ++i;
      if (i < text.size() && text[i] == '\n') ++line;
    } else if (text[i] == '\n') {
      if (!multi_line) return i - 1;
      ++line;
    } else if (text[i] == quote) {
      if (!multi_line) return i;
      if (text.substr(i, 3) != std::string(3, quote)) continue;
      i += 2;
      // Up to two more quotes belong to the content.
      for (int more = 0; more < 2 && i + 1 < text.size() && text[i + 1] == quote; ++more) ++i;
      return i;
    }
  }
  return text.size();
}

void check_keys(std::string_view text, std::string_view file) {
  std::size_t line = 1;
  int parts = 1;
  for (std::size_t i = 0; i < text.size(); ++i) {
    switch (text[i]) {
      case '\n':
        ++line;
        parts = 1;
        break;
      case '#':
        i = std::min(text.find('\n', i), text.size()) - 1;
        break;
      case '"':
      case '\'':
        i = string_end(text, i, line);
        break;
      case '.':
        if (++parts > key_parts_max) {
          throw ScenarioError(file, line,
                              fmt::format("the key has too many parts, expected at most {}", key_parts_max));
        }
        break;
      case '=':
      case ',':
      case '[':
      case ']':
      case '{':
      case '}':
        parts = 1;
        break;
      default:
        break;
    }
  }
}

struct Descriptor {
  int number;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

std::string_view kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

}  // namespace

ScenarioError::ScenarioError(std::string_view file, const std::string& place, std::string_view sentence)
    : std::runtime_error(fmt::format("{}{}: {}", one_line(file), place, one_line(sentence))),
      file_(file),
      sentence_(one_line(sentence)) {}

ScenarioError::ScenarioError(std::string_view file, std::size_t line, std::string_view sentence)
    : ScenarioError(file, line > 0 ? fmt::format(":{}", line) : std::string(), sentence) {}

ScenarioError::ScenarioError(std::string_view file, std::size_t line, std::size_t column,
                             std::string_view sentence)
    : ScenarioError(file, fmt::format(":{}:{}", line, column), sentence) {}

std::string read_text(const std::filesystem::path& path) {
  const std::string& file = path.native();
  const auto refuse = [&](std::string_view sentence) { return ScenarioError(file, 1, sentence); };
  const auto fault = [&] {
    return refuse(fmt::format("cannot be read ({}), expected a scenario file", std::strerror(errno)));
  };

  const auto too_large = [&] {
    return refuse(fmt::format("too large, expected at most {} bytes", scenario_size_max));
  };

  // Checks the kind of the file first: opening a device may have side effects.
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) throw fault();
  if (!S_ISREG(status.st_mode)) {
    const FileKind folder = kind_at(path);
    throw refuse(folder.what.empty()
                     ? fmt::format("this is {}, expected a scenario file", kind_of(status.st_mode))
                     : kind_sentence(folder));
  }
  const Descriptor in{::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)};
  if (in.number < 0) throw fault();

  std::string text;
  char block[1 << 16];
  for (;;) {
    const ssize_t n = ::read(in.number, block, sizeof block);
    if (n == 0) return text;
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw fault();
    const bool first = text.empty();
    text.append(block, static_cast<std::size_t>(n));
    if (!first && text.size() <= scenario_size_max) continue;
    const FileKind kind = kind_at(path);
    const bool large = std::max<std::uintmax_t>(text.size(), static_cast<std::uintmax_t>(status.st_size)) >
                       scenario_size_max;
    // Text formats are checked only if the text is not TOML.
    if (!kind.what.empty() && (large || !kind.is_text || !kind.packed_by.empty()))
      throw refuse(kind_sentence(kind));
    if (large) throw too_large();
  }
}

void check_text(std::string_view text, std::string_view file) {
  if (text.empty()) throw ScenarioError(file, 1, "the file is empty, expected at least one [agent.NAME]");
  std::size_t line = 1;
  for (std::string_view rest = text; !rest.empty();) {
    const auto [code, size] = first_character(rest);
    if (size == 0) {
      throw ScenarioError(
          file, line,
          fmt::format("the byte 0x{:02x} is not UTF-8, expected text", static_cast<unsigned char>(rest[0])));
    }
    const bool ordinary = code == '\t' || code == '\n' || code == '\r';
    if ((code < 0x20 && !ordinary) || code == 0x7f) {
      throw ScenarioError(
          file, line,
          fmt::format("the control character 0x{:02x}, expected text", static_cast<unsigned>(code)));
    }
    if (code == '\n') ++line;
    rest.remove_prefix(size);
  }
  check_keys(text, file);
}

}  // namespace sightline
