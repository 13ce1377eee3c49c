#include "bench/barrier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "tests/support/adversary.hpp"

namespace sightline {
namespace {

struct Situation {
  test::State x;
  test::VehicleInput u;
  std::vector<Neighbour> neighbours;
};

/// Moves the neighbour along a direction to the distance at which `reserve` remains.
void approach(const Barrier& barrier, const test::State& x, const Vec3<double>& direction, double reserve,
              Neighbour& n) {
  double near = 0.3, far = 20.0;
  for (int k = 0; k < 40; ++k) {
    const double middle = 0.5 * (near + far);
    n.p = Vec3<double>{x[0], x[1], x[2]} + middle * direction;
    (barrier.reserve(x, n) < reserve ? near : far) = middle;
  }
}

Situation situation(const Barrier& barrier, int neighbours, Random& random) {
  const double heading = uniform(random, -3.1, 3.1), side = uniform(random, -3.1, 3.1);
  Situation s{.x = {0, 0, uniform(random, 1, 2), std::cos(heading), std::sin(heading), uniform(random, -1, 1),
                    uniform(random, -1, 1)},
              .u = {},
              .neighbours = {}};
  for (int i = 0; i < neighbours; ++i) {
    const double angle = side + uniform(random, -0.8, 0.8), height = uniform(random, -0.4, 0.4);
    Neighbour n{.d_hard = 0.6, .speed_max = uniform(random, 0.0, 1.0)};
    approach(barrier, s.x, {std::cos(angle), std::sin(angle), height}, uniform(random, 0.0, 0.05), n);
    s.neighbours.push_back(n);
  }
  s.u = test::towards(s.x, s.neighbours.front().p);
  return s;
}

}  // namespace

std::vector<std::string> barrier_case_names() { return {"barrier_1", "barrier_4", "barrier_16"}; }

bool is_barrier_case(std::string_view name) {
  const std::vector<std::string> names = barrier_case_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

BenchRow run_barrier_bench(std::string_view name, const BenchOptions& options) {
  using std::chrono::steady_clock;
  const int neighbours = name == "barrier_1" ? 1 : name == "barrier_4" ? 4 : 16;
  const Barrier barrier(Multirotor{}, test::lowest, test::highest, 0.01, {.floor = 0.3, .world = 100.0});
  Random random(1);
  std::vector<Situation> situations;
  int conflicts = 0;
  while (situations.size() < 500) {
    const Situation s = situation(barrier, neighbours, random);
    test::VehicleInput u = s.u;
    const BarrierResult result = barrier.filter(s.x, s.neighbours, test::lowest, test::highest, u);
    if (!result.active) continue;
    situations.push_back(s);
    conflicts += result.conflict;
  }
  if (options.progress) options.progress(conflicts);

  BenchRow row{.name = std::string(name), .solver = "barrier", .agents = 1};
  std::vector<double> us(static_cast<std::size_t>(options.updates));
  for (std::size_t k = 0; k < us.size(); ++k) {
    const Situation& s = situations[k % situations.size()];
    test::VehicleInput u = s.u;
    const std::int64_t before = options.allocations == nullptr ? 0 : options.allocations();
    const steady_clock::time_point begin = steady_clock::now();
    const BarrierResult result = barrier.filter(s.x, s.neighbours, test::lowest, test::highest, u);
    us[k] = std::chrono::duration<double, std::micro>(steady_clock::now() - begin).count();
    if (options.allocations != nullptr)
      row.allocations = std::max(row.allocations, options.allocations() - before);
    if (!result.active)
      throw std::runtime_error(fmt::format("{}: a command was left alone, expected none", name));
  }
  std::sort(us.begin(), us.end());
  row.median_us = us[us.size() / 2];
  row.p99_us = us[us.size() * 99 / 100];
  row.max_us = us.back();
  return row;
}

}  // namespace sightline
