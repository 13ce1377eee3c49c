#include "cli/partition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/base/quantile.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/read_partition.hpp"
#include "sightline/solver/distributed/partition_convergence.hpp"

namespace sightline::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t moments_max = 24;
constexpr std::size_t times_max = 1'000'000;
constexpr int exchanges_compared = 6;

/// Median and greatest value of one quantity over all moments, after a number of exchanges.
struct Spread {
  double median, greatest;
};
Spread spread(const std::vector<std::vector<FromOptimum>>& moments, int exchange,
              double FromOptimum::*number) {
  std::vector<double> sizes;
  for (const std::vector<FromOptimum>& s : moments) sizes.push_back(std::abs(s[at(exchange)].*number));
  return {quantile(sizes, 0.5), quantile(sizes, 1.0)};
}

Json as_json(const Spread& s) { return {{"median", s.median}, {"max", s.greatest}}; }

}  // namespace

PartitionChoice read_partition(const Scenario& scenario, const std::string& parts, const std::string& order,
                               int exchanges, int threads) {
  if (plans_apart(scenario))
    throw std::invalid_argument(
        fmt::format("--partition: partition.part = \"{}\" is planned alone, expected the whole team",
                    scenario.partition->part));
  try {
    check_plans_in_parts(scenario, registry_of(scenario));
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("--partition: {}", error.what()));
  }
  PartitionChoice choice{.text = parts,
                         .parts = sightline::read_partition(parts, scenario.team),
                         .order = exchange_order(order),
                         .exchanges = exchanges,
                         .threads = threads};
  for (const std::vector<AgentId>& part : choice.parts) (void)subteam_of(scenario.team, part);
  check_options(choice.options());
  return choice;
}

std::optional<PartitionChoice> partition_of(const Scenario& scenario, int threads) {
  if (!scenario.partition || !scenario.partition->part.empty()) return std::nullopt;
  return PartitionChoice{.parts = sightline::partition_of(*scenario.partition, scenario.team),
                         .order = ExchangeOrder::jacobi,
                         .messages = scenario.partition->exchange,
                         .threads = threads};
}

PartitionedFlight::PartitionedFlight(const Scenario& scenario, const PartitionChoice& choice)
    : choice_(choice),
      subteam_solver_(solver_named(scenario.solver.name, registry_of(scenario))),
      solver_(scenario.team, choice.parts, solver_maker(scenario.solver, scenario.horizon), choice.options()),
      moments_(moments_max) {
  const auto updates =
      static_cast<std::size_t>(std::llround(scenario.simulation.duration / scenario.horizon.dt));
  stride_ = std::max<std::size_t>(1, updates / moments_max);
  part_us_.reserve(std::min(updates, times_max));
  each_us_.resize(at(solver_.subteams()));
  for (std::vector<double>& of_part : each_us_)
    of_part.reserve(std::min(updates, times_max / each_us_.size()));
  for (PartSample& moment : moments_) {
    moment.states.resize(at(ocp().nx()));
    moment.plan.resize(at(ocp().nu()) * at(ocp().horizon().N));
  }
}

Solution PartitionedFlight::solve(double time, std::span<const double> states) noexcept {
  const bool due = updates_ > 0 && updates_ % stride_ == 0 && kept_ < moments_.size();
  if (due && states.size() == moments_[kept_].states.size()) {
    PartSample& moment = moments_[kept_++];
    const std::size_t nu = at(ocp().nu());
    moment.time = time;
    std::copy(states.begin(), states.end(), moment.states.begin());
    for (int k = 0; k < ocp().horizon().N; ++k)
      solver_.plan(k, std::span(moment.plan).subspan(at(k) * nu, nu));
  }
  ++updates_;
  const Solution solution = solver_.solve(time, states);
  if (part_us_.size() < part_us_.capacity()) part_us_.push_back(1e6 * solver_.slowest());
  for (std::size_t i = 0; i < each_us_.size(); ++i)
    if (each_us_[i].size() < each_us_[i].capacity())
      each_us_[i].push_back(1e6 * solver_.elapsed(static_cast<int>(i)));
  return solution;
}

std::string PartitionedFlight::print_message(const std::filesystem::path& folder, const std::string& summary,
                                             const std::string& whole) {
  std::vector<std::vector<FromOptimum>> moments;
  PartitionedSolver still(ocp().team(), choice_.parts, solver_maker(subteam_solver_, ocp().horizon()),
                          {.order = choice_.order});
  const std::unique_ptr<Solver> reference = make_reference_solver(ocp());
  for (std::size_t i = 0; i < kept_; ++i) {
    const PartSample& moment = moments_[i];
    const std::size_t nu = at(ocp().nu());
    still.restart();
    for (int k = 0; k < ocp().horizon().N; ++k)
      still.set_plan(k, std::span(moment.plan).subspan(at(k) * nu, nu));
    std::vector<FromOptimum> of_moment =
        partition_convergence(still, *reference, moment.time, moment.states, exchanges_compared);
    if (!of_moment.empty()) moments.push_back(std::move(of_moment));
  }

  Json json;
  for (const std::vector<AgentId>& part : choice_.parts) {
    Json names = Json::array();
    for (const AgentId agent : part) names.push_back(ocp().team().name(agent));
    json["parts"].push_back(std::move(names));
  }
  const double cost = Json::parse(summary).at("cost"), whole_cost = Json::parse(whole).at("cost");
  const double excess = (cost - whole_cost) / whole_cost;
  const int numbers = (ocp().horizon().N + 1) * sight_size;
  json["order"] = to_string(choice_.order);
  json["exchanges"] = choice_.exchanges;
  if (choice_.messages)
    json["messages"] = {{"delay", choice_.messages->delay},
                        {"jitter", choice_.messages->jitter},
                        {"loss", choice_.messages->loss},
                        {"offset", choice_.messages->offset},
                        {"stale_after", choice_.messages->stale_after}};
  json["cost"] = cost;
  json["whole_cost"] = whole_cost;
  json["cost_excess"] = excess;
  json["part_us"] = quantile(part_us_, 0.5);
  double p99 = 0.0;
  for (const std::vector<double>& of_part : each_us_) p99 = std::max(p99, quantile(of_part, 0.99));
  json["part_p99_us"] = p99;
  json["numbers_told"] = numbers;  // sent by a robot in an exchange
  json["moments"] = moments.size();
  json["sweeps"] = Json::array();

  std::string text = fmt::format("{} subteams, {} order, exchanges per update: {}\n", solver_.subteams(),
                                 to_string(choice_.order), choice_.exchanges);
  text += fmt::format("cost {:.6g} s, of the whole team's solver {:.6g} s: {:+.4f} %\n", cost, whole_cost,
                      100 * excess);
  text += fmt::format(
      "slowest subteam {:.1f} us per update, median, each within {:.1f} us in 99 %; a robot sends {} numbers "
      "per "
      "exchange\n",
      quantile(part_us_, 0.5), p99, numbers);
  if (moments.empty()) {
    text += "no moment of the flight has a stationary point to compare with\n";
  } else {
    text +=
        fmt::format("\nfrom the optimum of the whole team, at {} moments of the flight\n", moments.size());
    text +=
        "sweep   |u - u*| median       max    |J - J*|/J* median       max    residual [1/s] median       "
        "max\n";
  }
  for (int exchange = 0; exchange < exchanges_compared && !moments.empty(); ++exchange) {
    const Spread input = spread(moments, exchange, &FromOptimum::input),
                 price = spread(moments, exchange, &FromOptimum::cost),
                 kkt = spread(moments, exchange, &FromOptimum::kkt);
    json["sweeps"].push_back({{"sweep", exchange + 1},
                              {"input", as_json(input)},
                              {"cost", as_json(price)},
                              {"kkt", as_json(kkt)}});
    text += fmt::format("{:5}   {:15.2e}  {:8.2e}    {:18.2e}  {:8.2e}    {:21.2e}  {:8.2e}\n", exchange + 1,
                        input.median, input.greatest, price.median, price.greatest, kkt.median, kkt.greatest);
  }
  write_text(folder / "partition.json", json_text(json, 2) + "\n");
  return text;
}

}  // namespace sightline::cli
