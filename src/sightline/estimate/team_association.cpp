#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/base/bounded.hpp"
#include "sightline/estimate/kalman.hpp"
#include "sightline/estimate/team_filter.hpp"

namespace sightline {

/// Depth-first search over the bodies that the sightings of a frame may show.
///
/// A hypothesis gives each sighting a body of its own, or none. Its cost is -2 ln of its
/// likelihood: y^T S^-1 y + ln det S + m ln 2 pi with the joint innovation y of its sightings and
/// its covariance S, and a constant for each sighting without a body. Joint compatibility follows:
/// errors that the sightings share, such as that of the heading, are in S.
struct TeamFilter::Association {
  static constexpr int none = candidates_max, most_nodes = 20000;
  // A wrong sighting is anywhere within 10 m and 1 rad, one time in 50.
  static constexpr double cost_of_none = 12.4;
  static constexpr double margin = 6.0;  // a hypothesis within it is likely, too: 5 %

  std::array<Bounded<Candidate, candidates_max>, frame_max> candidates{};
  int sightings = 0;
  std::array<double, frame_max> least{};  // bound of the cost of a sighting
  std::array<std::array<double, candidates_max + 1>, frame_max> best_with{};
  std::array<int, frame_max> chosen{}, best{};
  double best_cost = infinity;
  int nodes = 0;
  std::array<std::array<double, 2 * frame_max>, 2 * frame_max> L{};
  std::array<double, 2 * frame_max> white{};

  Association() noexcept {
    for (auto& costs : best_with) costs.fill(infinity);
  }
  const Candidate& candidate(int sighting) const noexcept {
    return candidates[at(sighting)][at(chosen[at(sighting)])];
  }

  /// Cost of the candidate of a sighting, given those of the earlier ones; rows of L from m on.
  double extend(int sighting, int m) noexcept {
    const Candidate& one = candidate(sighting);
    int column = 0;
    for (int s = 0; s <= sighting; ++s) {
      if (chosen[at(s)] == none) continue;
      const Row& other = candidate(s).row;
      for (int c = 0; c < other.m; ++c, ++column)
        for (int a = 0; a < one.row.m; ++a) {
          double sum = s == sighting ? one.row.R(a, c) : 0.0;
          for (int l = 0; l < other.used; ++l)
            sum += one.G[a * stride + other.columns[at(l)]] * other.H(c, l);
          L[at(m + a)][at(column)] = sum;
        }
    }
    double cost = 0.0;
    for (int a = m; a < m + one.row.m; ++a) {
      double y = one.row.y(a - m, 0);
      for (int c = 0; c <= a; ++c) {
        double sum = L[at(a)][at(c)];
        for (int k = 0; k < c; ++k) sum -= L[at(a)][at(k)] * L[at(c)][at(k)];
        if (c < a) {
          L[at(a)][at(c)] = sum / L[at(c)][at(c)];
          y -= L[at(a)][at(c)] * white[at(c)];
        } else {
          if (!(sum > 0)) return infinity;
          L[at(a)][at(a)] = sqrt(sum);
        }
      }
      white[at(a)] = y / L[at(a)][at(a)];
      cost += square(white[at(a)]) + 2 * log(L[at(a)][at(a)]) + log(2 * std::numbers::pi);
    }
    return cost;
  }

  void search(int sighting, int m, double cost) noexcept {
    if (++nodes > most_nodes) return;
    double bound = cost;
    for (int s = sighting; s < sightings; ++s) bound += least[at(s)];
    if (bound > best_cost + margin) return;
    if (sighting == sightings) {
      for (int s = 0; s < sightings; ++s) {
        double& seen = best_with[at(s)][at(chosen[at(s)])];
        seen = std::min(seen, cost);
      }
      if (cost < best_cost) best_cost = cost, best = chosen;
      return;
    }
    for (int k = 0; k < static_cast<int>(candidates[at(sighting)].size()); ++k) {
      chosen[at(sighting)] = k;
      bool taken = false;
      for (int s = 0; s < sighting; ++s)
        taken = taken || (chosen[at(s)] != none && candidate(s).subject == candidate(sighting).subject);
      if (taken) continue;
      const double more = extend(sighting, m);
      search(sighting + 1, m + candidate(sighting).row.m, cost + more);
    }
    chosen[at(sighting)] = none;
    search(sighting + 1, m, cost + cost_of_none);
  }

  /// Candidate of a sighting that no likely hypothesis contradicts, else `none`.
  int sure(int sighting) const noexcept {
    if (nodes > most_nodes || best[at(sighting)] == none) return none;
    for (int k = 0; k <= candidates_max; ++k)
      if (k != best[at(sighting)] && best_with[at(sighting)][at(k)] < best_cost + margin) return none;
    return best[at(sighting)];
  }

  int stride = 0;
};

void TeamFilter::take_unidentified(std::span<const TeamSighting> frame, std::span<TeamFit> fits) noexcept {
  if (frame.empty()) return;
  Robot& observer = odometry_[at(frame[0].observer)];
  if (is_lost(frame[0].observer)) {
    // A pose that is so uncertain associates wrongly, so it waits until several sightings agree.
    for (std::size_t s = 0; s < frame.size(); ++s) {
      fits[s] = {FitVerdict::rejected};
      if (is_usable(frame[s])) refuse(frame[s]);
    }
    (void)find(frame[0].observer);
    return;
  }
  Association of;
  of.stride = capacity_;
  of.sightings = std::min(static_cast<int>(frame.size()), frame_max);
  double* G = candidate_G_.data();
  for (int s = 0; s < of.sightings; ++s) {
    TeamSighting z = frame[at(s)];
    struct Likely {
      int subject;
      double squared;
    };
    Bounded<Likely, candidates_max> likely;
    for (z.subject = 0; z.subject < bodies(); ++z.subject) {
      if (!is_usable(z)) continue;
      const double squared = squared_distance(row_of(z, pair_of(z)));
      if (!(squared <= chi_squared_gate<2>)) continue;
      if (!likely.is_full()) {
        likely.push_back({z.subject, squared});
        continue;
      }
      Likely* const farthest =
          std::max_element(likely.begin(), likely.end(),
                           [](const Likely& a, const Likely& c) { return a.squared < c.squared; });
      if (squared < farthest->squared) *farthest = {z.subject, squared};
    }
    of.least[at(s)] = Association::cost_of_none;
    for (const Likely& one : likely) {
      z.subject = one.subject;
      Row row = row_of(z, pair_of(z));
      times_P(row, G);
      double white = row.m * log(2 * std::numbers::pi);
      for (int a = 0; a < row.m; ++a) white += log(row.R(a, a));
      of.least[at(s)] = std::min(of.least[at(s)], white);
      of.candidates[at(s)].push_back({one.subject, row, G});
      G += 2 * capacity_;
    }
  }
  of.search(0, 0, 0.0);
  std::array<int, frame_max> subjects;
  for (int s = 0; s < of.sightings; ++s) {
    const int k = of.sure(s);
    subjects[at(s)] =
        k == Association::none ? TeamSighting::unidentified : of.candidates[at(s)][at(k)].subject;
  }
  for (int s = 0; s < static_cast<int>(frame.size()); ++s) {
    fits[at(s)] = {FitVerdict::rejected};
    TeamSighting z = frame[at(s)];
    z.subject = s < of.sightings ? subjects[at(s)] : TeamSighting::unidentified;
    if (z.subject != TeamSighting::unidentified) {
      fits[at(s)] = take(z);
      if (fits[at(s)].verdict == FitVerdict::accepted)
        observer.contradictions = std::max(0, observer.contradictions - 2);
    } else if (is_usable(z) && s < of.sightings && of.candidates[at(s)].empty()) {
      ++observer.contradictions;
      refuse(z);
    }
  }
  if (observer.contradictions >= noise_.restart_sightings && find(frame[0].observer))
    observer.contradictions = 0;
}

}  // namespace sightline
