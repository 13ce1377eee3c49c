#include "sightline/potential/finite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"

namespace sightline {
namespace {

constexpr int third_input = 2 * sight_size,
              inputs = third_input + 3 + 1;  // both sights, the third body, the time
constexpr int batch = 512;

using Random = std::mt19937_64;
using InputNumbers = std::array<double, inputs>;

/// Value, gradient and Hessian; each distinct entry once.
struct Recorded {
  Program program;
  bool sees_time;
};

Recorded record(const Potential& potential) {
  Graph graph;
  const std::vector<Symbol> z = variables(graph, 0, inputs);
  Sight<Symbol> observer = sight_from<Symbol>(z.data());
  observer.third = {z[third_input], z[third_input + 1], z[third_input + 2]};
  const Term l = potential(observer, sight_from<Symbol>(z.data() + sight_size), z.back()).in(graph);
  std::vector<Term> of;
  for (int i = 0; i < inputs; ++i) of.push_back(graph.input(i));
  const Derivatives d = derive(graph, l, of);
  std::vector<Term> outputs = {l};
  for (const std::vector<Term>* list : {&d.first, &d.second}) {
    for (const Term t : *list) {
      if (!graph.is_zero(t)) outputs.push_back({t.node, false});
    }
  }
  const auto by_node = [](Term a, Term b) { return a.node < b.node; };
  std::sort(outputs.begin() + 1, outputs.end(), by_node);
  outputs.erase(std::unique(outputs.begin() + 1, outputs.end()), outputs.end());
  return {Program(graph, outputs, inputs), !graph.is_zero(d.first.back())};
}

Sight<double> draw_sight(Random& random, double reach, bool on_axes) {
  const auto place = [&] {
    if (on_axes) return static_cast<double>(random() % 3) - 1.0;
    return std::uniform_real_distribution<double>(-reach, reach)(random);
  };
  const double quarter = static_cast<double>(random() % 4) * half_pi;
  const double psi = on_axes ? quarter : std::uniform_real_distribution<double>(0, 4 * half_pi)(random);
  const Vec2<double> d = {std::round(std::cos(psi) * 1e9) / 1e9, std::round(std::sin(psi) * 1e9) / 1e9};
  return {{{place(), place(), place()}, d}, {place() / 10, place() / 10, place() / 10}};
}

/// Separate generators, so that one kind of draw does not change the others.
struct Draws {
  Random places{1}, leans{2}, thirds{3};
};

InputNumbers draw(Draws& draws, const FiniteSearch& search) {
  auto& [random, leans, thirds] = draws;
  constexpr std::array reaches = {0.3, 3.0, 30.0};
  const bool on_axes = random() % 4 == 0;
  const double reach = reaches[random() % reaches.size()];
  const Vec3<double> centre = random() % 2 == 0 ? Vec3<double>{} : search.centre;
  InputNumbers z;
  for (const std::size_t first : {std::size_t{0}, std::size_t{sight_size}}) {
    Sight<double> sight = draw_sight(random, reach, on_axes);
    sight.p = sight.p + centre;
    std::uniform_real_distribution<double> lean(-1.0, 1.0);
    sight.lean = {lean(leans), lean(leans)};
    write_sight(sight, std::span(z).subspan(first));
  }
  z.back() = std::uniform_real_distribution<double>(search.from, search.until)(random);
  // At one of the two bodies, between them, or anywhere.
  const double part = clamp(std::uniform_real_distribution<double>(-0.5, 1.5)(thirds), 0.0, 1.0);
  const bool is_between = thirds() % 2 == 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = z[at(axis)], b = z[at(sight_size + axis)];
    const double anywhere = std::uniform_real_distribution<double>(-reach, reach)(thirds);
    z[at(third_input + axis)] = is_between ? a + part * (b - a) : anywhere;
  }
  return z;
}

/// Evaluates a program on batches of inputs and finds a result that is not finite.
class Seeker {
 public:
  explicit Seeker(const Program& program)
      : program_(program), in_(inputs, batch), out_(program.outputs(), batch), evaluation_(program, batch) {
    for (int i = 0; i < inputs; ++i) evaluation_.input(i, in_[i]);
    for (int i = 0; i < program.outputs(); ++i) evaluation_.output(i, out_[i]);
  }

  /// The first input from `next` with a result that is not finite; `count` is rounded up to whole
  /// batches.
  template <class Next>
  std::optional<InputNumbers> first(std::int64_t count, Next&& next) {
    for (std::int64_t done = 0; done < count; done += batch) {
      std::array<InputNumbers, batch> drawn;
      for (int k = 0; k < batch; ++k) {
        InputNumbers& z = drawn[static_cast<std::size_t>(k)];
        z = next(done + k);
        for (int i = 0; i < inputs; ++i) in_[i][k] = z[static_cast<std::size_t>(i)];
      }
      evaluation_.run();
      for (int k = 0; k < batch; ++k) {
        for (int i = 0; i < program_.outputs(); ++i) {
          if (!std::isfinite(out_[i][k])) return drawn[static_cast<std::size_t>(k)];
        }
      }
    }
    return {};
  }
  bool finite(const InputNumbers& z) const {
    const std::vector<double> out = evaluate(program_, z);
    return std::all_of(out.begin(), out.end(), [](double v) { return std::isfinite(v); });
  }

 private:
  const Program& program_;
  Rows in_, out_;
  Evaluation evaluation_;
};

/// Time until which the result is finite, for an input that is not finite at its own time; none if
/// it is not finite at `from` either.
std::optional<double> end_of(const Seeker& seeker, InputNumbers z, double from) {
  double bad = z.back();
  z.back() = from;
  if (!seeker.finite(z)) return {};
  double good = from;
  for (int n = 0; n < 60; ++n) {
    z.back() = 0.5 * (good + bad);
    (seeker.finite(z) ? good : bad) = z.back();
  }
  return good;
}

}  // namespace

std::optional<Spot> not_finite_at(const Potential& potential, const FiniteSearch& search) {
  constexpr double periods_max = 200'000;
  const Recorded recorded = record(potential);
  Seeker seeker(recorded.program);
  Draws draws;
  auto found = seeker.first(search.samples, [&](std::int64_t) { return draw(draws, search); });
  if (!found && recorded.sees_time && search.period > 0) {
    const double length = search.until - search.from;
    const double step = search.period * std::max(1.0, std::ceil(length / search.period / periods_max));
    const InputNumbers place = draw(draws, search);
    found = seeker.first(static_cast<std::int64_t>(length / step) + 1, [&](std::int64_t n) {
      InputNumbers z = place;
      z.back() = std::min(search.until, search.from + static_cast<double>(n) * step);
      return z;
    });
  }
  if (!found) return {};
  const InputNumbers& z = *found;
  Spot spot{sight_from<double>(z.data()), sight_from<double>(z.data() + sight_size), z.back(), {}, {}};
  if (potential.sees_third())
    spot.third = Vec3<double>{z[third_input], z[third_input + 1], z[third_input + 2]};
  if (recorded.sees_time) spot.ends = end_of(seeker, z, search.from);
  return spot;
}

std::string to_string(const Spot& spot) {
  const auto describe = [](const Sight<double>& s) {
    return fmt::format("at ({:.6g}, {:.6g}, {:.6g}) m heading ({:.6g}, {:.6g})", s.p.x, s.p.y, s.p.z, s.d.x,
                       s.d.y);
  };
  const std::string ends =
      spot.ends ? fmt::format("; there it is finite until t = {:.6g} s", *spot.ends) : "";
  const std::string third = spot.third ? fmt::format(", third body at ({:.6g}, {:.6g}, {:.6g}) m",
                                                     spot.third->x, spot.third->y, spot.third->z)
                                       : "";
  return fmt::format("observer {}, target {}{}, t = {:.6g} s{}", describe(spot.observer),
                     describe(spot.target), third, spot.t, ends);
}

}  // namespace sightline
