// Random flights over links in which the team changes: robots join, leave, hold and land. Targets,
// references, weights and limits change, and a person tunes. In some a vehicle has a fault.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "sightline/log.hpp"
#include "sightline/scenario/starts.hpp"
#include "sightline/server/tuner.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/child.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/replayed_flight.hpp"

namespace sightline::dds {
namespace {

constexpr double task_duration = 17.0;   // [s]
constexpr double settled_before = 3.0;   // from the last change to the end of the task [s]
constexpr double campaign_d_hard = 0.6;  // [m]
constexpr double conflict_counts = 3.0;  // after it nothing is promised so long [s]
constexpr double campaign_alpha = 0.5;   // of the observer's view [rad]
constexpr double angle_doubt = 0.05;     // nearer to alpha neither verdict is judged [rad]
constexpr int flights_of_block = 8, flights_at_once = 2;

/// What happens to a flight from outside, at a time of its task [s].
struct FromOutside {
  double at;
  std::string what;  // name of a signal, or the change that a person tunes
};

struct DrawnFault {
  std::size_t robot;
  Kind kind;
  double at;  // [s]
};

struct DrawnFlight {
  std::string text;
  std::size_t robots = 0, contradictions = 0;  // events that must be ignored
  std::vector<FromOutside> signals{}, tuned{};
  std::optional<DrawnFault> fault{};
  std::size_t target = 0;  // that uav1 observes at the end
};

/// Draws flights whose events are possible in their order, but for those that contradict it.
class FlightDraw {
 public:
  FlightDraw(int seed, int domain) : random_(static_cast<unsigned>(seed)) {
    flight_.robots = static_cast<std::size_t>(whole(2, 8));
    absent_from_ = flight_.robots - static_cast<std::size_t>(whole(0, flight_.robots > 2 ? 2 : 1));
    for (std::size_t i = 0; i < flight_.robots; ++i) team_.push_back(i < absent_from_ ? in_team : absent);
    add("[fleet]\ndomain = {}\n[world]\nkind = \"model\"\n[safety]\nbarrier = \"on\"\nd_hard = {}\nfloor = "
        "0.2\n"
        "position_sigma = 0.01\nheading_sigma = 0.01\n[safety.supervisor]\nfresh = 0.05\n"
        "[simulation]\nduration = {}\n",
        domain, campaign_d_hard, task_duration);
    for (std::size_t i = 0; i < flight_.robots; ++i) add_robot(i);
    add("[[couple]]\nname = \"apart\"\npotential = {{ too_near = {{ d_min = 1.0, kappa = 10.0 }} }}\n"
        "between = [\"uav0\", \"uav{0}\"]\nfelt_by = [\"uav0\"]\nweight = 4.0\n"
        "[[couple]]\nname = \"view\"\npotential = {{ bearing = {{ alpha = {1} }} }}\n"
        "between = [\"uav1\", \"uav0\"]\nfelt_by = [\"uav1\"]\n",
        flight_.robots - 1, campaign_alpha);
    double t = real(0.3, 1.0);
    while (t < task_duration - settled_before) {
      add_event(t);
      t += real(0.3, 3.0);
    }
    for (t = real(0.5, 6.0); t < task_duration - settled_before; t += real(2.0, 8.0)) tune(t);
    if (chance(0.4)) {
      constexpr std::array kinds = {
          Kind::silent,       Kind::disarm, Kind::pilot,    Kind::battery_low, Kind::estimator_invalid,
          Kind::request_lost, Kind::drop,   Kind::duplicate};
      flight_.fault = {static_cast<std::size_t>(whole(0, static_cast<int>(flight_.robots) - 1)),
                       kinds.at(static_cast<std::size_t>(whole(0, static_cast<int>(kinds.size()) - 1))),
                       real(0.3, task_duration - 4.0)};
    }
    for (const FromOutside& signal : flight_.signals)
      add("[[simulation.signal]]\nname = \"{}\"\n", signal.what);
  }

  const DrawnFlight& flight() const { return flight_; }

 private:
  enum Place { absent, in_team, holding, gone };

  bool chance(double p) { return std::uniform_real_distribution<>(0, 1)(random_) < p; }
  double real(double low, double high) { return std::uniform_real_distribution<>(low, high)(random_); }
  int whole(int low, int high) { return std::uniform_int_distribution<>(low, high)(random_); }
  template <class... Args>
  void add(fmt::format_string<Args...> words, Args&&... args) {
    flight_.text += fmt::format(words, std::forward<Args>(args)...);
  }
  static double x(std::size_t i) { return 2.0 * static_cast<double>(i % 4); }
  static double y(std::size_t i) { return 2.0 * static_cast<double>(i / 4); }
  std::string circle(std::size_t i) {
    return fmt::format("{{ circle = {{ centre = [{}, {}, {:.2f}], radius = {:.2f}, rate = {:.2f} }} }}", x(i),
                       y(i), real(0.7, 0.9), real(0.1, 0.9), chance(0.5) ? real(0.3, 0.8) : real(-0.8, -0.3));
  }
  void add_robot(std::size_t i) {
    add("[agent.uav{0}]\nrobot = \"multirotor\"\nstart = {{ p = [{1}, {2}, 0.6], heading = {3:.2f} }}\n"
        "Q = [1.5, 1.5, 1.6, 0, 0, 0, 0]\nreference = {4}\n{5}",
        i, x(i), y(i), real(-3.0, 3.0), circle(i), team_[i] == absent ? "present = false\n" : "");
    if (i == 1) add("sensor = {{ pitch = 0.0 }}\n");
    add("[agent.uav{0}.link]\nkind = \"px4\"\nrelease = \"1.{1}\"\nnamespace = \"/px4_{0}\"\n"
        "origin = {{ p = [{2}, {3}, 0.2], heading = {4:.2f} }}\n",
        i, whole(14, 18), x(i), y(i) + 0.1, real(-3.0, 3.0));
  }
  /// A robot at one of these places and not below `from`; empty: none.
  std::optional<std::size_t> robot_at(std::initializer_list<Place> places, std::size_t from) {
    std::vector<std::size_t> all;
    for (std::size_t i = from; i < team_.size(); ++i)
      if (std::find(places.begin(), places.end(), team_[i]) != places.end()) all.push_back(i);
    if (all.empty()) return std::nullopt;
    return all[static_cast<std::size_t>(whole(0, static_cast<int>(all.size()) - 1))];
  }
  /// The changes of one event; empty: this kind is not possible now.
  std::string change(double t, bool& by_signal) {
    const double kind = real(0.0, 1.0);
    // A take-off for a signal takes 8 s.
    if (kind < 0.25) {
      const auto held = robot_at({holding}, 2), joins = robot_at({absent}, 0);
      if (held && chance(0.5)) return team_[*held] = in_team, fmt::format("add = \"uav{}\"\n", *held);
      if (!joins || t > 6.0) return {};
      return team_[*joins] = in_team, fmt::format("add = \"uav{}\"\n", *joins);
    }
    if (kind < 0.5) {
      const auto leaves = robot_at({in_team}, 2);
      if (!leaves || *leaves == flight_.target) return {};
      constexpr std::array<std::string_view, 3> ways = {"vanish", "land", "hold"};
      const auto way = static_cast<std::size_t>(whole(0, 2));
      team_[*leaves] = ways.at(way) == "hold" ? holding : gone;
      if (way == 0) return fmt::format("remove = \"uav{}\"\n", *leaves);
      return fmt::format("remove = {{ agent = \"uav{}\", then = \"{}\" }}\n", *leaves, ways.at(way));
    }
    if (kind < 0.6) {
      const auto target = robot_at({in_team, holding}, 0);
      // It must see the target at the end, after a turn by up to pi.
      if (t > 9.0 || team_[1] != in_team || !target || *target == 1 || *target == flight_.target) return {};
      flight_.target = *target;
      return fmt::format("observe = {{ observer = \"uav1\", target = \"uav{}\" }}\n", *target);
    }
    if (kind < 0.65) {
      const auto left = robot_at({gone}, 2);
      if (!left) return {};
      by_signal = true;  // with a time the file is refused
      ++flight_.contradictions;
      return fmt::format("remove = {{ agent = \"uav{}\", then = \"hold\" }}\n", *left);
    }
    const auto robot = robot_at({in_team, holding, absent}, 0);
    if (kind < 0.75)
      return fmt::format("reference = {{ agent = \"uav{}\", reference = {} }}\n", *robot, circle(*robot));
    if (kind < 0.85)
      return fmt::format(
          "retune = {{ agent = \"uav{0}\", Q = [{1:.2f}, {1:.2f}, 1.6, 0, 0, 0, 0], R = [2, 2, 1, 1] }}\n",
          *robot, real(0.5, 3.0));
    const double most = real(0.7, 1.0);
    if (kind < 0.93)
      return fmt::format(
          "retune = {{ agent = \"uav{0}\", u_min = [-{1:.2f}, -{1:.2f}, -{1:.2f}, -1.0], u_max = [{1:.2f}, "
          "{1:.2f}, "
          "{1:.2f}, 1.0] }}\n",
          *robot, most);
    return fmt::format("retune = {{ couple = \"apart\", weight = {:.2f} }}\nramp = 0.5\n", real(1.0, 6.0));
  }
  void add_event(double t) {
    bool by_signal = chance(0.3);
    const std::string what = change(t, by_signal);
    if (what.empty()) return;
    const std::string signal = fmt::format("go{}", flight_.signals.size());
    if (by_signal) flight_.signals.push_back({t, signal});
    add("[[event]]\n{}{}",
        by_signal ? fmt::format("signal = \"{}\"\n", signal) : fmt::format("at = {:.2f}\n", t), what);
  }
  void tune(double t) {
    if (chance(0.5))
      flight_.tuned.push_back(
          {t, fmt::format(R"({{"retune": {{"couple": "view", "weight": {:.2f}}}}})", real(0.5, 2.0))});
    else
      flight_.tuned.push_back(
          {t, fmt::format(
                  R"({{"reference": {{"agent": "uav0", "reference": {{"circle": {{"centre": [0, 0, 0.8], )"
                  R"("radius": {:.2f}, "rate": 0.5}}}}}}}})",
                  real(0.1, 0.9))});
  }

  std::mt19937 random_;
  DrawnFlight flight_;
  std::size_t absent_from_ = 0;
  std::vector<Place> team_;
};

/// Measures the true distances and the view angle of each period, and keeps who was in the team.
class TruthSink final : public cli::WatchingSink {
 public:
  TruthSink(Sink<Sample>& to, Rig& rig, const DrawnFlight& drawn)
      : WatchingSink(to),
        rig_(rig),
        target_(drawn.target),
        presence_(drawn.robots, Presence::absent),
        conflict_at_(drawn.robots, -1e9),
        at_(drawn.robots) {}

  /// From now on nothing is promised of this robot.
  void fails(std::size_t robot) { failed_ = robot; }
  bool was_in_team(std::size_t robot) const { return in_team(presence_[robot]); }
  /// The least distance of two robots of which at least one has a barrier that promises it [m].
  double least() const { return least_; }
  std::string where() const {
    return fmt::format("{:.3f} m of uav{} and uav{} at {:.2f} s", least_, a_, b_, least_at_);
  }
  /// Least angle of the target off the sensor's axis in the last 2 s [rad]; infinity: none.
  double angle() const { return angle_; }

 private:
  static bool in_team(Presence presence) {
    return presence == Presence::steered || presence == Presence::hold;
  }

  void watch(const Sample& sample) noexcept override {
    for (std::size_t i = 0; i < at_.size(); ++i) {
      presence_[i] = sample.presence[i];
      at_[i] = rig_.vehicle(i).motion();
      if (sample.barriers[i].conflict) conflict_at_[i] = sample.time;
    }
    const auto promises = [&](std::size_t i) {
      return in_team(presence_[i]) && sample.time - conflict_at_[i] > conflict_counts;
    };
    for (std::size_t i = 0; i < at_.size(); ++i) {
      for (std::size_t j = i + 1; j < at_.size(); ++j) {
        const bool counts = (promises(i) || !in_team(presence_[i])) &&
                            (promises(j) || !in_team(presence_[j])) && (promises(i) || promises(j));
        const double d = norm(at_[i].p - at_[j].p);
        if (!counts || i == failed_ || j == failed_ || d >= least_) continue;
        least_ = d, a_ = i, b_ = j, least_at_ = sample.time;
      }
    }
    if (sample.time < task_duration - 2.0 || !in_team(presence_[1]) || !in_team(presence_[target_])) return;
    const Vec3<double> to = at_[target_].p - at_[1].p;
    const Vec2<double> d = heading(rotation(at_[1].q));
    angle_ = std::min(angle_, std::acos(std::clamp((d.x * to.x + d.y * to.y) / norm(to), -1.0, 1.0)));
  }

  Rig& rig_;
  std::size_t target_;
  std::vector<Presence> presence_;
  std::vector<double> conflict_at_;  // [s]
  std::vector<Motion> at_;
  std::atomic<std::size_t> failed_{std::numeric_limits<std::size_t>::max()};
  double least_ = std::numeric_limits<double>::infinity(), least_at_ = 0.0, angle_ = least_;
  std::size_t a_ = 0, b_ = 0;
};

/// A flight, and the promises that it broke.
class CampaignFlight {
 public:
  CampaignFlight(int seed, int domain)
      : drawn_(FlightDraw(seed, domain).flight()),
        folder_(fmt::format("changing_fleet_{}", seed)),
        rig_(tunable(drawn_.text)) {
    fly();
    judge_end();
    judge_events();
    judge_replay();
  }

  const std::vector<std::string>& broken() const { return broken_; }
  std::string report() const {
    return fmt::format("{}\n{}\n{}", drawn_.text, fmt::join(rig_.reported, "\n"),
                       fmt::join(flown_.faults, "\n"));
  }

 private:
  static Scenario tunable(const std::string& text) {
    Scenario scenario = test::scenario_of(text);
    make_tunable(scenario, TunedScript::Scope::team);
    lift_deadline(scenario.solver);
    return scenario;
  }
  template <class... Args>
  void promise(bool kept, fmt::format_string<Args...> words, Args&&... args) {
    if (!kept) broken_.push_back(fmt::format(words, std::forward<Args>(args)...));
  }

  void fly() {
    const Controls controls(rig_.scenario);
    SteadyClock clock;
    std::optional<cli::LinkedSink> linked;
    FlightOptions options{.world = rig_.world.get(),
                          .team_switcher = controls.team_switcher(),
                          .allocations = cli::allocations,
                          .stop = &rig_.stop};
    options.watched = [&](Sink<Sample>& log, const Sample&) -> Sink<Sample>& {
      watch_.emplace(log, rig_, drawn_);
      return linked.emplace(*watch_, *rig_.world, rig_.stop);
    };
    options.fly = [&](ClosedLoop& loop, Sink<Sample>& sink) {
      LoopOutcome outcome;
      if (rig_.take_off()) {
        std::atomic<bool> over{false};
        std::thread outside([&] { happen(*controls.team_switcher(), over); });
        outcome = loop.fly();
        over = true;
        outside.join();
        rig_.land();
      }
      sink.close();
      return outcome;
    };
    flown_ = fly_logged(rig_.scenario, folder_.path(), clock, controls.controllers(), options);
  }

  /// Signals, tuning and the fault, each at its time.
  void happen(TeamSwitcher& switcher, const std::atomic<bool>& over) {
    Tuner tuner(rig_.scenario);
    std::vector<std::pair<double, std::function<void(double)>>> all;
    for (const FromOutside& signal : drawn_.signals)
      all.emplace_back(signal.at, [&](double) {
        promise(switcher.signal(signal.what), "signal {} is unknown", signal.what);
      });
    for (const FromOutside& change : drawn_.tuned) {
      all.emplace_back(change.at, [&](double now) {
        try {
          tuner.change(Tuner::Json::parse(change.what), std::nan(""), now);
          ++tuned_;
        } catch (const std::exception& error) {
          promise(false, "{} is refused: {}", change.what, error.what());
        }
      });
    }
    if (drawn_.fault) {
      all.emplace_back(drawn_.fault->at, [&](double) {
        watch_->fails(drawn_.fault->robot);
        rig_.faults(drawn_.fault->robot).begin(drawn_.fault->kind);
      });
    }
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    const auto begin = std::chrono::steady_clock::now();
    for (const auto& [at, act] : all) {
      const auto then = begin + std::chrono::duration<double>(at);
      // Vehicles without heartbeats do not wait for the end of a sleep.
      while (!over && std::chrono::steady_clock::now() < then)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (over) return;
      act(at);
    }
  }

  /// The flight is whole unless a robot of the team failed. There is a sentence of this robot, and
  /// none of another. Every robot is down and disarmed, unless a pilot has it.
  void judge_end() {
    const LoopOutcome& outcome = flown_.outcome;
    const auto periods = std::llround(task_duration / rig_.scenario.horizon.dt);
    const bool whole = outcome.updates + outcome.missed == periods;
    const std::vector<std::string> faults = rig_.world->faults();
    promise(flown_.logged, "the log is not whole");
    promise(outcome.updates > 0, "it did not take off");
    promise(outcome.max_allocations == 0, "{} allocations in a period", outcome.max_allocations);
    if (!drawn_.fault) {
      promise(whole && outcome.finite && !outcome.stopped, "{} + {} of {} periods, finite {}, stopped {}",
              outcome.updates, outcome.missed, periods, outcome.finite, outcome.stopped);
      promise(faults.empty(), "{}", fmt::join(faults, "; "));
      judge_view();
    } else {
      const std::string robot = fmt::format("uav{}: ", drawn_.fault->robot);
      for (const std::string& fault : faults)
        promise(fault.starts_with(robot), "\"{}\" by a fault of {}", fault, robot);
      promise(whole || !faults.empty(), "{} + {} of {} periods without a sentence", outcome.updates,
              outcome.missed, periods);
      promise(whole || watch_->was_in_team(drawn_.fault->robot),
              "a robot that was not in the team ended the flight");
      const bool is_lasting = drawn_.fault->kind != Kind::request_lost && drawn_.fault->kind != Kind::drop &&
                              drawn_.fault->kind != Kind::duplicate;
      promise(!is_lasting || !whole || !watch_->was_in_team(drawn_.fault->robot),
              "a robot of the team failed, and the flight went on");
    }
    promise(watch_->least() >= campaign_d_hard, "{}", watch_->where());
    for (std::size_t i = 0; i < drawn_.robots; ++i) {
      const LinkState state = rig_.state(static_cast<int>(i));
      const bool of_pilot = drawn_.fault && drawn_.fault->robot == i && state == LinkState::pilot;
      promise(state == LinkState::done || of_pilot, "uav{} is {}", i, to_string(state));
      if (of_pilot) continue;
      promise(test::eventually([&] { return !rig_.vehicle(i).armed(); }, std::chrono::seconds(20)),
              "uav{} is armed", i);
      promise(rig_.vehicle(i).motion().p.z < 0.05, "uav{} is {} m high", i, rig_.vehicle(i).motion().p.z);
      if (drawn_.fault && drawn_.fault->robot == i) continue;  // its state may be unknown
      const Px4VehicleCounts n = rig_.counts_of(i);
      promise(n.setpoints_outside == 0 && n.bad_setpoints == 0, "uav{} received {} + {} bad set-points", i,
              n.setpoints_outside, n.bad_setpoints);
    }
  }

  /// Without a fault the flight fails exactly if the target was out of view during the last 2 s.
  void judge_view() {
    const double angle = watch_->angle();
    const bool sees = angle < campaign_alpha || std::isinf(angle);
    if (std::abs(angle - campaign_alpha) < angle_doubt) return;
    const std::string lost = fmt::format("uav1 has not seen uav{} since ", drawn_.target);
    promise(sees ? flown_.faults.empty() : flown_.faults.size() == 1 && flown_.faults[0].starts_with(lost),
            "the least angle is {:.3f} rad, and its faults are \"{}\"", angle,
            fmt::join(flown_.faults, "; "));
  }

  /// Each event that occurred takes effect, or is ignored with a sentence. Without a fault only
  /// those that contradict the order are ignored.
  void judge_events() {
    const Recording run = read_recording(folder_.path());
    std::map<std::string, std::map<int, int>> count;
    for (const Recording::Event& event : run.events)
      ++count[event.kind][static_cast<int>(std::lround(event.value))];
    const auto times_of = [&](const char* kind, int event) {
      const auto found = count[kind].find(event);
      return found != count[kind].end() ? found->second : 0;
    };
    // A robot with a fault may be in its take-off until the end.
    const bool may_wait =
        (drawn_.fault && is_absent_at_start(rig_.scenario, BodyId{static_cast<int>(drawn_.fault->robot)})) ||
        flown_.outcome.updates + flown_.outcome.missed <
            std::llround(task_duration / rig_.scenario.horizon.dt);
    const std::size_t script = rig_.scenario.script.events.size();
    for (const auto& [event, times] : count["event_happened"]) {
      const int answers = times_of("event_in_force", event) + times_of("event_ignored", event);
      promise(answers <= times && (may_wait || answers == times), "event {}: {} times, {} answers", event,
              times, answers);
    }
    if (drawn_.fault) return;
    promise(count["event_happened"].size() == script + tuned_, "{} of {} + {} events happened",
            count["event_happened"].size(), script, tuned_.load());
    promise(count["event_ignored"].size() == drawn_.contradictions, "{} events are ignored, expected {}",
            count["event_ignored"].size(), drawn_.contradictions);
    promise(count["robot_refused"].empty(), "a robot was refused");
  }

  void judge_replay() {
    if (flown_.outcome.updates == 0) return;
    const std::filesystem::path log = folder_.path() / "run.mcap";
    const Scenario again = flown_scenario(flown_as(log), log, with_links());
    RecordedFlight flight(log, again.team, again.x0, again.horizon.dt);
    const CommandComparison compared = test::replayed(again, flight);
    const std::optional<FirstDifference> first = compared.first();
    promise(compared.updates() == flown_.outcome.updates && compared.differing() == 0,
            "the replay has {} of {} periods, {} commands differ, first of {} at {} s", compared.updates(),
            flown_.outcome.updates, compared.differing(), first ? first->robot : "none",
            first ? first->time : 0.0);
  }

  DrawnFlight drawn_;
  test::Folder folder_;
  Rig rig_;
  std::optional<TruthSink> watch_;
  LoggedFlight flown_;
  std::atomic<std::size_t> tuned_{0};
  std::vector<std::string> broken_;
};

/// Blocks of flights; a whole campaign has 250.
class ChangingFleetCampaign : public testing::TestWithParam<int> {};

TEST_P(ChangingFleetCampaign, RandomFlightsKeepEachPromise) {
  std::array<int, flights_at_once> domains{};
  for (std::size_t lane = 0; lane < domains.size(); ++lane) domains.at(lane) = test::own_domain(lane);
  std::atomic<int> next{flights_of_block * GetParam()};
  const int end = next + (whole_campaign() ? flights_of_block : flights_of_block / 2);
  std::vector<std::thread> threads;
  for (const int domain : domains) {
    threads.emplace_back([&, domain] {
      for (int seed = next++; seed < end; seed = next++) {
        try {
          const CampaignFlight flight(seed, domain);
          if (flight.broken().empty()) continue;
          ADD_FAILURE() << fmt::format("flight {}: {}\n{}", seed, fmt::join(flight.broken(), "\n"),
                                       flight.report());
        } catch (const std::exception& error) {
          ADD_FAILURE() << fmt::format("flight {}: {}", seed, error.what());
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

INSTANTIATE_TEST_SUITE_P(Blocks, ChangingFleetCampaign, testing::Range(0, runs(250, 250)));

}  // namespace
}  // namespace sightline::dds
