#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include "sightline/analysis.hpp"
#include "sightline/analysis/field.hpp"
#include "sightline/analysis/flow.hpp"

namespace sightline {
namespace {

using std::numbers::pi;
constexpr double nearest = 0.05, farthest = 200.0;  // range of the sampled distances [m]
constexpr int distances = 200;
constexpr double a_tenth_more = 1.1;

/// A coupling of a pair; `turned` if the pair's second body is its first.
struct Member {
  std::size_t coupling;
  const Coupling* of;
  bool turned;
  const SensorMount* mount;
  bool in_world;

  bool felt_by(BodyId body) const {
    return std::find(of->felt_by.begin(), of->felt_by.end(), body) != of->felt_by.end();
  }

  double violation(const Station& s) const {
    const Sight<double> a = observer_of(s), b = target_of(s);
    return turned ? of->term.potential.violation(b, a) : of->term.potential.violation(a, b);
  }
  bool holds(const Station& s) const { return !(violation(s) > 0); }
};

double distance_number(int n) { return nearest * std::pow(farthest / nearest, n / double{distances - 1}); }

/// Directions evenly spread over the sphere.
std::vector<Vec3<double>> directions(int n) {
  const double golden = pi * (3 - std::sqrt(5.0));
  std::vector<Vec3<double>> all;
  for (int i = 0; i < n; ++i) {
    const double z = 1 - (2 * i + 1) / static_cast<double>(n), r = std::sqrt(1 - z * z);
    all.push_back({r * std::cos(golden * i), r * std::sin(golden * i), z});
  }
  return all;
}

/// Two bodies and their starts.
struct Ends {
  BodyId first, second;
  Vec3<double> first_start{}, second_start{};
  std::array<double, 6> places() const {
    const Vec3<double>&a = first_start, &b = second_start;
    return {a.x, a.y, a.z, b.x, b.y, b.z};
  }
};

class Pair {
 public:
  Pair(std::vector<Member> members, const Ends& ends)
      : members_(std::move(members)), ends_(ends), field_(terms()) {
    for (const Member& m : members_) {
      turned_sees_ |= m.turned && Field(m.of->term.potential).sees_heading();
      in_world_ |= m.in_world;
    }
    global_ = depends_on_the_world();
  }

  PairAdvice advice() const {
    PairAdvice a{ends_.first, ends_.second, {}, {}, bands(members_), {}, {}, {}};
    if (feel_alike()) {
      a.rest = rest();
    } else {
      settle(a);
    }
    const std::vector<double> worst = worst_of_each();
    for (std::size_t i = 0; i < members_.size(); ++i) {
      const Member& m = members_[i];
      a.limits.push_back({m.coupling, kind(m), bands({m}), m.in_world, worst[i]});
    }
    for (std::size_t i = 0; i < members_.size() && a.holds.empty(); ++i) {
      for (std::size_t j = i + 1; j < members_.size(); ++j) {
        const bool each = !a.limits[i].holds.empty() && !a.limits[j].holds.empty();
        if (each && bands({members_[i], members_[j]}).empty()) {
          a.contradictions.emplace_back(members_[i].coupling, members_[j].coupling);
        }
      }
    }
    return a;
  }

 private:
  std::vector<FieldTerm> terms() const {
    std::vector<FieldTerm> list;
    for (const Member& m : members_) list.push_back({m.of->term, m.turned});
    return list;
  }

  /// Whether the cost depends on the place or the heading of the pair in the world.
  bool depends_on_the_world() const {
    constexpr double turn = 1.1;
    const double c = std::cos(turn), s = std::sin(turn);
    const Vec3<double> at = {3.0, -2.0, 1.5};
    for (const Vec3<double>& d : directions(20)) {
      const Vec3<double> r = 1.2 * d;
      const Station here = {.target = r, .psi = 0.3, .psi_target = -0.8};
      const Station there = {.observer = at,
                             .target = at + Vec3<double>{c * r.x - s * r.y, s * r.x + c * r.y, r.z},
                             .psi = 0.3 + turn,
                             .psi_target = -0.8 + turn};
      if (std::fabs(field_(here).l - field_(there).l) > 1e-9) return true;
    }
    return false;
  }

  /// Relative poses at a distance: evenly spread in all directions, and along the axes of the
  /// sensors.
  std::vector<Station> stations(double distance) const {
    static const std::vector<Vec3<double>> even = directions(150);
    const int headings = global_ ? 8 : 1, target_headings = turned_sees_ ? 8 : 1;
    std::vector<Station> list;
    for (int i = 0; i < headings; ++i) {
      for (int j = 0; j < target_headings; ++j) {
        const double psi = 2 * pi * i / headings, psi_target = 2 * pi * j / target_headings;
        for (const Vec3<double>& d : even) list.push_back({{}, distance * d, psi, psi_target});
        for (const Member& m : members_) {
          if (m.mount != nullptr) list.push_back(on_axis(m, distance, psi, psi_target));
        }
      }
    }
    return in_world_ ? around_starts(list) : list;
  }

  /// The same poses with the first body at its start, and with the second body at its start.
  std::vector<Station> around_starts(const std::vector<Station>& relative) const {
    std::vector<Station> list;
    for (const Station& s : relative) {
      Station& a = list.emplace_back(s);
      a.observer = ends_.first_start;
      a.target = a.target + a.observer;
      Station& b = list.emplace_back(s);
      b.observer = ends_.second_start - b.target;
      b.target = ends_.second_start;
    }
    return list;
  }

  /// The target on the axis of a member's sensor.
  static Station on_axis(const Member& m, double distance, double psi, double psi_target) {
    const Vec3<double> r = seen_at({m.mount->depth_at(distance), 0, 0}, m.mount).target;
    const double heading = m.turned ? psi_target : psi, sign = m.turned ? -1 : 1;
    const double dx = std::cos(heading), dy = std::sin(heading);
    return {{}, sign * Vec3<double>{dx * r.x - dy * r.y, dy * r.x + dx * r.y, r.z}, psi, psi_target};
  }

  bool can_hold(const std::vector<Member>& members, double distance) const {
    const std::vector<Station> places = stations(distance);
    return std::any_of(places.begin(), places.end(), [&](const Station& s) {
      return std::all_of(members.begin(), members.end(), [&](const Member& m) { return m.holds(s); });
    });
  }

  std::vector<DistanceBand> bands(const std::vector<Member>& members) const {
    const auto border = [&](double holds, double breaks) {
      for (int n = 0; n < 20; ++n) {
        const double middle = 0.5 * (holds + breaks);
        (can_hold(members, middle) ? holds : breaks) = middle;
      }
      return holds;
    };
    std::vector<DistanceBand> found;
    bool held = false;
    for (int n = 0; n < distances; ++n) {
      const bool holds = can_hold(members, distance_number(n));
      if (holds && !held) {
        const double low = n == 0 ? 0.0 : border(distance_number(n), distance_number(n - 1));
        found.push_back({low, std::numeric_limits<double>::infinity()});
      }
      if (held && !holds) found.back().high = border(distance_number(n - 1), distance_number(n));
      held = holds;
    }
    return found;
  }

  LimitKind kind(const Member& m) const {
    if (!std::isfinite(m.violation({.target = {1, 0, 0}}))) return LimitKind::none;
    const auto at = [&](double distance, bool holds) {
      const auto places = stations(distance);
      return std::all_of(places.begin(), places.end(), [&](const Station& s) { return m.holds(s) == holds; });
    };
    if (at(nearest, false) && at(farthest, true)) return LimitKind::apart;
    if (at(nearest, true) && at(farthest, false)) return LimitKind::together;
    return LimitKind::view;
  }

  std::vector<double> worst_of_each() const {
    std::vector<Station> places;
    for (int n = 0; n <= 60; ++n) {
      const auto at = stations(explain_reach * n / 60);
      places.insert(places.end(), at.begin(), at.end());
    }
    std::vector<double> worst;
    for (const Member& m : members_) {
      double most = 0.0;
      for (const FieldValue& f : Field(std::vector{FieldTerm{m.of->term, m.turned}})(places))
        most = std::max(most, f.l);
      worst.push_back(most);
    }
    return worst;
  }

  /// Whether the pair minimises one cost: the same couplings act on both bodies, or couplings act
  /// on one body only.
  bool feel_alike() const {
    const auto felt = [&](BodyId body) {
      std::vector<bool> by;
      for (const Member& m : members_) by.push_back(m.felt_by(body));
      return by;
    };
    const std::vector<bool> a = felt(ends_.first), b = felt(ends_.second), nobody(members_.size(), false);
    return a == b || a == nobody || b == nobody;
  }

  /// Follows the gradient flow from the best places until the pair rests or drifts.
  void settle(PairAdvice& a) const {
    for (const Station& start : best_places(3)) {
      Drifting first{start.observer, start.psi, {true, true, true, true}};
      Drifting second{start.target, start.psi_target, {true, true, true, true}};
      Flow flow({first, second});
      for (const Member& m : members_) {
        const std::size_t observer = m.turned ? 1 : 0;
        flow.add(m.of->term, observer, 1 - observer, m.felt_by(m.of->between.first),
                 m.felt_by(m.of->between.second));
      }
      const FlowEnd settled = flow.settle();
      const Drifting &p = settled.bodies[0], &q = settled.bodies[1];
      a.drift = settled.drift;
      if (settled.drift) continue;
      a.rest = rest_at({p.p, q.p, p.psi, q.psi});
      if (a.rest) return;
    }
  }

  /// The sampled places with the least total cost.
  std::vector<Station> best_places(std::size_t tries) const {
    std::vector<Station> places;
    for (int n = 1; n <= 60; ++n) {
      const auto at = stations(1.5 * explain_reach * n / 60);
      places.insert(places.end(), at.begin(), at.end());
    }
    const auto values = field_(places);
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (std::isfinite(values[i].l)) order.push_back(i);
    }
    const std::size_t few = std::min(tries, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(few), order.end(),
                      [&](std::size_t i, std::size_t j) { return values[i].l < values[j].l; });
    std::vector<Station> best;
    for (std::size_t i = 0; i < few; ++i) best.push_back(places[order[i]]);
    return best;
  }

  std::optional<PairRest> rest() const {
    std::vector<int> free = {0, 1, 2};
    if (global_) free.push_back(3);
    if (turned_sees_) free.push_back(4);
    std::optional<Rest> best;
    for (const Station& start : best_places(8)) {
      const Rest rest = descend(field_, start, free);
      if (rest.is_minimum && (!best || rest.l < best->l)) best = rest;
    }
    return best ? rest_at(best->station) : std::nullopt;
  }

  std::optional<PairRest> rest_at(const Station& station) const {
    const Vec3<double> r = station.target - station.observer;
    const double distance = norm(r), cost = field_(station).l;
    // A plateau is no equilibrium: its cost does not fix the distance.
    const auto at = [&](double scale) {
      Station s = station;
      s.target = s.observer + scale * r;
      return field_(s).l;
    };
    if (!(distance < 1.5 * explain_reach) || (at(0.8) == cost && at(1.2) == cost)) return {};
    PairRest result{distance, norm(r.x, r.y), -r.z, cost, {distance, distance}, {}};
    const auto near = [&](double scale) { return at(scale) <= cost + explain_margin; };
    for (double scale = 1.0; scale > 0 && near(scale); scale -= 1e-3) result.within.low = scale * distance;
    for (double scale = 1.0; scale < 3 && near(scale); scale += 1e-3) result.within.high = scale * distance;
    for (const Member& m : members_) {
      if (!m.holds(station)) result.broken.push_back(m.coupling);
    }
    return result;
  }

  std::vector<Member> members_;
  Ends ends_;
  Field field_;
  bool in_world_ = false;     // some limit depends on the places in G
  bool turned_sees_ = false;  // a turned potential depends on the heading of the second
  bool global_ = false;
};

/// Pairs analysed so far: in a large team most pairs are equal.
class KnownPairs {
 public:
  PairAdvice advice(std::vector<Member> members, const Ends& ends, const std::vector<PairAdvice>& earlier) {
    std::vector<TermKey> key;
    for (const Member& m : members) {
      const Weighted& term = m.of->term;
      key.push_back({std::string(term.potential.name()), term.weight, m.turned, m.felt_by(ends.first),
                     m.felt_by(ends.second), m.in_world ? ends.places() : std::array<double, 6>{},
                     formula_of(term.potential)});
    }
    for (const auto& [index, other] : known_) {
      if (other != key) continue;
      PairAdvice same = earlier[index];
      renumber(same, members);
      same.first = ends.first, same.second = ends.second, same.same_as = index;
      return same;
    }
    known_.emplace_back(earlier.size(), std::move(key));
    return Pair(std::move(members), ends).advice();
  }

 private:
  struct TermKey {
    std::string name;
    double weight;
    bool turned, felt_by_first, felt_by_second;
    std::array<double, 6> starts;  // 0 if they have no effect
    Program formula;

    bool operator==(const TermKey&) const = default;
  };

  /// Replaces an advice's couplings by those of another pair, in the same order.
  static void renumber(PairAdvice& a, const std::vector<Member>& members) {
    const auto number = [&](std::size_t& coupling) {
      const auto at = std::find_if(a.limits.begin(), a.limits.end(),
                                   [&](const LimitWorth& l) { return l.coupling == coupling; });
      coupling = members[static_cast<std::size_t>(at - a.limits.begin())].coupling;
    };
    for (auto& [i, j] : a.contradictions) number(i), number(j);
    if (a.rest) {
      for (std::size_t& coupling : a.rest->broken) number(coupling);
    }
    for (std::size_t i = 0; i < members.size(); ++i) a.limits[i].coupling = members[i].coupling;
  }

  std::vector<std::pair<std::size_t, std::vector<TermKey>>> known_;
};

/// Whether two limits of a pair can hold together: then evading by the one does not cost the other.
bool agree(const PairAdvice& pair, std::size_t i, std::size_t j) {
  const auto contradicts = [&](const auto& c) {
    return (c.first == i && c.second == j) || (c.first == j && c.second == i);
  };
  return std::none_of(pair.contradictions.begin(), pair.contradictions.end(), contradicts);
}

/// Adds the cost of a collision for each robot, against the limits that evading would break.
void add_hits(const Team& team, Explanation& e) {
  for (const PairAdvice& pair : e.pairs) {
    for (const LimitWorth& limit : pair.limits) {
      if (limit.kind != LimitKind::apart) continue;
      const Coupling& coupling = team.couplings()[limit.coupling];
      for (const AgentId agent : coupling.felt_by) {
        double others = 0.0;
        for (const PairAdvice& other : e.pairs) {
          for (const LimitWorth& l : other.limits) {
            const auto& felt_by = team.couplings()[l.coupling].felt_by;
            const bool felt = std::find(felt_by.begin(), felt_by.end(), agent) != felt_by.end();
            const bool at_stake = &other != &pair || !agree(pair, l.coupling, limit.coupling);
            if (felt && at_stake && l.kind != LimitKind::apart) others += l.worst;
          }
        }
        HitCost cost{limit.coupling, agent, limit.worst, others, {}};
        if (limit.worst <= others && limit.worst > 0) {
          cost.weight = a_tenth_more * coupling.term.weight * others / limit.worst;
        }
        e.hits.push_back(cost);
      }
    }
  }
}

}  // namespace

Explanation explain(const Team& team, std::span<const double> x0) {
  Explanation e;
  const std::vector<Coupling> couplings = with_thirds_at(team, x0);
  std::vector<bool> taken(couplings.size(), false);
  KnownPairs known;
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    if (taken[i]) continue;
    const Between pair = couplings[i].between;
    std::vector<Member> members;
    for (std::size_t j = i; j < couplings.size(); ++j) {
      const auto& [first, second] = couplings[j].between;
      const bool straight = first == pair.first && second == pair.second;
      if (!straight && !(first == pair.second && second == pair.first)) continue;
      taken[j] = true;
      const Potential& potential = couplings[j].term.potential;
      members.push_back({j, &couplings[j], !straight, potential.mount(), sees_place(potential)});
    }
    const Ends ends = {pair.first, pair.second, place_at(team, pair.first, x0),
                       place_at(team, pair.second, x0)};
    e.pairs.push_back(known.advice(std::move(members), ends, e.pairs));
  }
  add_hits(team, e);
  return e;
}

}  // namespace sightline
