/// An independent judge of a flight: scenario text and poses of the log in, broken promises out. It has the documents'
/// mathematics and none of the library's but the reading of bytes.
#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/support/flight_log.hpp"
#include "tests/support/judged_team.hpp"

namespace sightline::test {

class FlightJudge {
 public:
  /// Of the run that left `folder` and ended with `code`.
  FlightJudge(const std::filesystem::path& scenario, const std::filesystem::path& folder, int code)
      : file_(toml::parse_file(scenario.string())),
        log_(folder / "run.mcap"),
        summary_(nlohmann::json::parse(std::ifstream(folder / "summary.json"))),
        team_(file_, log_),
        code_(code),
        periods_(log_.status.size()) {}

  /// What was promised and not kept, a sentence each.
  std::vector<std::string> broken() {
    expect(summary_.at("allocations_per_update") == 0, "{} allocations in an update",
           summary_.at("allocations_per_update").dump());
    expect(summary_.at("updates") == periods_, "{} updates in the summary, {} in the log",
           summary_.at("updates").dump(), periods_);
    judge_commands();
    judge_landings();
    judge_solver();
    judge_limits();
    judge_views();
    judge_distances();
    judge_walls();
    return std::move(broken_);
  }

 private:
  static constexpr double tolerance = 1e-6;  // between two ways to compute one number

  template <class... Args>
  void expect(bool kept, fmt::format_string<Args...> sentence, Args&&... args) {
    if (!kept && broken_.size() < 20) broken_.push_back(fmt::format(sentence, std::forward<Args>(args)...));
  }

  /// Finite, and within the limits that are in force.
  void judge_commands() {
    for (const auto& [name, body] : log_.bodies) {
      if (!body.is_robot) continue;
      expect(body.u.size() == periods_, "{} has {} commands in {} periods", name, body.u.size(), periods_);
      for (std::size_t k = 0; k < body.u.size(); ++k) {
        const auto limits = team_.input_limits(name, log_.time(k));
        for (std::size_t i = 0; i < body.u[k].size(); ++i) {
          const double u = body.u[k][i];
          const bool kept = std::isfinite(u) && (!limits || (u >= limits->low[i] && u <= limits->high[i]));
          if (kept) continue;
          expect(false, "the command {} of {} is {} at {:.2f} s, its limits are {} and {}", i, name, u,
                 log_.time(k), limits ? limits->low[i] : 0.0, limits ? limits->high[i] : 0.0);
          return;
        }
      }
    }
  }

  /// Nobody lands who was not told to, and whose data were not old.
  void judge_landings() {
    for (const FlightLog::Reported& reported : log_.events) {
      if (reported.kind != "land") continue;
      const std::string& name = log_.names.at(static_cast<std::size_t>(reported.value));
      if (team_.duty(name, reported.time) == Duty::land) continue;
      expect(team_.data_may_be_old(name, reported.time), "{} lands at {:.2f} s, and nothing of it was old",
             name, reported.time);
    }
  }

  /// A solver without a plan for longer than hold_after is no success.
  void judge_solver() {
    double since = -1.0;
    for (std::size_t k = 0; k < periods_; ++k) {
      const bool failed = log_.status[k] == "not_finite" || log_.status[k] == "invalid_state";
      if (!failed) since = -1.0;
      if (failed && since < 0) since = log_.time(k);
      if (since < 0 || log_.time(k) + log_.period - since <= team_.hold_after() + 1e-9) continue;
      expect(code_ != 0, "exit 0, and no plan since {:.2f} s", since);
      return;
    }
    for (const auto& [name, body] : log_.bodies) {
      for (const auto& seen : body.seen) {
        if (!seen || (std::isfinite(seen->p[0]) && std::isfinite(seen->p[1]) && std::isfinite(seen->p[2])))
          continue;
        expect(code_ != 0, "exit 0, and the place of {} is no number", name);
      }
    }
  }

  /// The summary's limits of one name.
  std::vector<nlohmann::json> told_of(const std::string& name) const {
    std::vector<nlohmann::json> found;
    for (const auto& limit : summary_.at("limits")) {
      const std::string reported = limit.at("name");
      if (reported == name) found.push_back(limit);
    }
    return found;
  }

  /// No limit is told to be kept that poses show to be broken; none is told to be broken by less.
  void judge_limits() {
    struct Worst {
      double excess = -std::numeric_limits<double>::infinity(), time = 0.0;
    };
    std::map<std::string, Worst> worst;
    for (const JudgedTerm& term : team_.terms()) {
      if (!term.is_limit()) continue;
      Worst& of = worst[term.label()];
      for (std::size_t k = 0; k < periods_; ++k) {
        if (!team_.counts(term, k)) continue;
        const double excess = team_.excess(term, k);
        if (excess > of.excess) of = {excess, log_.time(k)};
      }
    }
    for (const auto& [name, of] : worst) {
      if (of.excess <= tolerance) continue;
      const auto reported = told_of(name);
      expect(!reported.empty(), "{} is broken by {:.4g} at {:.2f} s, and the summary has no such limit", name,
             of.excess, of.time);
      double most = 0.0;
      for (const auto& limit : reported) {
        if (limit.at("fraction") > 0.0 && limit.at("worst").is_number())
          most = std::max(most, limit.at("worst").get<double>());
      }
      expect(reported.empty() || most >= of.excess - 1e-4 * std::max(1.0, of.excess),
             "{} is broken by {:.6g} at {:.2f} s, the summary says {:.6g}", name, of.excess, of.time, most);
    }
  }

  /// A target that is told to be in view all of the time is; one out of view at the end is told.
  void judge_views() {
    constexpr double lost_after = 2.0;
    const double settle = file_["simulation"]["settle"].value_or(6.0);
    for (const JudgedTerm& term : team_.terms()) {
      if (!term.is_view()) continue;
      double out_since = -1.0;
      for (std::size_t k = 0; k < periods_; ++k) {
        const bool counts = team_.counts(term, k), out = counts && team_.excess(term, k) > tolerance;
        if (!out) out_since = -1.0;
        if (out && out_since < 0) out_since = log_.time(k);
        if (!out || log_.time(k) < settle) continue;
        for (const auto& pair : summary_.at("pairs")) {
          if (pair.at("observer") != term.a || pair.at("target") != term.b || !team_.is_first_view(term))
            continue;
          expect(pair.at("in_view_fraction") != 1.0,
                 "{} does not see {} at {:.2f} s, the summary says always", term.a, term.b, log_.time(k));
        }
      }
      if (out_since >= 0 && log_.time(periods_) - out_since > lost_after + 2 * log_.period &&
          team_.is_first_view(term)) {
        expect(code_ != 0, "exit 0, and {} has not seen {} since {:.2f} s", term.a, term.b, out_since);
      }
    }
  }

  /// Hard distances, and the least distance of all.
  void judge_distances() {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < log_.names.size(); ++i) {
      for (std::size_t j = i + 1; j < log_.names.size(); ++j) {
        const std::string &a = log_.names[i], &b = log_.names[j];
        if (!log_.bodies.at(a).is_robot && !log_.bodies.at(b).is_robot) continue;
        const auto d_hard = team_.hard_distance(a, b);
        for (std::size_t k = 0; k < periods_; ++k) {
          const auto *p = team_.seen(a, k), *q = team_.seen(b, k);
          if (p == nullptr || q == nullptr) continue;
          const double apart = distance(*p, *q);
          least = std::min(least, apart);
          if (d_hard && apart < *d_hard - tolerance) {
            expect(code_ != 0, "exit 0, and {} is {:.4g} m from {} at {:.2f} s, d_hard is {} m", a, apart, b,
                   log_.time(k), *d_hard);
          }
        }
      }
    }
    const auto& reported = summary_.at("min_distance");
    // Between samples they may be nearer; tests/independent judges by how much.
    expect(reported.is_null() ? std::isinf(least) : reported.get<double>() < least + tolerance,
           "the least distance is {:.6g} m, the summary says {}", least, reported.dump());
  }

  /// Floor, ceiling and world, but for who lands.
  void judge_walls() {
    const auto safety = file_["safety"];
    if (!safety || safety["barrier"].value_or<std::string>("off") != "on") return;
    const double floor = safety["floor"].value_or(0.3), ceiling = safety["ceiling"].value_or(10.0),
                 world = safety["world"].value_or(100.0);
    const auto said = [&](const std::string& name, std::size_t k) {
      const auto& p = team_.seen(name, k)->p;
      expect(code_ != 0,
             "exit 0, and {} is at ({:.3f}, {:.3f}, {:.3f}) at {:.2f} s, beyond floor, ceiling or world",
             name, p[0], p[1], p[2], log_.time(k));
    };
    for (const auto& [name, body] : log_.bodies) {
      if (!body.is_robot) continue;
      bool within = false;  // who takes off has to get there first
      std::size_t k = 0;
      for (; k < body.seen.size(); ++k) {
        const FlightLog::Seen* seen = team_.seen(name, k);
        const bool counts = seen != nullptr && !team_.lands(name, log_.time(k));
        const bool kept = counts && seen->p[2] >= floor - 2e-3 && seen->p[2] <= ceiling + 2e-3 &&
                          std::abs(seen->p[0]) <= world + 2e-3 && std::abs(seen->p[1]) <= world + 2e-3;
        if (within && counts && !kept) break;
        within = kept;
      }
      if (k < body.seen.size()) {
        said(name, k);
      } else if (k > 0 && !within && team_.seen(name, k - 1) != nullptr &&
                 !team_.lands(name, log_.time(k - 1))) {
        said(name, k - 1);
      }
    }
  }

  toml::table file_;
  FlightLog log_;
  nlohmann::json summary_;
  JudgedTeam team_;
  int code_;
  std::size_t periods_;
  std::vector<std::string> broken_;
};

}  // namespace sightline::test
