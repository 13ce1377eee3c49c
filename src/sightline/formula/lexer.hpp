/// A formula's text as tokens, and the refusal that points at one of them.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace sightline {

/// Longest formula that is read [bytes].
inline constexpr std::size_t formula_size_max = 100'000;

/// A text that is no formula; what() is "line:column: sentence", both counted from 1, columns in characters.
class FormulaError : public std::invalid_argument {
 public:
  FormulaError(std::string_view text, std::size_t offset, std::string sentence, std::string definition = {});

  /// Where the token begins [bytes into the text].
  std::size_t offset() const { return offset_; }
  const std::string& sentence() const { return sentence_; }
  /// The name whose definition was refused; empty for the formula itself.
  const std::string& definition() const { return definition_; }

 private:
  std::size_t offset_;
  std::string sentence_, definition_;
};

enum class TokenKind { number, name, sign, end };

struct Token {
  TokenKind kind{};
  std::size_t begin = 0;
  std::string_view text;
  double value = 0.0;

  bool is(std::string_view sign) const { return kind == TokenKind::sign && text == sign; }
};

/// A token as it stands in a message.
std::string shown(const Token& token);

/// Whether this is a letter, then letters, digits and _.
bool is_word(std::string_view name);

/// The tokens of a text, one after the other. A view: the text outlives it; a copy goes on from the same place.
class Lexer {
 public:
  /// @throws FormulaError for a text that is too long, as every function here does for what is no token
  explicit Lexer(std::string_view text);

  /// The token that comes next.
  const Token& token() const { return token_; }
  /// The token, and on to the one after it.
  Token take();

  /// @throws FormulaError
  [[noreturn]] void throw_invalid(std::size_t offset, std::string sentence) const;

 private:
  void next();
  void take_text(TokenKind kind, std::size_t size);
  void number();
  void name();
  [[noreturn]] void unknown_character() const;

  std::string_view text_;
  std::size_t at_ = 0;
  Token token_;
};

}  // namespace sightline
