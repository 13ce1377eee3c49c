#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/log.hpp"
#include "sightline/record/tuned_log.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/renamed.hpp"

namespace sightline {

namespace {

constexpr std::array<std::string_view, 21> estimate_words = {
    "known",      "stamp",      "p.x",        "p.y",        "p.z",        "v.x",        "v.y",
    "v.z",        "heading",    "yaw_rate",   "accepted",   "covariance", "covariance", "covariance",
    "covariance", "covariance", "covariance", "covariance", "covariance", "covariance", "covariance"};

/// All logged numbers of an estimate.
std::array<double, estimate_words.size()> numbers_of_estimate(const PoseEstimate& e) noexcept {
  std::array<double, estimate_words.size()> all{};
  if (!e.known) return all;
  std::size_t place = 0;
  for (const double v :
       {1.0, e.stamp, e.p.x, e.p.y, e.p.z, e.v.x, e.v.y, e.v.z, e.psi, e.yaw_rate, e.last_accepted})
    all[place++] = v;
  for (const double v : upper_triangle(e.P)) all[place++] = v;
  return all;
}

/// True if an assignment sets the solver.
bool sets_solver(const std::vector<std::string>& assignments) {
  return std::any_of(assignments.begin(), assignments.end(), [](std::string_view assignment) {
    const std::string_view key = assignment.substr(0, assignment.find_first_of(".= "));
    return key == "solver";
  });
}

/// The signals by which events of a flight occurred, at the times at which they did. Other signals
/// had no effect.
std::vector<TimedSignal> signals_in(const std::filesystem::path& log, const Script& script) {
  std::vector<TimedSignal> signals;
  const auto awaits = [](const TeamEvent& event) { return std::holds_alternative<Signal>(event.trigger); };
  if (std::none_of(script.events.begin(), script.events.end(), awaits)) return signals;
  LogText event;
  McapReader mcap(log);
  const auto take = [&](const McapMessage& message) {
    if (message.topic != "/events") return;
    event.read({reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()});
    if (event.word("kind") != to_string(EventKind::event_occurred)) return;
    const double number = event.number("value");
    if (!(number >= 0 && number < static_cast<double>(script.events.size()))) return;
    const Trigger& trigger = script.events[static_cast<std::size_t>(number)].trigger;
    if (const auto* const signal = std::get_if<Signal>(&trigger); signal != nullptr)
      signals.push_back({event.number("time"), signal->name});
  };
  try {
    mcap.visit(take);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{} cannot be replayed: {}", log.string(), error.what()));
  }
  if (!mcap.ok()) throw std::runtime_error(mcap.error());
  return signals;
}

}  // namespace

FlownAs flown_as(const std::filesystem::path& log) {
  const McapReader mcap(log);
  if (!mcap.ok()) throw std::runtime_error(mcap.error());
  const auto found = mcap.metadata().find("sightline");
  if (found == mcap.metadata().end())
    throw std::runtime_error(
        fmt::format("{} is no log of a run, expected the words \"sightline\"", log.string()));
  const McapWords& words = found->second;
  const auto word = [&](const char* key) {
    const auto at = words.find(key);
    return at != words.end() ? at->second : std::string();
  };
  FlownAs flown{.name = word("name"),
                .text = word("scenario"),
                .solver = word("solver"),
                .version = word("version"),
                .compiler = word("compiler"),
                .partition = word("partition"),
                .order = word("order")};
  if (const auto files = mcap.metadata().find("files"); files != mcap.metadata().end())
    flown.files.insert(files->second.begin(), files->second.end());
  if (words.contains(TunedLog::word)) flown.text += tuned_events(log);
  // Logs of versions before 0.2 use the names of that time.
  if (!flown.text.empty()) flown.text = with_present_names(flown.text, log.native()).text;
  const std::string exchanges = word("exchanges");
  if (!exchanges.empty() &&
      std::from_chars(exchanges.data(), exchanges.data() + exchanges.size(), flown.exchanges).ec !=
          std::errc()) {
    throw std::runtime_error(
        fmt::format("{}: exchanges = \"{}\", expected a number", log.string(), exchanges));
  }
  return flown;
}

CommandComparison::CommandComparison(const RecordedFlight& flight, Sample prototype)
    : flight_(flight), sample_(std::move(prototype)) {
  const Team& team = flight.team();
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    if (team.is_agent(body))
      robots_.push_back({body, size(team.input_offset(body)), size(team.model(body).nu())});
  }
}

void CommandComparison::compare_estimates(const RecordedPeriod& recorded) noexcept {
  for (std::size_t i = 0; i < sample_.estimates.size(); ++i) {
    const PoseEstimate& replayed = sample_.estimates[i];
    const BodyId body{static_cast<int>(i)};
    const auto found = std::find_if(recorded.estimates.begin(), recorded.estimates.end(),
                                    [&](const RecordedPeriod::Localized& one) { return one.robot == body; });
    const bool known = found != recorded.estimates.end();
    if (!known && !replayed.known) continue;
    ++estimates_;
    const auto then = numbers_of_estimate(known ? found->estimate : PoseEstimate{}),
               now = numbers_of_estimate(replayed);
    for (std::size_t k = 0; k < now.size(); ++k) {
      if (std::bit_cast<std::uint64_t>(now[k]) == std::bit_cast<std::uint64_t>(then[k])) continue;
      ++differing_estimates_;
      if (!first_estimate_) first_estimate_ = {updates_, body, k, then[k], now[k]};
      break;
    }
  }
}

void CommandComparison::publish() noexcept {
  const RecordedPeriod& recorded = flight_.periods()[std::min(updates_, flight_.periods().size() - 1)];
  for (std::size_t r = 0; r < robots_.size(); ++r) {
    Robot& robot = robots_[r];
    bool differs = false;
    for (std::size_t i = 0; i < robot.nu; ++i) {
      const double now = sample_.u[robot.u + i], then = recorded.u[robot.u + i];
      if (std::bit_cast<std::uint64_t>(now) == std::bit_cast<std::uint64_t>(then)) continue;
      differs = true;
      if (!first_) first_ = {updates_, r, i, now};
      const double by = std::abs(now - then);
      robot.squares += by * by;
      if (by > robot.largest) robot.largest = by, robot.largest_at = sample_.time;
    }
    robot.differing += differs ? 1 : 0;
  }
  compare_estimates(recorded);
  const std::size_t solvers = std::min(recorded.status.size(), sample_.solvers.size());
  for (std::size_t c = 0; c < solvers; ++c) {
    if (recorded.status[c] == sample_.solvers[c].status) continue;
    ++other_status_;
    break;
  }
  ++updates_;
}

std::int64_t CommandComparison::commands() const noexcept {
  return updates() * static_cast<std::int64_t>(robots_.size());
}

std::int64_t CommandComparison::differing() const noexcept {
  std::int64_t sum = 0;
  for (const Robot& robot : robots_) sum += robot.differing;
  return sum;
}

std::optional<FirstDifference> CommandComparison::first() const {
  if (!first_) return std::nullopt;
  const RecordedPeriod& period = flight_.periods()[first_->update];
  const Robot& robot = robots_[first_->robot];
  const Team& team = flight_.team();
  return FirstDifference{.update = flight_.number(period.time),
                         .time = period.time,
                         .robot = std::string(team.name(robot.body)),
                         .input = std::string(team.model(robot.body).inputs()[first_->input]),
                         .recorded = period.u[robot.u + first_->input],
                         .replayed = first_->replayed};
}

std::optional<FirstEstimate> CommandComparison::first_estimate() const {
  if (!first_estimate_) return std::nullopt;
  const RecordedPeriod& period = flight_.periods()[first_estimate_->update];
  return FirstEstimate{.update = flight_.number(period.time),
                       .time = period.time,
                       .robot = std::string(flight_.team().name(first_estimate_->robot)),
                       .what = std::string(estimate_words[first_estimate_->what]),
                       .recorded = first_estimate_->recorded,
                       .replayed = first_estimate_->replayed};
}

std::vector<RobotDifference> CommandComparison::robots() const {
  std::vector<RobotDifference> list;
  for (const Robot& robot : robots_) {
    const double inputs = static_cast<double>(std::max<std::size_t>(1, updates_ * robot.nu));
    list.push_back({.name = std::string(flight_.team().name(robot.body)),
                    .differing = robot.differing,
                    .largest = robot.largest,
                    .rms = std::sqrt(robot.squares / inputs),
                    .largest_at = robot.largest_at});
  }
  return list;
}

Scenario flown_scenario(const FlownAs& flown, const std::filesystem::path& log, const Registry& registry,
                        const std::optional<std::string>& solver, const std::vector<std::string>& set) {
  Scenario scenario = parse_scenario(flown.text, log, registry, {.files = flown.files, .set = set});
  scenario.name = flown.name;
  std::vector<TimedSignal> signals = signals_in(log, scenario.script);
  std::move(signals.begin(), signals.end(), std::back_inserter(scenario.simulation.signals));
  if (plans_apart(scenario))
    throw std::invalid_argument(fmt::format(
        "{}: flown by part {}, whose commands follow from messages of other parts, which are not in "
        "the log, expected a flight that one program planned",
        log.native(), scenario.partition->part));
  const bool in_parts = !flown.partition.empty() || (scenario.partition && scenario.partition->part.empty());
  if (solver) {
    if (*solver != scenario.solver.name) scenario.solver = solver_named(*solver, registry);
  } else if (!in_parts && flown.solver != scenario.solver.name && !sets_solver(set)) {
    scenario.solver = solver_named(flown.solver, registry);
  }
  lift_deadline(scenario.solver);
  scenario.simulation.compare.clear();
  check_solvers(scenario);
  return scenario;
}

std::string comparison_json(const CommandComparison& compared, const Scenario& scenario,
                            const RecordedFlight& flight) {
  nlohmann::ordered_json json = {{"scenario", scenario.name},
                                 {"solver", scenario.solver.name},
                                 {"updates", compared.updates()},
                                 {"commands", compared.commands()},
                                 {"differing", compared.differing()},
                                 {"other_status", compared.other_status()},
                                 {"complete", !flight.truncated() && !flight.lost_after()}};
  const auto first = compared.first();
  json["first"] = !first
                      ? nlohmann::ordered_json()
                      : nlohmann::ordered_json{{"update", first->update},     {"time", first->time},
                                               {"robot", first->robot},       {"input", first->input},
                                               {"recorded", first->recorded}, {"replayed", first->replayed}};
  if (compared.estimates() > 0) {
    const auto estimate = compared.first_estimate();
    json["estimates"] = {{"compared", compared.estimates()}, {"differing", compared.differing_estimates()}};
    json["estimates"]["first"] =
        !estimate
            ? nlohmann::ordered_json()
            : nlohmann::ordered_json{{"update", estimate->update},     {"time", estimate->time},
                                     {"robot", estimate->robot},       {"what", estimate->what},
                                     {"recorded", estimate->recorded}, {"replayed", estimate->replayed}};
  }
  json["robots"] = nlohmann::ordered_json::array();
  for (const RobotDifference& robot : compared.robots()) {
    json["robots"].push_back({{"name", robot.name},
                              {"differing", robot.differing},
                              {"largest", robot.largest},
                              {"largest_at", robot.largest_at},
                              {"rms", robot.rms}});
  }
  return json_text(json, 2);
}

}  // namespace sightline
