/// Tokens of a formula's text, and the error that points at one of them.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace sightline {

/// Longest formula accepted [bytes].
inline constexpr std::size_t formula_size_max = 100'000;

/// Error in the text of a formula. what() is "line:column: sentence"; both count from 1, columns in
/// characters.
class FormulaError : public std::invalid_argument {
 public:
  FormulaError(std::string_view text, std::size_t offset, std::string sentence, std::string definition = {});

  /// Offset of the token in the text [bytes].
  std::size_t offset() const { return offset_; }
  const std::string& sentence() const { return sentence_; }
  /// The name with the rejected definition; empty for the formula itself.
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

/// A token as text for a message.
std::string shown(const Token& token);

/// Whether the name is a letter followed by letters, digits and _.
bool is_word(std::string_view name);

/// Iterates over the tokens of a text. It is a view: the text must outlive it. A copy continues
/// from the same position.
class Lexer {
 public:
  /// @throws FormulaError for a text that is too long; every function here throws it for an invalid
  ///   token
  explicit Lexer(std::string_view text);

  /// The current token.
  const Token& token() const { return token_; }
  /// Returns the current token and advances to the next one.
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
