#include "bench/bench.hpp"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <thread>

#include "bench/ipopt.hpp"
#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/base/quantile.hpp"
#include "sightline/config.hpp"
#include "sightline/loop.hpp"
#include "sightline/run/warm_up.hpp"
#include "sightline/solver/newton/influence.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

/// Record of a closed loop: every measured state and applied input, and the time of each update.
struct Flight {
  std::vector<double> x, u;  // (updates x nx), (updates x nu)
  std::vector<double> us;
  std::int64_t allocations = 0;
  double krylov_sum = 0.0;
};

/// Only the plant runs between two updates. Unless they are paced, caches are warmer than in a
/// flight.
Flight fly(const BenchCase& what, Solver& solver, const BenchOptions& options) {
  using std::chrono::steady_clock;
  const std::size_t nx = at(what.team.nx()), nu = at(what.team.nu()), n = at(options.updates);
  const double dt = bench_horizon.dt;
  const auto count = [&] { return options.allocations == nullptr ? 0 : options.allocations(); };
  const std::size_t kept = options.judged ? n : 0;
  Flight flight{
      .x = std::vector<double>(kept * nx), .u = std::vector<double>(kept * nu), .us = std::vector<double>(n)};
  Plant plant(what.team, what.x0, {.period = dt});
  SteadyClock clock;
  WarmUp warm_up(options.warm_up);
  if (options.paced) clock.start(dt);
  std::int64_t period = 0;  // of the clock
  for (std::size_t k = 0; k < n; ++k) {
    if (options.paced) {
      warm_up.before(clock, period, [&]() noexcept { solver.warm_up(); });
      period = clock.wait(period) + 1;
    }
    if (options.judged) std::copy(plant.x().begin(), plant.x().end(), &flight.x[k * nx]);
    const std::int64_t allocated = count();
    const steady_clock::time_point begin = steady_clock::now();
    const Solution solution = solver.solve(dt * static_cast<double>(k), plant.x());
    const steady_clock::time_point end = steady_clock::now();
    flight.allocations = std::max(flight.allocations, count() - allocated);
    flight.us[k] = std::chrono::duration<double, std::micro>(end - begin).count();
    flight.krylov_sum += solution.iterations;
    if (options.judged) std::copy(solution.u.begin(), solution.u.end(), &flight.u[k * nu]);
    if (!plant.step(solution.u, dt)) {
      throw std::runtime_error(fmt::format("{}: not finite after {:.2f} s of flight with {}", what.name,
                                           dt * static_cast<double>(k + 1), solver.name()));
    }
  }
  return flight;
}

double largest_difference(std::span<const double> a, std::span<const double> b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::fabs(a[i] - b[i]));
  return worst;
}

bool has_cycle(const Ocp& ocp) {
  const int agents = static_cast<int>(ocp.agent_bodies().size());
  return influence_graph(trace_potentials(ocp), agents).kind == Influence::cyclic;
}

std::vector<double> plan_of(const NewtonRiccati& solver) {
  const std::size_t nu = at(solver.ocp().nu());
  std::vector<double> u(at(solver.ocp().horizon().N) * nu);
  for (int k = 0; k < solver.ocp().horizon().N; ++k) solver.plan(k, std::span(u).subspan(at(k) * nu, nu));
  return u;
}

/// Compares a flight with the converged optimum at each of its states, and that optimum with
/// IPOPT's.
void judge(const BenchCase& what, const Flight& flight, const BenchOptions& options, BenchRow& row) {
  constexpr double settled = 2.0;  // s
  constexpr std::size_t large =
      64;  // robots, beyond which the optimum is computed now and then, and not by IPOPT
  const std::size_t nx = at(what.team.nx()), nu = at(what.team.nu());
  const bool is_large = what.team.agents().size() > large;
  const Ocp ocp(what.team, bench_horizon);
  NewtonRiccati optimum(ocp, {.max_newton_steps = 40,
                              .tolerance = 1e-10,
                              .max_krylov = 200,
                              .krylov_stop = 1e-13,
                              .start_steps = 100});
  // A team with cycles of influence has no single optimum, but a point at which no robot gains by a
  // change of its own.
  std::optional<IpoptReference> ipopt;
  if (!is_large && !has_cycle(ocp)) ipopt.emplace(ocp);
  std::vector<double> ipopt_us, before = plan_of(optimum);
  for (int k = 0; k < options.updates; ++k) {
    const double t = bench_horizon.dt * k;
    const std::span x(&flight.x[at(k) * nx], nx), u(&flight.u[at(k) * nu], nu);
    row.cost += bench_horizon.dt * stage_cost(what.team, t, x, u);
    const bool compare = k % options.ipopt_every == 0;
    if (is_large && !compare) continue;
    if (compare && k > 0) before = plan_of(optimum);
    const Solution best = optimum.solve(t, x);
    if (best.status != Status::converged) ++row.unconverged;
    const double error = largest_difference(u, best.u);
    if (k > 0) row.input_error_transient = std::max(row.input_error_transient, error);
    if (t > settled) row.input_error_max = std::max(row.input_error_max, error);
    if (!compare || !ipopt) continue;
    if (options.progress) options.progress(k);
    const std::vector<double> plan = plan_of(optimum);
    try {
      const Optimum other = ipopt->solve(t, x, k == 0 ? plan : before);
      ipopt_us.push_back(1e6 * other.seconds);
      row.ipopt_difference = std::max(row.ipopt_difference, largest_difference(plan, other.u));
    } catch (const std::runtime_error&) {
      ++row.ipopt_failed;
    }
  }
  if (!ipopt_us.empty()) row.ipopt_median_us = quantile(ipopt_us, 0.5);
}

/// The processor's name and its number of cores.
std::string machine() {
  std::ifstream file("/proc/cpuinfo");
  std::string name = "unknown processor";
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    name = line.substr(std::min(line.find(": ") + 2, line.size()));
    break;
  }
  return fmt::format("{}, {} cores", name, std::thread::hardware_concurrency());
}

}  // namespace

void pin_to_core() {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(std::max(0, sched_getcpu())), &set);
  (void)sched_setaffinity(0, sizeof set, &set);
}

BenchRow run_bench(const BenchCase& what, SolverChoice choice, const BenchOptions& options) {
  const auto choose_kernels = [&](auto& chosen) {
    if constexpr (requires { chosen.kernels; }) chosen.kernels = what.kernels;
  };
  std::visit(choose_kernels, choice.options);
  const auto solver = make_solver(choice, what.team, bench_horizon);
  const Flight flight = fly(what, *solver, options);
  BenchRow row{.name = what.name,
               .solver = std::string(solver->name()),
               .agents = static_cast<int>(what.team.agents().size()),
               .masked = what.masked,
               .median_us = quantile(flight.us, 0.5),
               .p99_us = quantile(flight.us, 0.99),
               .max_us = quantile(flight.us, 1.0),
               .first_us = flight.us[0],
               .p999_us = quantile(flight.us, 0.999),
               .p9999_us = quantile(flight.us, 0.9999),
               .allocations = flight.allocations,
               .krylov_mean = flight.krylov_sum / options.updates};
  if (options.judged) judge(what, flight, options, row);
  return row;
}

BenchRow row_of(std::string_view name, int agents, std::vector<double> us) {
  BenchRow row{.name = std::string(name), .solver = "newton_riccati", .agents = agents};
  std::sort(us.begin(), us.end());
  row.median_us = us[us.size() / 2];
  row.p99_us = us[us.size() * 99 / 100];
  row.p9999_us = us[us.size() * 9999 / 10000];
  row.max_us = us.back();
  return row;
}

std::string bench_json(const std::vector<BenchRow>& rows) {
  nlohmann::ordered_json json = {
      {"machine", machine()}, {"compiler", compiler}, {"cases", nlohmann::json::array()}};
  for (const BenchRow& row : rows) {
    json["cases"].push_back(nlohmann::ordered_json{{"name", row.name},
                                                   {"solver", row.solver},
                                                   {"agents", row.agents},
                                                   {"masked", row.masked},
                                                   {"median_us", row.median_us},
                                                   {"p99_us", row.p99_us},
                                                   {"max_us", row.max_us},
                                                   {"first_us", row.first_us},
                                                   {"p9999_us", row.p9999_us},
                                                   {"input_error_max", row.input_error_max},
                                                   {"input_error_transient", row.input_error_transient},
                                                   {"cost", row.cost},
                                                   {"allocations", row.allocations},
                                                   {"krylov_mean", row.krylov_mean}});
  }
  return json_text(json, 2) + "\n";
}

std::string paced_table(const std::vector<BenchRow>& rows) {
  std::string text = fmt::format("{}; {}\n\n", machine(), compiler);
  text +=
      "| case | solver | robots | p50 us | p99 us | p99.9 us | p99.99 us | max us | allocations |\n"
      "|---|---|---|---|---|---|---|---|---|\n";
  for (const BenchRow& row : rows)
    text += fmt::format("| {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {} |\n", row.name,
                        row.solver, row.agents, row.median_us, row.p99_us, row.p999_us, row.p9999_us,
                        row.max_us, row.allocations);
  return text;
}

std::string bench_table(const std::vector<BenchRow>& rows) {
  std::string text = fmt::format("{}; {}\n\n", machine(), compiler);
  text +=
      "| case | solver | robots | median us | p99 us | max us | error after 2 s | error before | cost | "
      "allocations | Krylov | IPOPT us | error to IPOPT |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const BenchRow& row : rows) {
    text += fmt::format(
        "| {} | {} | {} | {:.2f} | {:.2f} | {:.1f} | {:.1e} | {:.1e} | {:.4f} | {} | {:.2f} | {:.0f} | "
        "{:.1e} |\n",
        row.name, row.solver, row.agents, row.median_us, row.p99_us, row.max_us, row.input_error_max,
        row.input_error_transient, row.cost, row.allocations, row.krylov_mean, row.ipopt_median_us,
        row.ipopt_difference);
  }
  return text;
}

}  // namespace sightline
