#include <gtest/gtest.h>

#include "sightline/supervisor.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

struct Piece {
  double from, to, u;
  bool operator==(const Piece&) const = default;
};

std::vector<Piece> pieces(const InputHistory& history, double from, double to) {
  std::vector<Piece> all;
  history.visit(from, to, [&](double a, double b, std::span<const double> u) {
    all.push_back({a, b, u[0]});
  });
  return all;
}

void record(InputHistory& history, double t, double u) { history.record(t, {&u, 1}); }

TEST(InputHistory, BeforeTheFirstRecordTheInitialInputIsInForce) {
  const double initial = 7.0;
  InputHistory history(4, {&initial, 1});
  EXPECT_EQ(pieces(history, -1.0, 2.0), (std::vector<Piece>{{-1.0, 2.0, 7.0}}));
  record(history, 1.0, 8.0);
  EXPECT_EQ(pieces(history, 0.0, 2.0), (std::vector<Piece>{{0.0, 1.0, 7.0}, {1.0, 2.0, 8.0}}));
  EXPECT_EQ(pieces(history, 2.0, 2.0), std::vector<Piece>{});
}

TEST(InputHistory, PiecesCoverTheTimeWithoutAGapEachUnderTheInputOfItsTime) {
  const double initial = -1.0;
  InputHistory history(200, {&initial, 1});
  for (int k = 0; k < 150; ++k) record(history, 0.01 * k, k);
  RandomStream chance(1, StreamId::gust, 0);
  for (int trial = 0; trial < 2000; ++trial) {
    const double from = 2.0 * chance.uniform() - 0.2, to = from + chance.uniform();
    double at = from;
    for (const Piece& piece : pieces(history, from, to)) {
      ASSERT_EQ(piece.from, at);
      ASSERT_GT(piece.to, piece.from);
      const double middle = 0.5 * (piece.from + piece.to);
      ASSERT_EQ(piece.u, middle < 0 ? -1.0 : std::min(149.0, std::floor(middle / 0.01 + 1e-9)));
      at = piece.to;
    }
    ASSERT_EQ(at, to);
  }
}

TEST(InputHistory, WhatIsForgottenCountsAsTheOldestThatIsNot) {
  const double initial = 0.0;
  InputHistory history(3, {&initial, 1});
  for (int k = 1; k <= 9; ++k) record(history, k, k);
  EXPECT_EQ(pieces(history, 2.0, 10.0),
            (std::vector<Piece>{{2.0, 8.0, 7.0}, {8.0, 9.0, 8.0}, {9.0, 10.0, 9.0}}));
}

}  // namespace
}  // namespace sightline
