#include "benchmark/controllers/observer_solver.hpp"

#include <algorithm>
#include <utility>

namespace sightline::benchmark {

SeparateLaws::SeparateLaws(const Team& team, std::vector<ViewTask> tasks,
                           std::vector<std::unique_ptr<ViewLaw>> laws)
    : team_(team), tasks_(std::move(tasks)), laws_(std::move(laws)), resting_(resting_inputs(team)) {
  std::size_t most = 0;
  for (const ViewTask& task : tasks_) most = std::max(most, 1 + task.others.size());
  bodies_.resize(most);
}

Status SeparateLaws::inputs(double /*time*/, std::span<const double> states, std::span<double> u) noexcept {
  const auto sight = [&](BodyId body) {
    const double* inputs =
        team_.is_agent(body) ? resting_.data() + team_.input_offset(body) : resting_.data();
    return team_.model(body).sight(states.data() + team_.state_offset(body), inputs);
  };
  Status worst = Status::converged;
  for (std::size_t i = 0; i < tasks_.size(); ++i) {
    const ViewTask& task = tasks_[i];
    bodies_[0] = sight(task.target);
    for (std::size_t k = 0; k < task.others.size(); ++k) bodies_[k + 1] = sight(task.others[k].body);
    const std::span<double> own =
        u.subspan(at(team_.input_offset(task.robot)), at(team_.model(task.robot).nu()));
    worst = std::max(worst, laws_[i]->inputs(states.data() + team_.state_offset(task.robot),
                                             std::span(bodies_).first(1 + task.others.size()), own));
  }
  return worst;
}

void SeparateLaws::restart() noexcept {
  for (const auto& law : laws_) law->restart();
}

ObserverSolver::ObserverSolver(std::string name, const Team& team, const Horizon& horizon,
                               const std::vector<ViewTask>& tasks, std::unique_ptr<ObserverControl> control)
    : name_(std::move(name)),
      ocp_(team, horizon),
      rest_(without_observers(team, tasks), horizon),
      control_(std::move(control)),
      u_(resting_inputs(team)),
      raw_u_(u_),
      wanted_(u_),
      offset_(u_.size()),
      u_min_(u_.size()),
      u_max_(u_.size()) {
  for (const ViewTask& task : tasks) observers_.push_back(task.robot);
}

template <class Each>
void ObserverSolver::each_observer(Each each) const noexcept {
  for (const AgentId id : observers_) {
    const Agent& agent = ocp_.team().agent(id);
    each(agent, at(ocp_.team().input_offset(id)), at(agent.model.nu()));
  }
}

Solution ObserverSolver::solve(double time, std::span<const double> states) noexcept {
  const Solution of_rest = rest_.solve(time, states);
  Solution solution{.u = u_, .raw_u = raw_u_, .x = {}, .status = of_rest.status};
  solution.elapsed = of_rest.elapsed;
  if (of_rest.status == Status::invalid_state) return solution;

  std::copy(u_.begin(), u_.end(), wanted_.begin());
  Status of_observers = control_->inputs(time, states, wanted_);
  each_observer([&](const Agent&, std::size_t first, std::size_t n) {
    if (!all_finite(std::span(wanted_).subspan(first, n))) of_observers = Status::not_finite;
  });
  if (!gives_plan(of_observers)) std::copy(u_.begin(), u_.end(), wanted_.begin());
  solution.status = std::max(of_rest.status, of_observers);

  // The other robots as planned, the observers within their limits.
  std::copy(of_rest.u.begin(), of_rest.u.end(), u_.begin());
  std::copy(of_rest.raw_u.begin(), of_rest.raw_u.end(), raw_u_.begin());
  each_observer([&](const Agent& agent, std::size_t first, std::size_t n) {
    const std::span<double> low = std::span(u_min_).subspan(first, n),
                            high = std::span(u_max_).subspan(first, n);
    agent.limits.at(time, low, high);
    for (std::size_t i = first; i < first + n; ++i) {
      raw_u_[i] = wanted_[i];
      u_[i] = std::clamp(wanted_[i], u_min_[i] - offset_[i], u_max_[i] - offset_[i]);
    }
  });
  return solution;
}

void ObserverSolver::set_applied(const AppliedInputs& applied) noexcept {
  rest_.set_applied(applied);
  if (applied.offset.size() == offset_.size())
    std::copy(applied.offset.begin(), applied.offset.end(), offset_.begin());
  else
    std::fill(offset_.begin(), offset_.end(), 0.0);
}

void ObserverSolver::planned(double time, std::span<double> u) const noexcept {
  if (u.size() != u_.size()) return;
  rest_.planned(time, u);
  each_observer([&](const Agent&, std::size_t first, std::size_t n) {
    std::copy_n(u_.begin() + static_cast<std::ptrdiff_t>(first), n,
                u.begin() + static_cast<std::ptrdiff_t>(first));
  });
}

void ObserverSolver::restart() noexcept {
  rest_.restart();
  control_->restart();
  each_observer([&](const Agent& agent, std::size_t first, std::size_t) {
    std::copy(agent.u_ref.begin(), agent.u_ref.end(), u_.begin() + static_cast<std::ptrdiff_t>(first));
  });
}

}  // namespace sightline::benchmark
