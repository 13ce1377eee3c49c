#include "sightline/model/state_roles.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "sightline/formula/derive.hpp"
#include "sightline/formula/interpret.hpp"
#include "sightline/model/model.hpp"

namespace sightline {
namespace {

/// How the sight moves with each state: at(i, k) is d sight_i / d x_k, in the order of `write_sight`.
struct Slopes {
  std::vector<double> of;
  std::size_t nx;
  double at(std::size_t i, std::size_t k) const { return of[i * nx + k]; }
};

/// The slopes of a robot, as a formula of its states and inputs.
Program slopes_of(const Model& model) {
  Graph graph;
  const auto nx = static_cast<std::size_t>(model.nx());
  const std::vector<Symbol> z = variables(graph, 0, model.nx() + model.nu());
  const std::span<const Symbol> all = z;
  std::array<Symbol, sight_size> shown;
  write_sight(model.sight(all.first(nx), all.subspan(nx)), shown);
  std::vector<Term> states;
  for (std::size_t k = 0; k < nx; ++k) states.push_back(z[k].in(graph));
  std::vector<Term> slopes;
  for (const Symbol& one : shown) {
    const std::vector<Term> by = gradient(graph, one.in(graph), states);
    slopes.insert(slopes.end(), by.begin(), by.end());
  }
  return Program(graph, slopes, model.nx() + model.nu());
}

}  // namespace

StateRoles roles_of(const Model& model) {
  constexpr int samples = 5;
  constexpr std::size_t heading = 3, velocity = 5;  // where they stand in a sight
  const auto nx = static_cast<std::size_t>(model.nx());
  const Program slopes = slopes_of(model);
  std::mt19937_64 random(1);
  const auto draw = [&] { return std::uniform_real_distribution<double>(0.1, 1.0)(random); };
  std::vector<Slopes> seen;
  std::vector<Vec2<double>> headings;
  for (int n = 0; n < samples; ++n) {
    std::vector<double> z(nx + static_cast<std::size_t>(model.nu()));
    std::generate(z.begin(), z.end(), draw);
    if (!model.normalise(z.data())) continue;
    seen.push_back({evaluate(slopes, z), nx});
    headings.push_back(model.sight(z.data(), z.data() + nx).d);
  }
  const auto always = [&](auto&& holds) {
    bool all = !seen.empty();
    for (std::size_t n = 0; n < seen.size(); ++n) all = all && holds(seen[n], headings[n]);
    return all;
  };
  const auto is = [](double a, double b) { return std::fabs(a - b) < 1e-9; };

  StateRoles roles;
  for (std::size_t k = 0; k < nx; ++k) {
    const int state = static_cast<int>(k);
    const auto is_unit = [&](std::size_t first, std::size_t count, std::size_t axis) {
      return always([&](const Slopes& s, const Vec2<double>&) {
        bool unit = true;
        for (std::size_t i = 0; i < count; ++i) unit = unit && is(s.at(first + i, k), i == axis ? 1.0 : 0.0);
        return unit;
      });
    };
    bool placed = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (is_unit(0, 3, axis)) roles.position[axis] = state, placed = true;
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (is_unit(heading, 2, axis)) roles.direction[axis] = state, placed = true;
    }
    const bool turns = always([&](const Slopes& s, const Vec2<double>& d) {
      return is(s.at(heading, k), -d.y) && is(s.at(heading + 1, k), d.x);
    });
    if (turns) roles.angle = state, placed = true;
    const bool speeds = always([&](const Slopes& s, const Vec2<double>&) {
      return is(norm(Vec3<double>{s.at(velocity, k), s.at(velocity + 1, k), s.at(velocity + 2, k)}), 1.0);
    });
    const bool called = k < model.states().size() && model.states()[k].starts_with("v_");
    if (!placed && (speeds || called)) roles.velocities.push_back(state);
  }
  if (roles.direction[0] < 0 || roles.direction[1] < 0) roles.direction = {-1, -1};
  return roles;
}

}  // namespace sightline
