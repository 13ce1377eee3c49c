#include "sightline/campaign/database.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/support/folder.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using Statement = Database::Statement;

TEST(Database, WhatIsBoundIsReadBack) {
  const auto file = test::fresh_folder() / "a.sqlite";
  {
    Database database(file, Database::Open::anew);
    database.execute("CREATE TABLE t(i, x, s)");
    Statement insert(database, "INSERT INTO t VALUES(?, ?, ?)");
    for (const double x : {1.5, -1e300, 5e-324, std::nan("")}) {
      insert.reset();
      insert.bind(0, std::int64_t{-7});
      insert.bind(1, x);
      insert.bind(2, std::string_view("it's \"µ\""));
      EXPECT_FALSE(insert.step());
    }
  }
  Database database(file, Database::Open::as_it_is);
  Statement request(database, "SELECT i, x, s FROM t");
  for (const double x : {1.5, -1e300, 5e-324}) {
    ASSERT_TRUE(request.step());
    EXPECT_EQ(request.integer(0), -7);
    EXPECT_EQ(request.number(1), x);
    EXPECT_EQ(request.text(2), "it's \"µ\"");
  }
  ASSERT_TRUE(request.step());
  EXPECT_FALSE(request.number(1).has_value()) << "not a number is null";
  EXPECT_FALSE(request.step());
}

TEST(Database, AnewRemovesWhatWasThere) {
  const auto file = test::fresh_folder() / "a.sqlite";
  std::ofstream(file) << "no database";
  Database database(file, Database::Open::anew);
  EXPECT_NO_THROW(database.execute("CREATE TABLE t(i)"));
}

TEST(Database, RefusalsNameTheFile) {
  const auto folder = test::fresh_folder();
  const auto said = [](auto&& call) { return refusal_of<std::runtime_error>(call); };
  const auto missing = folder / "none" / "a.sqlite";
  EXPECT_THAT(said([&] { Database(missing, Database::Open::anew); }),
              testing::StartsWith(missing.native() + ": "));
  EXPECT_THAT(said([&] { Database(missing, Database::Open::as_it_is); }),
              testing::StartsWith(missing.native() + ": "));
  Database database(folder / "a.sqlite", Database::Open::anew);
  EXPECT_THAT(said([&] { database.execute("CREATE TABEL t(i)"); }), testing::HasSubstr("a.sqlite: "));
  EXPECT_THAT(said([&] { Statement(database, "SELECT * FROM t"); }), testing::HasSubstr("no such table"));
}

TEST(Database, AnyValueIsReadBackOfItsKind) {
  Database database(test::fresh_folder() / "a.sqlite", Database::Open::anew);
  database.execute("CREATE TABLE t(x)");
  const std::vector<Database::Value> values = {{}, std::int64_t{3}, 3.0, std::string("3")};
  {
    Statement insert(database, "INSERT INTO t VALUES(?)");
    for (const Database::Value& value : values) {
      insert.reset();
      insert.bind(0, value);
      insert.step();
    }
  }
  Statement request(database, "SELECT x FROM t");
  for (const Database::Value& value : values) {
    ASSERT_TRUE(request.step());
    EXPECT_EQ(request.value(0), value);
  }
}

TEST(Database, ANameIsQuotedWhateverItHolds) {
  Database database(test::fresh_folder() / "a.sqlite", Database::Open::anew);
  const std::string name = "agent.\"a\".p[0]; DROP";
  database.execute("CREATE TABLE t(" + sql_name(name) + ")");
  Statement request(database, "SELECT name FROM pragma_table_info('t')");
  ASSERT_TRUE(request.step());
  EXPECT_EQ(request.text(0), name);
}

}  // namespace
}  // namespace sightline
