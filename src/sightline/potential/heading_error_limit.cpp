#include <cmath>
#include <numbers>

#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/potentials.hpp"

namespace sightline {
namespace {

constexpr double cos_limit = -0.5, sin_limit = 0.86602540378443864676;  // of 120 degrees
constexpr double cos_tie = -0.99619469809174553230;                     // of 175 degrees

/// Angle between two headings.
struct Angle {
  double cosine, sine, length2;  // cosine and sine times the product of their lengths, and the square of that
                                 // product

  Angle(const Vec2<double>& from, const Vec2<double>& to)
      : cosine(from.x * to.x + from.y * to.y),
        sine(from.x * to.y - from.y * to.x),
        length2((from.x * from.x + from.y * from.y) * (to.x * to.x + to.y * to.y)) {}

  /// Whether the angle exceeds the one with this cosine, which must be < 0.
  bool exceeds(double cos_of) const { return cosine < 0 && cosine * cosine > cos_of * cos_of * length2; }
  bool turns_left() const { return sine >= 0 || exceeds(cos_tie); }
  /// Rotation that takes `to` to 120 degrees from `from`.
  Vec2<double> excess() const {
    const double per_length = 1.0 / std::sqrt(length2);
    return rotate<double>({per_length * cosine, -per_length * sine},
                          {cos_limit, turns_left() ? sin_limit : -sin_limit});
  }
};

/// Fast test, one comparison per stage: whether the headings (x, y) of n stages stay unchanged.
/// True if no stage has a heading, or if each differs by less than a right angle from the previous
/// one, the first from `own`.
bool stays_unchanged(const Vec2<double>& own, const double* x, const double* y, int n, std::ptrdiff_t stage) {
  const double* const x_end = x + n * stage;
  if (*x == 0 && *y == 0) {
    bool free = true;
    for (; x != x_end; x += stage, y += stage) free &= (*x == 0) & (*y == 0);
    return free;
  }
  bool slowly = true;
  double before_x = own.x, before_y = own.y;
  for (; x != x_end; x += stage, y += stage) {
    slowly &= before_x * *x + before_y * *y > 0;
    before_x = *x, before_y = *y;
  }
  return slowly;
}

}  // namespace

double heading_error(const Vec2<double>& from, const Vec2<double>& to) noexcept {
  const Angle angle(from, to);
  const double e = atan2(angle.sine, angle.cosine);
  return e < 0 && angle.turns_left() ? e + 2 * std::numbers::pi : e;
}

HeadingErrorLimit::HeadingErrorLimit(const Model& model, std::span<const double> Q,
                                     std::span<const double> Q_f)
    : at_{-1, -1} {
  const StateRoles roles = roles_of(model);
  for (const int state : roles.direction) {
    if (state < 0) return;
    const auto i = static_cast<std::size_t>(state);
    if (Q[i] > 0 || (!Q_f.empty() && Q_f[i] > 0)) at_ = {roles.direction[0], roles.direction[1]};
  }
}

bool HeadingErrorLimit::exceeded(const double* x, const double* x_ref, std::ptrdiff_t entry) const noexcept {
  return applies() && Angle(heading(x, entry), heading(x_ref, entry)).exceeds(cos_limit);
}

bool HeadingErrorLimit::operator()(const double* x, std::ptrdiff_t x_entry, double* x_ref, int n,
                                   std::ptrdiff_t stage, std::ptrdiff_t entry) const noexcept {
  if (!applies()) return false;
  const std::ptrdiff_t x_at = at_[0] * entry, y_at = at_[1] * entry;
  if (stays_unchanged(heading(x, x_entry), x_ref + x_at, x_ref + y_at, n, stage)) return false;
  Vec2<double> seen = heading(x, x_entry), before = seen, turn{};
  bool turns = false, turned = false;
  for (int k = 0; k < n; ++k, x_ref += stage) {
    const Vec2<double> now = {x_ref[x_at], x_ref[y_at]};
    if (now.x == 0 && now.y == 0) continue;  // the reference has no heading
    if (Angle(before, now).exceeds(cos_limit)) {
      const Angle from_seen(seen, now);
      turns = from_seen.exceeds(cos_limit);
      if (turns) turn = from_seen.excess();
    }
    before = seen = now;
    if (!turns) continue;
    seen = rotate(turn, now);
    x_ref[x_at] = seen.x, x_ref[y_at] = seen.y;
    turned = true;
  }
  return turned;
}

}  // namespace sightline
