#include "sightline/scenario/string_place.hpp"

#include <string>

namespace sightline {
namespace {

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xc0U) == 0x80; }

/// Reads character by character and tracks the place.
class Cursor {
 public:
  Cursor(std::string_view text, TextPlace place) : text_(text) {
    while (at_ < text.size() && place_ != place) step();
  }

  bool at_end() const { return at_ >= text_.size(); }
  bool sees(std::string_view what) const { return text_.substr(at_, what.size()) == what; }
  char character() const { return text_[at_]; }
  TextPlace place() const { return place_; }

  /// The bytes of the character; advances to the next.
  std::string_view step() {
    const std::size_t begin = at_;
    do ++at_;
    while (at_ < text_.size() && is_continuation(text_[at_]));
    if (text_[begin] == '\n') {
      place_ = {place_.line + 1, 1};
    } else {
      ++place_.column;
    }
    return text_.substr(begin, at_ - begin);
  }
  void skip(std::size_t characters) {
    for (; characters > 0 && !at_end(); --characters) step();
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  TextPlace place_;
};

/// Bytes that an escape represents; the cursor is after its backslash.
std::size_t escaped_bytes(Cursor& cursor) {
  const char kind = cursor.character();
  cursor.step();
  if (kind != 'u' && kind != 'U') return 1;
  unsigned long code = 0;
  for (int digits = kind == 'u' ? 4 : 8; digits > 0 && !cursor.at_end(); --digits) {
    const std::string digit(cursor.step());
    code = code * 16 + std::stoul("0" + digit, nullptr, 16);
  }
  return code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

}  // namespace

TextPlace place_in_string(std::string_view document, TextPlace quote, std::string_view content,
                          std::size_t offset) {
  Cursor cursor(document, quote);
  if (cursor.at_end() || (cursor.character() != '"' && cursor.character() != '\'')) return quote;
  const char mark = cursor.character();
  const std::string three(3, mark);
  const bool lines = cursor.sees(three);
  cursor.skip(lines ? 3 : 1);
  if (lines && cursor.sees("\r\n")) cursor.step();
  if (lines && cursor.sees("\n")) cursor.step();  // the first line break is not part of the content
  for (std::size_t bytes = 0; !cursor.at_end();) {
    const TextPlace here = cursor.place();
    std::size_t size = 1;
    if (mark == '"' && cursor.character() == '\\') {
      cursor.step();
      if (cursor.at_end()) break;
      if (is_blank(cursor.character())) {  // a line continuation
        while (!cursor.at_end() && is_blank(cursor.character())) cursor.step();
        continue;
      }
      size = escaped_bytes(cursor);
    } else if (lines && cursor.sees("\r\n") && content.substr(bytes, 1) == "\n") {
      cursor.skip(2);
    } else {
      if (bytes >= content.size()) return here;  // the end of the string
      size = cursor.step().size();
    }
    if (offset < bytes + size) return here;
    bytes += size;
    if (bytes > content.size()) break;
  }
  return quote;
}

}  // namespace sightline
