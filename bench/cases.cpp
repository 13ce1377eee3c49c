#include "bench/cases.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/support/paper_team.hpp"
#include "tests/support/robots.hpp"

namespace sightline {
namespace {

constexpr std::array<int, 6> chain_lengths = {2, 4, 8, 16, 32, 64};

void watch(Team& team, AgentId observer, AgentId target, const std::vector<AgentId>& who) {
  team.couple(0.4 * SensorCone{}, Between{observer, target}, who);
  team.couple(0.4 * Cohesion{}, Between{observer, target}, who);
  team.couple(0.4 * KeepOut{}, Between{observer, target}, who);
}

/// Each robot 1.5 m behind the one it watches and 0.375 m above it; a chain of two starts as the pair does.
BenchCase chain(std::string name, int length, bool masked) {
  BenchCase c{.name = std::move(name), .masked = masked};
  std::vector<AgentId> robots;
  for (int i = 0; i < length; ++i) {
    paper::Options options = i + 1 < length ? paper::observer() : paper::target();
    options.name = fmt::format("uav{}", i);
    robots.push_back(c.team.add(Multirotor{}, options));
    const double behind = 1.5 * (length - 1 - i);
    for (const double x : {-behind, 0.0, 0.5 + 0.25 * behind, 1.0, 0.0, 0.0, 0.0}) c.x0.push_back(x);
  }
  for (std::size_t i = 0; i + 1 < robots.size(); ++i) {
    watch(c.team, robots[i], robots[i + 1],
          masked ? felt_by(robots[i]) : felt_by({robots[i], robots[i + 1]}));
  }
  if (length == 2) c.x0 = paper::start();
  return c;
}

/// Puts a robot on the ring, where it wants to stay, looking at the next.
template <RobotModel M>
AgentId add_to_ring(BenchCase& c, const M& model, int place, int places, const AgentOptions<M>& weights) {
  constexpr double spacing = 1.5;
  const double angle = 2.0 * std::numbers::pi * place / places, step = std::numbers::pi / places;
  const double radius = spacing / (2.0 * std::sin(step)), ahead = angle + step + std::numbers::pi / 2;
  const Vec3<double> p = {radius * std::cos(angle), radius * std::sin(angle), 0.4 + 0.3 * (place % 3)};
  AgentOptions<M> options = weights;
  options.x_ref = [p](double t) { return Pose<double>{{p.x + 0.3 * std::sin(0.4 * t), p.y, p.z}, {}}; };
  const auto x = model.at_rest({p, {std::cos(ahead), std::sin(ahead)}});
  c.x0.insert(c.x0.end(), x.begin(), x.end());
  return c.team.add(model, options);
}

BenchCase ring_mixed() {
  constexpr int places = 8;
  BenchCase c{.name = "ring_mixed"};
  std::vector<AgentId> robots;
  for (int i = 0; i < places; i += 4) {
    robots.push_back(add_to_ring(c, Multirotor{}, i, places, {.Q = {0.5, 0.5, 0.8, 0, 0, 0.3, 0.3}}));
    robots.push_back(add_to_ring(c, AngleMultirotor{}, i + 1, places, {.Q = {0.5, 0.5, 0.8, 0, 0.3, 0.3}}));
    robots.push_back(add_to_ring(c, test::Unicycle{}, i + 2, places, {.Q = {0.5, 0.5, 0, 0.3}}));
    robots.push_back(add_to_ring(c, test::Quadrotor{}, i + 3, places,
                                 {.Q = {0.5, 0.5, 0.8, 0.3, 0.3, 0.3, 0, 0, 0.1, 0.1, 0.1, 0.01}}));
  }
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const AgentId next = robots[(i + 1) % robots.size()];
    watch(c.team, robots[i], next, felt_by({robots[i], next}));
  }
  return c;
}

BenchCase pair(std::string name, paper::Variant variant, std::vector<double> x0) {
  return {.name = std::move(name),
          .team = paper::team(variant),
          .x0 = std::move(x0),
          .masked = variant == paper::Variant::masked};
}

}  // namespace

std::vector<std::string> bench_case_names() {
  std::vector<std::string> names = {"pair", "pair_masked"};
  for (const int length : chain_lengths) {
    names.push_back(fmt::format("chain_{}", length));
    names.push_back(fmt::format("chain_{}_masked", length));
  }
  for (const char* name : {"chain_8_interpreted", "ring_mixed", "saturating"}) names.emplace_back(name);
  return names;
}

BenchCase bench_case(std::string_view name) {
  if (name == "pair") return pair("pair", paper::Variant::joint, paper::start());
  if (name == "pair_masked") return pair("pair_masked", paper::Variant::masked, paper::start());
  if (name == "saturating") return pair("saturating", paper::Variant::joint, paper::saturating_start());
  if (name == "ring_mixed") return ring_mixed();
  if (name == "chain_8_interpreted") {
    BenchCase c = chain(std::string(name), 8, false);
    c.kernels = KernelChoice::interpreted;
    return c;
  }
  for (const int length : chain_lengths) {
    for (const bool masked : {false, true}) {
      std::string known = fmt::format("chain_{}{}", length, masked ? "_masked" : "");
      if (name == known) return chain(std::move(known), length, masked);
    }
  }
  throw std::invalid_argument(
      fmt::format("case = {}, expected one of {}", name, fmt::join(bench_case_names(), ", ")));
}

}  // namespace sightline
