/// A SQLite file and its statements; errors are exceptions with a sentence.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

struct sqlite3;
struct sqlite3_stmt;

namespace sightline {

/// Every call throws std::runtime_error, `FILE: what went wrong`, if SQLite fails.
class Database {
 public:
  enum class Open { anew, as_it_is };
  /// `anew` removes an existing file; `as_it_is` rolls back the unfinished transaction of a killed
  /// writer. Waits for a locked file.
  Database(const std::filesystem::path& file, Open how);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Value of a field; monostate: null.
  using Value = std::variant<std::monostate, std::int64_t, double, std::string>;

  /// One prepared statement; parameters and columns count from 0.
  class Statement {
   public:
    Statement(Database& database, const std::string& sql);
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    void bind(int parameter, std::int64_t value);
    void bind(int parameter, double value);  ///< NaN: null
    void bind(int parameter, std::string_view value);
    void bind(int parameter, const Value& value);
    /// Advances to the next row, if there is one.
    bool step();
    /// Returns to before the first row; parameters keep their values.
    void reset();

    std::int64_t integer(int column) const;
    std::optional<double> number(int column) const;  ///< none: null
    std::string text(int column) const;
    Value value(int column) const;

   private:
    void check(int code) const;

    Database& database_;
    sqlite3_stmt* statement_ = nullptr;
  };

  void execute(const std::string& sql);

 private:
  [[noreturn]] void fail() const;

  std::string file_;
  sqlite3* handle_ = nullptr;
};

/// A name as a quoted SQL identifier.
std::string sql_name(std::string_view name);

}  // namespace sightline
