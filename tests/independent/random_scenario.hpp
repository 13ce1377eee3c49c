/// Scenarios of every kind as text: what a seed draws is a file that can be flown by hand.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/independent/drawn_kinds.hpp"
#include "tests/support/random.hpp"

namespace sightline::test {

/// Lines of text with numbers that are drawn.
class DrawnLines {
 public:
  explicit DrawnLines(std::uint64_t seed) : random_(seed) {}

  const std::string& text() const { return text_; }

 protected:
  template <class... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
    text_ += '\n';
  }
  bool chance(double p) { return uniform(random_, 0, 1) < p; }
  std::size_t below(std::size_t n) { return std::size_t{random_()} % n; }
  template <class List>
  const auto& any(const List& list) {
    return list[below(std::size(list))];
  }
  double between(double low, double high) { return uniform(random_, low, high); }
  std::string number(double low, double high) { return fmt::format("{:.3f}", between(low, high)); }

  Random random_;
  std::string text_;
};

class RandomScenario : DrawnLines {
 public:
  /// The same seed and duration [s]: the same text.
  RandomScenario(std::uint64_t seed, double duration)
      : DrawnLines(0x9E3779B97F4A7C15U * (seed + 1)), duration_(duration) {
    line("# Seed {} of tests/independent/random_scenario.hpp", seed);
    draw_team();
    write_horizon();
    for (const Robot& robot : robots_) write_robot(robot);
    for (const Body& body : uncooperative_) write_uncooperative(body);
    write_couplings();
    write_shapes();
    write_alone();
    write_safety();
    write_events();
    write_simulation(seed);
    write_world_and_subteams();
  }

  using DrawnLines::text;

 private:
  struct Body {
    std::string name;
    Vec3<double> p;
    bool present = true;
  };
  struct Robot : Body {
    const DrawnKind* kind = nullptr;
    bool looks = false, tracks = false, limits_move = false, has_rates = false;
  };
  /// A coupling or constraint that events speak of.
  struct Term {
    std::string name;
    std::string_view key;
    std::size_t robot;
  };
  using Limits = std::pair<std::vector<double>, std::vector<double>>;

  const Body& body(std::size_t i) const {
    return i < robots_.size() ? robots_[i] : uncooperative_[i - robots_.size()];
  }
  bool somebody_looks() const {
    return std::any_of(robots_.begin(), robots_.end(), [](const Robot& r) { return r.looks; });
  }
  /// A body that this line has not drawn last.
  std::string another() {
    for (;;) {
      const std::string& name = body(below(robots_.size() + uncooperative_.size())).name;
      if (name != last_) return last_ = name;
    }
  }
  std::string observer() {
    for (;;) {
      if (const Robot& robot = any(robots_); robot.looks) return last_ = robot.name;
    }
  }

  /// A place up to `reach` [m] from a body, on the ground for one that is there.
  std::string near(const Body& about, double reach) {
    const Vec3<double> r = random_point(random_, reach);
    const double z = about.p.z > 0 ? std::max(0.4, about.p.z + 0.3 * r.z) : 0.0;
    return fmt::format("[{:.2f}, {:.2f}, {:.2f}]", about.p.x + r.x, about.p.y + r.y, z);
  }

  /// What stands for one `$[...]` of a table.
  std::string word(const std::string& what, const Body& about) {
    if (what == "robot") return last_ = any(robots_).name;
    if (what == "observer") return observer();
    if (what == "body") return another();
    if (what.starts_with("near ")) return near(about, std::stod(what.substr(5)));
    if (what.find('|') == std::string::npos) {
      return number(std::stod(what), std::stod(what.substr(what.find(' '))));
    }
    std::vector<std::string> words = {""};
    for (const char c : what) {
      if (c == '|') {
        words.emplace_back();
      } else {
        words.back() += c;
      }
    }
    return any(words);
  }

  /// A line of a table with its chances drawn.
  std::string drawn(std::string_view line, const Body& about) {
    std::string text;
    last_.clear();
    for (std::size_t at = line.find("$["); at != std::string_view::npos; at = line.find("$[")) {
      const std::size_t end = line.find(']', at);
      text += line.substr(0, at);
      text += word(std::string(line.substr(at + 2, end - at - 2)), about);
      line.remove_prefix(end + 1);
    }
    return text.append(line);
  }
  /// A line of a table that speaks of no place.
  template <class Table>
  std::string any_of(const Table& table) {
    return drawn(any(table), Body{});
  }

  // --- who is there ---

  /// Apart from the others; now and then it is not.
  Vec3<double> place(bool flies) {
    const double apart = chance(0.04) ? 0.2 : 1.3;
    for (;;) {
      Vec3<double> p = random_point(random_, 3.5);
      p.z = flies ? between(0.7, 2.5) : 0.0;
      const bool free = std::none_of(places_.begin(), places_.end(), [&](const Vec3<double>& q) {
        return square(p.x - q.x) + square(p.y - q.y) < square(apart);
      });
      if (!free) continue;
      places_.push_back(p);
      return p;
    }
  }

  /// Starts below the floor, above the ceiling or beyond the world.
  void leave_walls(Robot& robot) {
    const std::size_t wall = robot.kind->is("flies") ? below(3) : 2;
    if (wall == 0) robot.p.z = between(-0.5, 0.2);
    if (wall == 1) robot.p.z = between(3.0, 7.0);
    if (wall == 2) robot.p.x += between(8.0, 20.0);
  }

  void draw_team() {
    has_swarm_ = chance(0.25);
    has_relay_ = chance(0.1);
    has_events_ = chance(0.7);
    has_parts_ = !has_swarm_ && !has_relay_ && !has_events_ && chance(0.3);
    filtered_ = chance(0.5);
    std::vector<const DrawnKind*> fit;
    for (const DrawnKind& kind : drawn_kinds()) {
      if (!filtered_ || kind.is("filtered")) fit.push_back(&kind);
    }
    const DrawnKind* const one = any(fit);
    const bool mixed = chance(0.6);
    const double looking = any(std::vector<double>{0.0, 0.25, 0.6});
    const std::size_t robots = 2 + below(7), uncooperative = below(4);
    for (std::size_t i = 0; i < robots; ++i) {
      Robot robot;
      robot.kind = mixed ? any(fit) : one;
      robot.name = fmt::format("r{}", i);
      robot.p = place(robot.kind->is("flies"));
      if (chance(0.12)) leave_walls(robot);
      robot.present = i == 0 || !has_events_ || !chance(0.12);
      robot.looks = chance(looking);
      robot.tracks = !robot.looks || chance(0.3);
      robot.limits_move = chance(0.05);
      robot.has_rates = chance(0.3);
      robots_.push_back(robot);
    }
    for (std::size_t i = 0; i < uncooperative; ++i) {
      uncooperative_.push_back({fmt::format("s{}", i), place(chance(0.8)), !has_events_ || !chance(0.1)});
    }
  }

  // --- what is written ---

  void write_horizon() {
    const std::string_view period = any(drawn_periods);
    line("[horizon]\nduration = {}\nstages = {}\nperiod = {}", number(0.6, 1.6), 8 + below(18), period);
    if (!has_events_ && !has_relay_ && !has_swarm_ && !has_parts_ && chance(0.5))
      line("[solver]\nname = \"{}\"\nzeta = {:.2f}", chance(0.5) ? "cmscgmres" : "cgmres",
           0.2 / std::stod(std::string(period)));
  }

  /// Limits of all sizes; u = 0 is within them.
  Limits input_limits(const DrawnKind& kind) {
    const double size = chance(0.7) ? between(0.3, 1.0) : between(1.0, 1.2);
    const bool even = chance(0.6);
    Limits limits;
    for (const double most : kind.most) {
      limits.first.push_back(-size * most * (even ? 1.0 : between(0.4, 1.0)));
      limits.second.push_back(size * most * (even ? 1.0 : between(0.4, 1.0)));
    }
    return limits;
  }

  void write_robot(const Robot& robot) {
    const DrawnKind& kind = *robot.kind;
    line("\n[agent.{}]\n{}", robot.name, kind.keys);
    line("start = {{ p = [{:.2f}, {:.2f}, {:.2f}], heading = {}{} }}", robot.p.x, robot.p.y, robot.p.z,
         kind.is("heads") ? number(-3.14, 3.14) : "0.0",
         kind.is("fast") && chance(0.2) ? drawn(", v = [$[-0.8 0.8], $[-0.8 0.8]]", robot) : "");
    if (!robot.present) line("present = false");
    std::vector<double> Q(kind.states.size()), R(kind.most.size());
    for (std::size_t i = 0; i < Q.size(); ++i) {
      if (i < 3 && robot.tracks) Q[i] = between(0.5, 2.0);
      if (kind.states[i].starts_with("d_") && robot.tracks && chance(0.5)) Q[i] = 1.0;
      if (kind.states[i].starts_with("v") && chance(0.3)) Q[i] = 0.3;
    }
    for (double& weight : R) weight = between(0.1, 1.0);
    line("Q = {}\nR = {}", list(Q), list(R));
    if (robot.tracks || chance(0.3)) line("reference = {}", drawn(any(drawn_references), robot));
    if (robot.limits_move) {
      const Limits now = input_limits(kind), then = input_limits(kind);
      line("limits = {{ times = [0.0, {}], u_min = [{}, {}], u_max = [{}, {}] }}", number(2, 15),
           list(now.first), list(then.first), list(now.second), list(then.second));
    } else if (chance(0.4)) {
      const Limits limits = input_limits(kind);
      line("u_min = {}\nu_max = {}", list(limits.first), list(limits.second));
    }
    for (const std::string_view key : drawn_compensation) {
      if (chance(0.2)) line("{}", drawn(key, robot));
    }
    if (robot.has_rates) {
      std::vector<double> rates;
      for (const double most : kind.most) rates.push_back(most * between(0.3, 6.0));
      line("rate_max = {}", list(rates));
    }
    if (robot.looks) line("sensor = {}", drawn(any(drawn_sensors), robot));
    if (!kind.text.empty()) line("[agent.{}.robot.text]\n{}", robot.name, kind.text);
  }

  void write_uncooperative(const Body& body) {
    line("\n[{}.{}]\n{}", chance(0.5) ? "target" : "obstacle", body.name, drawn(any(drawn_motions), body));
    if (!body.present) line("present = false");
    if (chance(0.3)) line("velocity = \"{}\"", chance(0.5) ? "measured" : "unknown");
    if (chance(0.2)) line("d_hard = {}", number(0.4, 1.0));
  }

  /// A potential that a robot may have on another body.
  std::string potential(const Robot& robot) {
    const double kind = between(0, 1);
    if (kind < 0.3 && robot.looks) return any_of(drawn_views);
    return kind < 0.7 ? any_of(drawn_apart) : any_of(drawn_together);
  }

  std::string enter_term(std::string_view key, std::size_t robot) {
    terms_.push_back({fmt::format("term{}", terms_.size()), key, robot});
    return terms_.back().name;
  }

  /// The keys of a coupling that a robot feels.
  std::vector<std::string> coupling(const Robot& robot, const std::string& other,
                                    const std::string& potential) {
    std::vector<std::string> keys = {fmt::format("potential = {{ {} }}", potential),
                                     fmt::format("between = {}", quoted({robot.name, other})),
                                     fmt::format("weight = {}", number(0.2, 4.0))};
    if (chance(0.7)) keys.push_back(fmt::format("felt_by = {}", quoted({robot.name})));
    return keys;
  }

  void write_couplings() {
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      const Robot& robot = robots_[i];
      if (!robot.looks && chance(0.5)) continue;
      last_ = robot.name;
      const std::string other = another();
      std::vector<std::string> potentials;
      if (robot.looks) {
        potentials = {chance(0.7) ? drawn(drawn_views.front(), robot) : any_of(drawn_views),
                      any_of(drawn_apart), drawn(drawn_together.front(), robot)};
      }
      while (chance(0.3)) potentials.push_back(potential(robot));
      for (const std::string& one : potentials) {
        line("\n[[couple]]\n{}", fmt::join(coupling(robot, other, one), "\n"));
        if (chance(0.5)) line("name = \"{}\"", enter_term("couple", i));
      }
    }
  }

  std::vector<std::string> names(bool looking, const std::string& but) const {
    std::vector<std::string> names;
    for (const Robot& robot : robots_) {
      if ((robot.looks || !looking) && robot.name != but) names.push_back(robot.name);
    }
    return names;
  }

  void write_shapes() {
    if (chance(0.3)) {
      const std::string centre = body(below(robots_.size() + uncooperative_.size())).name;
      const std::vector<std::string> shapes = {
          fmt::format("chain = {}", quoted(names(false, ""))),
          fmt::format("ring = {}", quoted(names(false, ""))),
          fmt::format("star = {{ centre = \"{}\", observers = {} }}", centre, quoted(names(false, centre))),
          "all_pairs = \"all\""};
      line("\n[[shape]]\n{}\npotentials = [ {{ {}, weight = {} }}, {{ {} }} ]", any(shapes),
           any_of(drawn_apart), number(1, 4), any_of(drawn_together));
      if (chance(0.5)) line("felt_by = \"{}\"", chance(0.5) ? "observer" : "both");
    }
    const std::vector<std::string> looking = names(true, "r0");
    if (!has_relay_ || looking.size() < 2) return;
    line("\n[[shape]]\nname = \"relay\"\npotentials = [ {{ {}, weight = {} }}, {{ {} }} ]",
         any_of(drawn_views), number(1, 4), any_of(drawn_together));
    line("nearest = {{ target = \"r0\", observers = {}, margin = {}, dwell = {}, ramp = {} }}",
         quoted(looking), number(0.0, 0.5), number(0.2, 1.5), number(0.0, 1.5));
  }

  /// What robots of a swarm feel, and what one robot feels alone.
  void write_alone() {
    if (has_swarm_) {
      line("\n[[keep_apart]]\nagents = {}\nradius = {}\npotential = {{ {} }}\nweight = {}",
           chance(0.7) ? "\"all\"" : quoted(names(false, "")), number(2.8, 3.5), any_of(drawn_swarms),
           number(1, 6));
    }
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      const std::string& name = robots_[i].name;
      if (chance(0.15)) {
        line("\n[[constrain]]\nagent = \"{}\"\npotential = {{ {} }}\nweight = {}", name, any_of(drawn_own),
             number(0.5, 3));
        if (chance(0.5)) line("name = \"{}\"", enter_term("constrain", i));
      }
      if (chance(0.1)) line("\n[[constrain]]\nagent = \"{}\"\nlimit = {{ {} }}", name, any_of(drawn_limits));
    }
  }

  void write_safety() {
    const bool supervised = chance(0.5);
    if (!filtered_ && !supervised && chance(0.8)) return;
    const bool on_ground =
        std::any_of(robots_.begin(), robots_.end(), [](const Robot& r) { return !r.kind->is("flies"); });
    line("\n[safety]\nbarrier = \"{}\"\nd_hard = {}",
         !filtered_ || chance(0.3) ? "off"
         : chance(0.7)             ? "on"
                                   : "report",
         number(0.4, 0.8));
    if (on_ground || chance(0.5)) line("floor = {}", on_ground ? number(-1.0, -0.2) : number(0.1, 0.5));
    if (chance(0.3)) line("ceiling = {}", number(3, 6));
    if (chance(0.2)) line("world = {}", number(8, 20));
    if (!supervised) return;
    line("[safety.supervisor]");
    if (chance(0.2)) line("land_speed = {}", number(0.2, 0.6));
    if (chance(0.2)) line("slow_factor = {}", number(0.2, 0.9));
  }

  // --- events ---

  void write_events() {
    if (!has_events_) return;
    std::vector<bool> there;
    for (const Robot& robot : robots_) there.push_back(robot.present);
    for (const Body& body : uncooperative_) there.push_back(body.present);
    // Whoever is not there at first comes, now or then.
    for (std::size_t i = 0; i < there.size(); ++i) {
      if (!there[i])
        line("\n[[event]]\nat = {:.2f}\nadd = \"{}\"", between(0.0, 0.2 * duration_), body(i).name);
      there[i] = true;
    }
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      if (!robots_[i].has_rates || chance(0.5)) continue;
      for (const double part : {0.3, 0.6})
        line("\n[[event]]\nat = {:.2f}\n{}", part * duration_ + 0.01 * static_cast<double>(i),
             limits_event(i));
    }
    const std::size_t count = 1 + below(6);
    double t = 0.2 * duration_;
    for (std::size_t i = 0; i < count; ++i) {
      t += between(0.02, 0.9 * duration_ / static_cast<double>(count));
      const bool timed = chance(0.6);
      const std::string does = timed && chance(0.5) ? comes_or_goes(there) : changes();
      if (does.empty()) continue;
      line("\n[[event]]\n{}\n{}", timed ? fmt::format("at = {:.2f}", t) : when(), does);
      if (chance(0.3)) line("name = \"event {}\"", i);
      if (chance(0.4)) line("ramp = {}", number(0, 2));
      if (!timed && stages_ < 2 && chance(0.4)) line("stage = \"{}\"", stages_ == 0 ? "start" : "watch");
      if (stages_ == 0 && chance(0.3)) {
        line("enter = \"watch\"");
        ++stages_;
      }
    }
  }

  std::string when() {
    if (chance(0.1)) return fmt::format("after = {}", number(0, 0.5 * duration_));
    return somebody_looks() && chance(0.5) ? any_of(drawn_sights) : any_of(drawn_triggers);
  }

  /// A body that comes or goes at a time, as those before it left the team.
  std::string comes_or_goes(std::vector<bool>& there) {
    const std::size_t i = 1 + below(there.size() - 1);
    const std::string& name = body(i).name;
    if (!there[i]) {
      there[i] = true;
      return fmt::format("add = \"{}\"", name);
    }
    there[i] = false;
    if (i >= robots_.size()) return fmt::format("remove = \"{}\"", name);
    return fmt::format("remove = {{ agent = \"{}\", then = \"{}\" }}", name,
                       word("vanish|hold|land", Body{}));
  }

  std::string limits_event(std::size_t robot) {
    const Limits limits = input_limits(*robots_[robot].kind);
    return fmt::format("retune = {{ agent = \"{}\", u_min = {}, u_max = {} }}", robots_[robot].name,
                       list(limits.first), list(limits.second));
  }

  std::string changes() {
    const std::size_t i = below(robots_.size());
    const Robot& robot = robots_[i];
    switch (below(6)) {
      case 0: {
        last_ = robot.name;
        const std::string other = another();
        return fmt::format("add = {{ couple = {{ {} }} }}",
                           fmt::join(coupling(robot, other, potential(robot)), ", "));
      }
      case 1:
        return limits_event(i);
      case 2: {
        std::vector<double> R(robot.kind->most.size());
        for (double& weight : R) weight = between(0.1, 2.0);
        return fmt::format("retune = {{ agent = \"{}\", R = {} }}", robot.name, list(R));
      }
      case 3:
        return fmt::format("reference = {{ agent = \"{}\", reference = {} }}", robot.name,
                           drawn(any(drawn_references), robot));
      case 4:
        if (!robot.looks)
          return fmt::format("add = {{ constrain = {{ agent = \"{}\", potential = {{ {} }} }} }}", robot.name,
                             any_of(drawn_own));
        last_ = robot.name;
        return fmt::format("observe = {{ observer = \"{}\", target = \"{}\" }}", robot.name, another());
      default: {
        if (terms_.empty()) return {};
        const Term& term = any(terms_);
        if (chance(0.3)) return fmt::format("remove = {{ {} = \"{}\" }}", term.key, term.name);
        const std::string to = term.key == "couple" ? potential(robots_[term.robot]) : any_of(drawn_own);
        return fmt::format("retune = {{ {} = \"{}\", weight = {}, potential = {{ {} }} }}", term.key,
                           term.name, number(0.2, 4), to);
      }
    }
  }

  void write_simulation(std::uint64_t seed) {
    line("\n[simulation]\nduration = {:.1f}\nseed = {}\nsettle = {}", duration_, seed,
         number(0, 0.5 * duration_));
    line("rms_from = {}", number(0, 0.5 * duration_));
    line("signal = [ {{ at = {}, name = \"go\" }}, {{ at = {}, name = \"back\" }} ]", number(0, duration_),
         number(0, duration_));
    if (chance(0.3)) line("[simulation.disturbance]\n{}", any_of(drawn_disturbances));
    while (chance(0.5)) {
      const double from = between(0, duration_);
      line("[[simulation.fault]]\n{}\nfrom = {:.2f}", any_of(drawn_faults), from);
      if (chance(0.7)) line("until = {:.2f}", from + between(0.05, 0.25 * duration_));
    }
    line("[log]\nprediction_period = 1.0");
  }

  void write_world_and_subteams() {
    const bool vehicles = std::any_of(robots_.begin(), robots_.end(), [](const Robot& r) {
      return r.kind->keys.find("multirotor") != std::string_view::npos;
    });
    if (vehicles && chance(0.25)) line("\n[world]\nkind = \"{}\"", chance(0.8) ? "rotors" : "mujoco");
    if (!has_parts_) return;
    const std::vector<std::string> all = names(false, "");
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>((all.size() + 1) / 2);
    line("\n[partition]\nfront = {}\nback = {}", quoted({all.begin(), middle}), quoted({middle, all.end()}));
  }

  double duration_;  // [s]
  std::string last_;
  std::vector<Vec3<double>> places_;
  std::vector<Robot> robots_;
  std::vector<Body> uncooperative_;
  std::vector<Term> terms_;
  int stages_ = 0;  // that events entered
  bool filtered_ = false, has_swarm_ = false, has_relay_ = false, has_events_ = false, has_parts_ = false;
};

}  // namespace sightline::test
