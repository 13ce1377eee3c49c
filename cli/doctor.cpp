#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <thread>

#include "bridges/dds/fleet/bridge.hpp"
#include "bridges/dds/fleet/loop_timing.hpp"
#include "cli/arguments.hpp"
#include "cli/fleet.hpp"
#include "cli/output.hpp"
#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/base/sentence.hpp"

namespace sightline::cli {
namespace {

struct DoctorCommand {
  NamedScenario fleet;
  std::optional<double> seconds;
  bool watch = false, json = false;
};

using Json = nlohmann::ordered_json;
using DoctorTime = std::chrono::steady_clock;
constexpr std::chrono::milliseconds looks_each{300};
constexpr std::chrono::seconds shows_each{1};

/// Sleeps until the given time, or until the user requests to end.
void sleep_in_peace(DoctorTime::time_point until) {
  constexpr std::chrono::milliseconds nap{20};
  while (interrupts() == 0 && DoctorTime::now() < until)
    std::this_thread::sleep_for(std::min<DoctorTime::duration>(nap, until - DoctorTime::now()));
}

Json json_of(const Vec3<double>& p) { return Json::array({p.x, p.y, p.z}); }

Json json_of(const RobotPose& pose) {
  if (!pose.known) return {{"robot", pose.robot}, {"p", nullptr}};
  return {{"robot", pose.robot}, {"p", json_of(pose.p)}, {"heading", pose.heading}, {"age", pose.age}};
}

std::string json_of(const Scenario& scenario, const std::vector<Finding>& findings,
                    const std::vector<RobotPose>& poses, const LoopTiming& timing, double seconds) {
  Json all = {{"fleet", scenario.name}, {"seconds", seconds}, {"light", to_string(worst(findings))}};
  all["findings"] = Json::array();
  for (const Finding& finding : findings)
    all["findings"].push_back({{"robot", finding.robot.empty() ? Json(nullptr) : Json(finding.robot)},
                               {"aspect", to_string(finding.aspect)},
                               {"light", to_string(finding.light)},
                               {"keeps_grounded", keeps_grounded(finding.aspect)},
                               {"sentence", finding.sentence}});
  all["poses"] = Json::array();
  for (const RobotPose& pose : poses) all["poses"].push_back(json_of(pose));
  all["timing"] = {{"period", timing.period},         {"periods", timing.periods},
                   {"missed", timing.missed},         {"update_median", timing.update_median},
                   {"update_p99", timing.update_p99}, {"update_most", timing.update_most},
                   {"wake_p99", timing.wake_p99},     {"fifo", timing.realtime.first_come},
                   {"locked", timing.realtime.locked}};
  return json_text(all, 2) + "\n";
}

std::string in_sum(const std::vector<Finding>& findings) {
  const auto count = [&](auto&& counts) { return std::count_if(findings.begin(), findings.end(), counts); };
  const auto red = count([](const Finding& f) { return f.light == Light::red; });
  const auto unknown = count([](const Finding& f) { return f.light == Light::unknown; });
  const auto grounding =
      count([](const Finding& f) { return f.light == Light::red && keeps_grounded(f.aspect); });
  const std::string known = unknown == 0 ? "" : fmt::format(", {} unknown", unknown);
  if (red == 0)
    return fmt::format("{}{}: sightline fly would arm this fleet", unknown == 0 ? "all green" : "none is red",
                       known);
  return fmt::format("{} red{}: sightline fly {} this fleet", red, known,
                     grounding > 0 ? "refuses" : "would arm");
}

/// Prints once a second the position of each robot, and its distance from its first position.
int watch_poses(FleetDoctor& fleet, const DoctorCommand& command) {
  std::vector<std::optional<Vec3<double>>> first;
  std::size_t width = 5;
  const DoctorTime::time_point begin = DoctorTime::now();
  // Discovery takes time: the first line comes one period later.
  DoctorTime::time_point next = begin + shows_each;
  const DoctorTime::time_point end =
      begin + std::chrono::duration_cast<DoctorTime::duration>(
                  std::chrono::duration<double>(std::min(command.seconds.value_or(1e8), 1e8)));
  for (bool headed = command.json; interrupts() == 0 && next <= end; next += shows_each) {
    sleep_in_peace(next);
    const std::vector<RobotPose> poses = fleet.poses();
    first.resize(poses.size());
    for (const RobotPose& pose : poses) width = std::max(width, pose.robot.size());
    if (!headed)
      print("{:{}}  {:26}  {:26}  {}\n", "robot", width, "in G [m]", "moved since the start [m]",
            "heading [deg]");
    headed = true;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const RobotPose& pose = poses[i];
      if (pose.known && !first[i]) first[i] = pose.p;
      const Vec3<double> moved = first[i] ? pose.p - *first[i] : Vec3<double>{};
      if (command.json) {
        Json line = json_of(pose);
        line["moved"] = pose.known ? json_of(moved) : Json(nullptr);
        print("{}\n", json_text(line));
      } else if (pose.known) {
        const auto of = [](const Vec3<double>& p) {
          const auto rounded = [](double x) { return std::round(100 * x) / 100 + 0.0; };  // no -0.00
          return fmt::format("[{:7.2f}, {:7.2f}, {:7.2f}]", rounded(p.x), rounded(p.y), rounded(p.z));
        };
        print("{:{}}  {:26}  {:26}  {:.0f}\n", pose.robot, width, of(pose.p), of(moved),
              180 / std::numbers::pi * pose.heading);
      } else {
        print("{:{}}  nothing came from it\n", pose.robot, width);
      }
    }
  }
  return 0;
}

int doctor(const DoctorCommand& command, const Registry& registry) {
  Scenario scenario;
  std::unique_ptr<FleetDoctor> fleet;
  try {
    scenario = read_fleet(command.fleet, registry);
    fleet = registry.bridge->examine(scenario);
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }
  listen_to_interrupts();
  if (command.watch) return watch_poses(*fleet, command);

  const double seconds = command.seconds.value_or(10.0);
  if (!command.json)
    print_sentence(fmt::format("listens for {:g} s, and times its own loop meanwhile", seconds));
  LoopTiming timing;
  std::vector<Finding> findings;
  try {
    std::future<LoopTiming> timed =
        run_for_value([&] { return time_loop(scenario, seconds, &stop_flight()); });
    // Each call requests what has not been answered yet.
    while (timed.wait_for(looks_each) != std::future_status::ready) (void)fleet->findings();
    timing = timed.get();
    findings = fleet->findings();
  } catch (const std::invalid_argument& error) {
    print_message("{}: {}\n", command.fleet.file.native(), error.what());
    return 2;
  }
  for (Finding& finding : tag_findings(scenario)) findings.push_back(std::move(finding));
  findings.push_back(timing.finding());
  if (command.json)
    print("{}", json_of(scenario, findings, fleet->poses(), timing, seconds));
  else
    print("{}\n{}\n", findings_table(findings, ::isatty(STDOUT_FILENO) == 1), in_sum(findings));
  return worst(findings) == Light::red ? 1 : 0;
}

}  // namespace

Execute describe_doctor(CLI::App& app) {
  const auto command = std::make_shared<DoctorCommand>();
  app.description("Look at a fleet before a flight: green or red, a sentence each");
  add_fleet(app, command->fleet);
  app.add_option("--seconds", command->seconds, "How long it listens [s] [10]")
      ->check(CLI::Range(1.0, 3600.0));
  app.add_flag("--watch", command->watch, "Print where each robot is, once a second, until Ctrl-C");
  app.add_flag("--json", command->json, "JSON instead of a table");
  return [command](const Registry& registry, char**) { return doctor(*command, registry); };
}

}  // namespace sightline::cli
