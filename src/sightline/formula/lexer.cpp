#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "sightline/formula.hpp"

namespace sightline {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xc0U) == 0x80; }

std::string place_in(std::string_view text, std::size_t offset) {
  std::size_t line = 1, column = 1;
  for (std::size_t i = 0; i < std::min(offset, text.size()); ++i) {
    if (text[i] == '\n') {
      ++line;
      column = 1;
    } else if (!is_continuation(text[i])) {
      ++column;
    }
  }
  return fmt::format("{}:{}", line, column);
}

}  // namespace

FormulaError::FormulaError(std::string_view text, std::size_t offset, std::string sentence,
                           std::string definition)
    : std::invalid_argument(fmt::format("{}: {}", place_in(text, offset), sentence)),
      offset_(offset),
      sentence_(std::move(sentence)),
      definition_(std::move(definition)) {}

std::string shown(const Token& token) {
  if (token.kind == TokenKind::end) return "the end";
  return fmt::format("\"{}\"", token.text.size() > 40 ? token.text.substr(0, 40) : token.text);
}

bool is_word(std::string_view name) {
  return !name.empty() && is_letter(name[0]) &&
         std::all_of(name.begin(), name.end(), [](char c) { return is_letter(c) || is_digit(c); });
}

Lexer::Lexer(std::string_view text) : text_(text) {
  if (text.size() > formula_size_max) {
    throw_invalid(
        0, fmt::format("the formula has {} bytes, expected at most {}", text.size(), formula_size_max));
  }
  next();
}

Token Lexer::take() {
  const Token taken = token_;
  next();
  return taken;
}

void Lexer::throw_invalid(std::size_t offset, std::string sentence) const {
  throw FormulaError(text_, offset, std::move(sentence));
}

void Lexer::next() {
  while (at_ < text_.size() &&
         (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r')) {
    ++at_;
  }
  token_ = {TokenKind::end, at_, {}, 0.0};
  if (at_ == text_.size()) return;
  const char c = text_[at_];
  if (is_digit(c) || (c == '.' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1]))) return number();
  if (is_letter(c)) return name();
  const std::size_t size = (c == '<' || c == '>') && text_.substr(at_ + 1, 1) == "=" ? 2 : 1;
  if (std::string_view("+-*/^(),<>").find(c) == std::string_view::npos) unknown_character();
  take_text(TokenKind::sign, size);
}

void Lexer::take_text(TokenKind kind, std::size_t size) {
  token_.kind = kind;
  token_.text = text_.substr(at_, size);
  at_ += size;
}

void Lexer::number() {
  const char* const begin = text_.data() + at_;
  const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), token_.value);
  take_text(TokenKind::number, static_cast<std::size_t>(end - begin));
  if (error != std::errc{}) {
    throw_invalid(token_.begin, fmt::format("{} is beyond what a number can be, expected a finite constant",
                                            shown(token_)));
  }
}

void Lexer::name() {
  std::size_t end = at_;
  const auto word = [&] {
    while (end < text_.size() && (is_letter(text_[end]) || is_digit(text_[end]))) ++end;
  };
  word();
  while (end + 1 < text_.size() && text_[end] == '.' && is_letter(text_[end + 1])) {
    ++end;
    word();
  }
  take_text(TokenKind::name, end - at_);
}

void Lexer::unknown_character() const {
  std::size_t size = 1;
  while (at_ + size < text_.size() && size < 4 && is_continuation(text_[at_ + size])) ++size;
  const std::string_view character = text_.substr(at_, size);
  const bool equals = character == "=";
  throw_invalid(at_, fmt::format("\"{}\" has no meaning here, expected {}", character,
                                 equals ? "a comparison, one of < <= > >="
                                        : "numbers, names and the signs + - * / ^ ( ) , < <= > >="));
}

}  // namespace sightline
