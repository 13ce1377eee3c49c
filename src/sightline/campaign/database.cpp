#include "sightline/campaign/database.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cmath>
#include <stdexcept>
#include <system_error>

namespace sightline {

Database::Database(const std::filesystem::path& file, Open how) : file_(file.native()) {
  if (how == Open::anew) {
    for (const char* rest : {"", "-journal"}) {
      std::error_code ignored;
      std::filesystem::remove(file_ + rest, ignored);
    }
  }
  constexpr int patience = 600'000;  // [ms]
  const int flags =
      SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | (how == Open::anew ? SQLITE_OPEN_CREATE : 0);
  if (sqlite3_open_v2(file_.c_str(), &handle_, flags, nullptr) != SQLITE_OK) {
    const std::string why = sqlite3_errmsg(handle_);
    sqlite3_close(handle_);
    throw std::runtime_error(fmt::format("{}: {}", file_, why));
  }
  sqlite3_busy_timeout(handle_, patience);
}

Database::~Database() { sqlite3_close(handle_); }

void Database::fail() const {
  throw std::runtime_error(fmt::format("{}: {}", file_, sqlite3_errmsg(handle_)));
}

void Database::execute(const std::string& sql) {
  if (sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

Database::Statement::Statement(Database& database, const std::string& sql) : database_(database) {
  check(sqlite3_prepare_v2(database.handle_, sql.c_str(), -1, &statement_, nullptr));
}

Database::Statement::~Statement() { sqlite3_finalize(statement_); }

void Database::Statement::check(int code) const {
  if (code != SQLITE_OK) database_.fail();
}

void Database::Statement::bind(int parameter, std::int64_t value) {
  check(sqlite3_bind_int64(statement_, parameter + 1, value));
}

void Database::Statement::bind(int parameter, double value) {
  check(std::isnan(value) ? sqlite3_bind_null(statement_, parameter + 1)
                          : sqlite3_bind_double(statement_, parameter + 1, value));
}

void Database::Statement::bind(int parameter, std::string_view value) {
  check(sqlite3_bind_text(statement_, parameter + 1, value.data(), static_cast<int>(value.size()),
                          SQLITE_TRANSIENT));
}

void Database::Statement::bind(int parameter, const Value& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return bind(parameter, *whole);
  if (const auto* real = std::get_if<double>(&value)) return bind(parameter, *real);
  if (const auto* words = std::get_if<std::string>(&value)) return bind(parameter, std::string_view(*words));
  check(sqlite3_bind_null(statement_, parameter + 1));
}

bool Database::Statement::step() {
  const int code = sqlite3_step(statement_);
  if (code != SQLITE_ROW && code != SQLITE_DONE) database_.fail();
  return code == SQLITE_ROW;
}

void Database::Statement::reset() { check(sqlite3_reset(statement_)); }

std::int64_t Database::Statement::integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}

std::optional<double> Database::Statement::number(int column) const {
  if (sqlite3_column_type(statement_, column) == SQLITE_NULL) return {};
  return sqlite3_column_double(statement_, column);
}

Database::Value Database::Statement::value(int column) const {
  switch (sqlite3_column_type(statement_, column)) {
    case SQLITE_NULL:
      return {};
    case SQLITE_INTEGER:
      return integer(column);
    case SQLITE_FLOAT:
      return *number(column);
    default:
      return text(column);
  }
}

std::string Database::Statement::text(int column) const {
  const auto* bytes = sqlite3_column_text(statement_, column);
  if (bytes == nullptr) return {};
  return {reinterpret_cast<const char*>(bytes),
          static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

std::string sql_name(std::string_view name) {
  std::string text = "\"";
  for (const char c : name) text.append(c == '"' ? 2 : 1, c);
  return text + '"';
}

}  // namespace sightline
