#include "benchmark/controllers/controllers.hpp"

#include "benchmark/controllers/mpc_laws.hpp"
#include "benchmark/controllers/process_control.hpp"
#include "benchmark/controllers/view_barrier.hpp"
#include "benchmark/controllers/visual_servo.hpp"

namespace sightline::benchmark {
namespace {

/// Adds a solver of one law for each observer.
/// @param law  makes one: (team, horizon, task, options)
template <class Options, class MakeLaw>
void add_law(Registry& registry, const std::string& name, MakeLaw law) {
  registry.solvers.add<Options>(
      name, {}, [=](const Team& team, const Horizon& horizon, const Options& options) {
        const std::vector<ViewTask> tasks = view_tasks(team);
        std::vector<std::unique_ptr<ViewLaw>> laws;
        for (const ViewTask& task : tasks) laws.push_back(law(team, horizon, task, options));
        return std::make_unique<ObserverSolver>(name, team, horizon, tasks,
                                                std::make_unique<SeparateLaws>(team, tasks, std::move(laws)));
      });
}

}  // namespace

void add_controllers(Registry& registry, const std::string& command) {
  add_law<ViewBarrierOptions>(
      registry, "cbf_qp",
      [](const Team& team, const Horizon&, const ViewTask& task, const ViewBarrierOptions& options) {
        return std::make_unique<ViewBarrierLaw>(team, task, options);
      });
  add_law<VisualServoOptions>(
      registry, "visual_servo",
      [](const Team& team, const Horizon&, const ViewTask& task, const VisualServoOptions& options) {
        return std::make_unique<VisualServoLaw>(team, task, options);
      });
  add_law<PerceptionOptions>(
      registry, "pampc",
      [](const Team& team, const Horizon& horizon, const ViewTask& task, const PerceptionOptions& options) {
        return std::make_unique<PerceptionLaw>(team, horizon, task, options);
      });
  add_law<BarrierMpcOptions>(
      registry, "cbf_mpc",
      [](const Team& team, const Horizon& horizon, const ViewTask& task, const BarrierMpcOptions& options) {
        return std::make_unique<BarrierMpcLaw>(team, horizon, task, options);
      });
  registry.solvers.add<ProcessOptions>(
      "process", {}, [command](const Team& team, const Horizon& horizon, const ProcessOptions& options) {
        const std::vector<ViewTask> tasks = view_tasks(team);
        return std::make_unique<ObserverSolver>(
            "process", team, horizon, tasks,
            std::make_unique<ProcessControl>(team, horizon, tasks, command, options));
      });
}

}  // namespace sightline::benchmark
