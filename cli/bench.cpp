#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "cli/allocations.hpp"
#include "cli/arguments.hpp"
#include "cli/output.hpp"
#include "sightline/run/realtime.hpp"
#include "sightline/scenario.hpp"
#ifdef SIGHTLINE_BENCH
#include "bench/barrier.hpp"
#include "bench/bench.hpp"
#include "bench/estimate.hpp"
#include "bench/event.hpp"
#include "bench/swarm.hpp"
#endif

namespace sightline::cli {
namespace {

struct BenchCommand {
  std::optional<std::string> name;
  std::string solver = "newton_riccati";
  int threads = 1, updates = 6000;
  bool json = false, times_only = false, paced = false;
  double warm_up = 1e-3;
};

#ifdef SIGHTLINE_BENCH

int bench(const BenchCommand& command, char** /*argv*/) {
  std::vector<BenchCase> cases;
  SolverChoice solver;
  std::shared_ptr<ThreadPool> pool;
  try {
    solver = solver_named(command.solver);
    pool = std::make_shared<ThreadPool>(command.threads);
    share_updates(solver, pool);
    for (const std::string& name : command.name    ? std::vector{*command.name}
                                   : command.paced ? paced_case_names()
                                                   : bench_case_names()) {
      const bool is_alone = is_barrier_case(name) || name == event_case_name || name == estimate_case_name;
      if (is_alone && command.threads > 1)
        throw std::invalid_argument(
            fmt::format("--threads = {} of {}, expected 1: nothing in it is shared", command.threads, name));
      if ((is_alone || is_swarm_case(name)) && command.solver != SolverChoice{}.name)
        throw std::invalid_argument(fmt::format("--solver = {} of {}, expected {}: no other is timed in it",
                                                command.solver, name, SolverChoice{}.name));
      if ((is_alone || is_swarm_case(name)) && command.paced)
        throw std::invalid_argument(
            fmt::format("--paced of {}, expected a case of updates: pair, chain_64", name));
      if (!is_alone && !is_swarm_case(name)) cases.push_back(bench_case(name));
    }
  } catch (const std::invalid_argument& error) {
    print_message("sightline bench: {}\n", error.what());
    return 2;
  }

  if (command.threads == 1) pin_to_core();
  if (command.paced) print_message("{}\n", become_realtime(control_priority).sentence());
  std::vector<BenchRow> rows;
  const auto reporting = [&](std::string_view what) {
    return BenchOptions{.updates = command.updates,
                        .allocations = allocations,
                        .progress = [what](int count) { print_message("{} {}\n", count, what); }};
  };
  if (command.name && is_barrier_case(*command.name))
    rows.push_back(run_barrier_bench(*command.name, reporting("of 500 conflicts")));
  if (command.name && is_swarm_case(*command.name))
    rows = run_swarm_bench(*command.name, reporting("pairs at most"), pool);
  if (command.name == event_case_name) rows = run_event_bench(reporting("changes"));
  if (command.name == estimate_case_name) rows = run_estimate_bench(reporting("sightings accepted"));
  for (const BenchCase& what : cases) {
    print_message("{}: ", what.name);
    rows.push_back(run_bench(what, solver,
                             {.updates = command.updates,
                              .allocations = allocations,
                              .progress =
                                  [](int update) {
                                    if (update % 500 == 0) print_message(".");
                                  },
                              .judged = !command.times_only && !command.paced,
                              .paced = command.paced,
                              .warm_up = command.warm_up}));
    const BenchRow& row = rows.back();
    print_message(" {:.2f} us\n", row.median_us);
    if (row.unconverged > 0)
      print_message("{}: the optimum of {} updates is not known to 1e-10\n", row.name, row.unconverged);
    if (row.ipopt_failed > 0) print_message("{}: IPOPT failed {} times\n", row.name, row.ipopt_failed);
  }
  print("{}", command.json ? bench_json(rows) : command.paced ? paced_table(rows) : bench_table(rows));
  return 0;
}

#else

int bench(const BenchCommand& /*command*/, char** argv) {
  const std::filesystem::path program =
      std::filesystem::read_symlink("/proc/self/exe").replace_filename("sightline_bench");
  execv(program.c_str(), argv);
  print_message(
      "sightline bench: {} cannot be started ({}), expected a build configured with -D SIGHTLINE_BENCH=ON, "
      "as the release preset is\n",
      program.native(), std::strerror(errno));
  return 2;
}

#endif

}  // namespace

Execute describe_bench(CLI::App& app) {
  const auto command = std::make_shared<BenchCommand>();
  app.description("Time the solvers and compare them with the optimum");
  app.add_option("--case", command->name, "One case, instead of all");
  app.add_option("--solver", command->solver, "Solver [newton_riccati]");
  app.add_flag("--json", command->json, "JSON instead of a table");
  add_threads(app, command->threads);
  app.add_option("--updates", command->updates,
                 "Updates of each case; of swarm_N in whole crossings, events_8 has its own")
      ->capture_default_str()
      ->check(CLI::Range(100, 10'000'000));
  app.add_flag("--times", command->times_only, "Times alone, not compared with the optimum");
  CLI::Option* const paced =
      app.add_flag("--paced", command->paced,
                   "Times at 100 Hz with sleep between, as in a flight, by SCHED_FIFO where allowed");
  app.add_option("--warm-up", command->warm_up,
                 "Longest time before an update in which the solver fills the caches [s]")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 5e-3))
      ->needs(paced);
  return [command](const Registry&, char** argv) { return bench(*command, argv); };
}

}  // namespace sightline::cli
