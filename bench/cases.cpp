#include "bench/cases.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sightline/potentials.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/robots.hpp"

namespace sightline {
namespace {

constexpr std::array<int, 6> chain_lengths = {2, 4, 8, 16, 32, 64};
constexpr int team_least = 8, team_most = 1024;  // robots of a family's team
constexpr int flown_most = 64;                   // greatest team that runs without being named

void watch(Team& team, AgentId observer, AgentId target, const std::vector<AgentId>& who) {
  team.couple(0.4 * SensorCone{}, Between{observer, target}, who);
  team.couple(0.4 * Cohesion{}, Between{observer, target}, who);
  team.couple(0.4 * KeepOut{}, Between{observer, target}, who);
}

/// Each robot is 1.5 m behind and 0.375 m above the one it observes; a chain of two starts like the
/// pair.
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

enum class Strong {
  cascade,  ///< each robot's cost includes the couplings to its target
  apart,    ///< as cascade; robots two apart also keep their distance, in the cost of both, except the first
  mutual,   ///< as apart, and all couplings are in the cost of both
};

/// scenarios/chain8.toml, lengthened: the first robot flies a circle, each other robot observes the
/// previous one.
BenchCase strong_chain(std::string name, int length, Strong kind) {
  constexpr std::array<double, 7> y = {0.5, -0.4, 0.3, -0.6, 0.5, -0.2, 0.4};
  constexpr std::array<double, 7> headings = {1.2, -1.5, 0.6, -0.9, 2.2, 0.3, -1.8};
  BenchCase c{.name = std::move(name), .masked = kind != Strong::mutual};
  std::vector<AgentId> robots;
  for (int i = 0; i < length; ++i) {
    AgentOptions<Multirotor> options{.name = fmt::format("uav{}", i)};
    double heading = 0.0;
    Vec3<double> p = {1.5 - 1.4 * i, 0.0, 1.0 + 0.3 * i};
    if (i == 0) {
      options.Q = {1.5, 1.5, 1.6, 0, 0, 0, 0};
      options.x_ref = Circle{.centre = {0, 0, 1}, .radius = 1.5, .rate = 0.2};
    } else {
      options.R.fill(0.1);
      p.y = y[static_cast<std::size_t>(i - 1) % y.size()];
      heading = headings[static_cast<std::size_t>(i - 1) % headings.size()];
    }
    robots.push_back(c.team.add(Multirotor{}, options));
    c.x0.insert(c.x0.end(), {p.x, p.y, p.z, std::cos(heading), std::sin(heading), 0.0, 0.0});
  }
  const auto felt = [&](AgentId a, AgentId b, bool by_both) {
    return by_both ? felt_by({a, b}) : felt_by(a);
  };
  for (std::size_t i = 1; i < robots.size(); ++i) {
    const Between watched{robots[i], robots[i - 1]};
    const auto who = felt(robots[i], robots[i - 1], kind == Strong::mutual);
    c.team.couple(4.0 * Bearing{.mount = {.pitch = 0.3}}, watched, who);
    c.team.couple(4.0 * TooNear{.d_min = 1.0, .kappa = 10.0}, watched, who);
    c.team.couple(8.0 * TooFar{.d_max = 2.0, .kappa = 10.0}, watched, who);
    c.team.couple(0.1 * RelativeVelocity{.v_0 = 1.0}, watched, who);
    if (i < 2 || kind == Strong::cascade) continue;
    c.team.couple(4.0 * TooNear{.d_min = 1.0, .kappa = 10.0}, Between{robots[i], robots[i - 2]},
                  felt(robots[i], robots[i - 2], i > 2 || kind == Strong::mutual));
  }
  return c;
}

/// A grid with four robots per row: each keeps apart from its neighbours in its row and column.
BenchCase grid(std::string name, int robots_in_all) {
  constexpr int columns = 4;
  BenchCase c{.name = std::move(name)};
  std::vector<AgentId> robots;
  for (int i = 0; i < robots_in_all; ++i) {
    const int row = i / columns, column = i % columns;
    const Vec3<double> p = {1.5 * column, 1.5 * row, 1.0};
    AgentOptions<Multirotor> options{.name = fmt::format("uav{}", i)};
    options.Q = {0.5, 0.5, 1.0, 0.5, 0.5, 0.1, 0.1};
    options.x_ref = Circle{.centre = p, .radius = 0.5, .rate = 0.3 + 0.02 * (i % 5)};
    robots.push_back(c.team.add(Multirotor{}, options));
    c.x0.insert(c.x0.end(), {p.x, p.y, p.z, 1.0, 0.0, 0.0, 0.0});
  }
  const auto near = [&](int a, int b) {
    const AgentId one = robots[static_cast<std::size_t>(a)], other = robots[static_cast<std::size_t>(b)];
    c.team.couple(4.0 * TooNear{.d_min = 1.2, .kappa = 10.0}, Between{one, other}, felt_by({one, other}));
  };
  for (int i = 0; i < robots_in_all; ++i) {
    if (i % columns > 0) near(i, i - 1);
    if (i >= columns) near(i, i - columns);
  }
  return c;
}

/// Adds a robot to the ring at its reference position, heading to the next robot.
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

constexpr std::array<std::string_view, 4> families = {"cascade", "strong_chain", "mutual_chain", "grid"};

BenchCase team_of(std::string_view family, int size) {
  std::string name = fmt::format("{}_{}", family, size);
  if (family == "grid") return grid(std::move(name), size);
  const Strong kind = family == "cascade"        ? Strong::cascade
                      : family == "strong_chain" ? Strong::apart
                                                 : Strong::mutual;
  return strong_chain(std::move(name), size, kind);
}

BenchCase pair(std::string name, paper::Variant variant, std::vector<double> x0) {
  return {.name = std::move(name),
          .team = paper::team(variant),
          .x0 = std::move(x0),
          .masked = variant == paper::Variant::masked};
}

}  // namespace

std::vector<std::string> paced_case_names() { return {"pair", "chain_64", "cascade_64", "chain_256"}; }

std::vector<std::string> bench_case_names() {
  std::vector<std::string> names = {"pair", "pair_masked"};
  for (const int length : chain_lengths) {
    names.push_back(fmt::format("chain_{}", length));
    names.push_back(fmt::format("chain_{}_masked", length));
  }
  for (const char* name : {"chain_8_interpreted", "ring_mixed", "saturating"}) names.emplace_back(name);
  for (const int size : {team_least, flown_most}) {
    for (const std::string_view family : families) names.push_back(fmt::format("{}_{}", family, size));
  }
  return names;
}

std::optional<int> team_size(std::string_view name, std::string_view family) {
  int size = 0;
  std::from_chars(name.data() + std::min(family.size() + 1, name.size()), name.data() + name.size(), size);
  const bool named = size >= team_least && size <= team_most && name == fmt::format("{}_{}", family, size);
  return named ? std::optional(size) : std::nullopt;
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
  if (const std::optional<int> length = team_size(name, "chain"))
    return chain(std::string(name), *length, false);
  for (const int length : chain_lengths) {
    for (const bool masked : {false, true}) {
      std::string known = fmt::format("chain_{}{}", length, masked ? "_masked" : "");
      if (name == known) return chain(std::move(known), length, masked);
    }
  }
  for (const std::string_view family : families) {
    if (const std::optional<int> size = team_size(name, family)) return team_of(family, *size);
  }
  throw std::invalid_argument(
      fmt::format("case = {}, expected one of {}; or chain_M, cascade_M, strong_chain_M, mutual_chain_M, "
                  "grid_M or swarm_M of {} to {} robots; or barrier_1, barrier_4, barrier_16, events_8 or "
                  "estimate",
                  name, fmt::join(bench_case_names(), ", "), team_least, team_most));
}

}  // namespace sightline
