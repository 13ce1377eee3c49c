#include "sightline/potential/finite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "sightline/formula/derive.hpp"
#include "sightline/formula/interpret.hpp"

namespace sightline {
namespace {

constexpr int inputs = 2 * sight_size + 1;
constexpr int batch = 512;

using Random = std::mt19937_64;
using Numbers = std::array<double, inputs>;

/// Value, gradient and Hessian, each distinct entry once.
Program record(const Potential& potential) {
  Graph graph;
  const std::vector<Symbol> z = variables(graph, 0, inputs);
  const Term l =
      potential(sight_from<Symbol>(z.data()), sight_from<Symbol>(z.data() + sight_size), z.back()).in(graph);
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
  return Program(graph, outputs, inputs);
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

Numbers draw(Random& random) {
  constexpr std::array reaches = {0.3, 3.0, 30.0};
  const bool on_axes = random() % 4 == 0;
  const double reach = reaches[random() % reaches.size()];
  Numbers z;
  write_sight(draw_sight(random, reach, on_axes), z);
  write_sight(draw_sight(random, reach, on_axes), std::span(z).subspan(sight_size));
  z.back() = std::uniform_real_distribution<double>(0.0, 100.0)(random);
  return z;
}

}  // namespace

std::optional<Spot> not_finite_at(const Potential& potential, int samples) {
  const Program program = record(potential);
  Rows in(inputs, batch), out(program.outputs(), batch);
  Evaluation evaluation(program, batch);
  for (int i = 0; i < inputs; ++i) evaluation.input(i, in[i]);
  for (int i = 0; i < program.outputs(); ++i) evaluation.output(i, out[i]);
  Random random(1);
  for (int done = 0; done < samples; done += batch) {
    std::array<Numbers, batch> drawn;
    for (int k = 0; k < batch; ++k) {
      drawn[static_cast<std::size_t>(k)] = draw(random);
      for (int i = 0; i < inputs; ++i)
        in[i][k] = drawn[static_cast<std::size_t>(k)][static_cast<std::size_t>(i)];
    }
    evaluation.run();
    for (int k = 0; k < batch; ++k) {
      for (int i = 0; i < program.outputs(); ++i) {
        if (std::isfinite(out[i][k])) continue;
        const Numbers& z = drawn[static_cast<std::size_t>(k)];
        return Spot{sight_from<double>(z.data()), sight_from<double>(z.data() + sight_size), z.back()};
      }
    }
  }
  return {};
}

std::string to_string(const Spot& spot) {
  const auto words = [](const Sight<double>& s) {
    return fmt::format("at ({:.6g}, {:.6g}, {:.6g}) m heading ({:.6g}, {:.6g})", s.p.x, s.p.y, s.p.z, s.d.x,
                       s.d.y);
  };
  return fmt::format("observer {}, target {}, t = {:.6g} s", words(spot.observer), words(spot.target),
                     spot.t);
}

}  // namespace sightline
