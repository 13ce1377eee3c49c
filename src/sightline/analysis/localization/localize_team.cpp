#include "sightline/analysis/localization/localize_team.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>

#include "sightline/analysis/localization/consistency.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

constexpr double tick = 0.1, relative_tick = 1.0;          // [s], of estimates
constexpr double wide_position = 1.0, wide_heading = 0.5;  // [m], [rad]: beyond linearisation
constexpr double frame_sigma = 1e-3;                       // [m], [rad], of the robot that is the frame
constexpr int contradictions = 4;  // more refused than twice the accepted sightings of one time

Mat<3, 3> same_variances(double sigma) {
  Mat<3, 3> P;
  for (int i = 0; i < 3; ++i) P(i, i) = square(sigma);
  return P;
}

/// Standardised innovations of one observer, by pairs.
class InnovationSeries {
 public:
  void add(const TeamSighting& z, double white) {
    series_[{z.subject, z.sensor.x, z.sensor.y, z.point.x, z.point.y}].push_back({z.stamp, white});
  }
  InnovationStatistics statistics() const {
    InnovationStatistics of;
    double squares = 0.0;
    std::array<double, std::size(edges)> products{}, lags{};
    std::array<std::size_t, std::size(edges)> counts{};
    for (const auto& [key, list] : series_) {
      for (std::size_t i = 0; i < list.size(); ++i) {
        squares += square(list[i].white), ++of.count;
        for (std::size_t j = i + 1; j < list.size() && j - i <= farthest; ++j) {
          const double lag = list[j].t - list[i].t;
          const auto bin =
              static_cast<std::size_t>(std::lower_bound(edges.begin(), edges.end(), lag) - edges.begin());
          if (bin == edges.size()) break;
          products[bin] += list[i].white * list[j].white, lags[bin] += lag, ++counts[bin];
        }
      }
    }
    if (of.count == 0) return of;
    of.mean_square = squares / static_cast<double>(of.count);
    for (std::size_t b = 0; b < edges.size(); ++b) {
      if (counts[b] < 50) continue;
      const auto n = static_cast<double>(counts[b]);
      of.autocorrelation.push_back({lags[b] / n, products[b] / n / of.mean_square, 1.96 / sqrt(n)});
    }
    return of;
  }

 private:
  static constexpr std::array edges = {0.35, 0.75, 1.5, 3.0, 6.0, 12.0, 24.0};  // [s]
  static constexpr std::size_t farthest = 100;
  struct Value {
    double t, white;
  };
  std::map<std::tuple<int, double, double, double, double>, std::vector<Value>> series_;
};

/// Sums of one robot's errors.
struct ErrorSums {
  double squared = 0.0, heading = 0.0, variance = 0.0, most = 0.0;
  std::vector<double> nees{};
};

class TeamRunner {
 public:
  TeamRunner(const TeamRecording& recording, const TeamRun& run, TeamEstimates* to)
      : recording_(recording),
        run_(run),
        to_(to),
        robots_(static_cast<int>(recording.robots.size())),
        filter_(heights(recording), marks(recording), run.noise, recording.start, recording.antennas),
        random_(run.seed, StreamId::position_noise, 0),
        fed_(recording.robots.size()),
        is_started_(recording.robots.size()),
        sums_(recording.robots.size()),
        range_(recording.robots.size()),
        bearing_(recording.robots.size()) {
    result_.robots.resize(recording.robots.size());
  }

  TeamLocalization go() {
    begin();
    std::size_t next = 0;
    double anchored = recording_.start;
    std::int64_t ticks = 0;
    const std::vector<TeamSighting>& all = recording_.sightings;
    for (;;) {
      const double seen = next < all.size() ? all[next].stamp : infinity;
      const double shown =
          recording_.start + (recording_.relative ? relative_tick : tick) * static_cast<double>(ticks);
      const double anchor_due = run_.anchor == TeamRun::no_robot ? infinity : anchored;
      const double now = std::min({seen, shown, anchor_due});
      if (now > recording_.end) break;
      advance(now);
      if (anchor_due == now) {
        tell_anchor(now);
        anchored += 1 / TeamRun::anchor_rate;
      }
      if (seen == now) {
        const std::size_t first = next;
        while (next < all.size() && all[next].stamp == now) ++next;
        take({all.data() + first, next - first});
      }
      if (shown == now) {
        compare(now);
        ++ticks;
      }
    }
    return finished();
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  static std::vector<double> heights(const TeamRecording& recording) {
    std::vector<double> all;
    for (const auto& robot : recording.robots) all.push_back(robot.height);
    return all;
  }
  static std::vector<TeamFilter::Landmark> marks(const TeamRecording& recording) {
    std::vector<TeamFilter::Landmark> all;
    for (const auto& mark : recording.landmarks) all.push_back(mark.place);
    return all;
  }

  /// A true pose with the error of a known one.
  PoseGuess known(const PlanarPose& truth) {
    const double s = TeamRun::pose_noise, dx = s * random_.normal(), dy = s * random_.normal();
    return {{truth.x + dx, truth.y + dy, wrap(truth.psi + s * random_.normal())}, same_variances(s)};
  }

  void begin() {
    for (int i = 0; i < robots_; ++i) {
      if (recording_.relative && i == 0) {
        filter_.start(i, {{}, same_variances(frame_sigma)}), is_started_[at(i)] = true;
        continue;
      }
      if (!run_.start_known) continue;
      const auto there = truth(i, recording_.start);
      if (!there)
        throw std::invalid_argument("the pose of " + recording_.robots[at(i)].name +
                                    " at the start is unknown, expected --start unknown");
      filter_.start(i, known(*there)), is_started_[at(i)] = true;
    }
  }

  void advance(double t) {
    for (int i = 0; i < robots_; ++i) {
      const std::vector<WheelOdometry>& all = recording_.robots[at(i)].odometry;
      while (fed_[at(i)] < all.size() && all[fed_[at(i)]].t <= t) filter_.take(i, all[fed_[at(i)]++]);
    }
    filter_.advance(t);
    if (recording_.relative) (void)filter_.take_pose(0, {{}, same_variances(frame_sigma)});
  }

  void tell_anchor(double t) {
    if (const auto truth = recording_.truth(run_.anchor, t)) {
      if (is_started_[at(run_.anchor)]) {
        (void)filter_.take_pose(run_.anchor, known(*truth));
      } else {
        filter_.start(run_.anchor, known(*truth)), is_started_[at(run_.anchor)] = true;
      }
    }
  }

  bool is_used(const TeamSighting& z) const {
    const std::vector<bool>& list = z.subject < robots_ ? run_.sees_robots : run_.sees_landmarks;
    return list.empty() || list[at(z.observer)];
  }

  bool is_wide(int robot) const {
    return !is_started_[at(robot)] || filter_.sigma(robot, RobotState::x) > wide_position ||
           filter_.sigma(robot, RobotState::y) > wide_position ||
           filter_.sigma(robot, RobotState::psi) > wide_heading;
  }

  void take(std::span<const TeamSighting> at_one_time) {
    frame_.clear();
    for (const TeamSighting& z : at_one_time)
      if (is_used(z)) frame_.push_back(z);
    if (!run_.identities) {
      take_unidentified();
      return;
    }
    for (int robot = 0; robot < robots_; ++robot)
      if (is_wide(robot)) locate(robot);
    refused_.assign(at(robots_), 0);
    for (const TeamSighting& z : frame_) {
      const bool both = is_started_[at(z.observer)] && (z.subject >= robots_ || is_started_[at(z.subject)]);
      if (!both) continue;
      const TeamFit fit = filter_.take(z);
      count(z, fit);
      const int vote = fit.verdict == FitVerdict::accepted ? -2 : 1;
      refused_[at(z.observer)] += vote;
      if (z.subject < robots_) refused_[at(z.subject)] += vote;
    }
    // Most of the sightings contradict the pose, so they have another one in common, or none.
    for (int robot = 0; robot < robots_; ++robot)
      if (refused_[at(robot)] >= contradictions) relocate(robot);
  }

  void relocate(int robot) {
    if (recording_.relative && robot == 0) return;
    if (const auto found = filter_.locate(robot, frame_)) {
      filter_.start(robot, *found);
      ++result_.robots[at(robot)].located;
    }
  }

  /// Sightings that gave a robot its pose are used up by it.
  void locate(int robot) {
    const auto found = filter_.locate(robot, frame_);
    if (!found) return;
    if (is_started_[at(robot)]) {
      (void)filter_.take_pose(robot, *found);
    } else {
      filter_.start(robot, *found), is_started_[at(robot)] = true;
    }
    ++result_.robots[at(robot)].located;
    std::erase_if(frame_, [&](const TeamSighting& z) { return z.observer == robot || z.subject == robot; });
  }

  void take_unidentified() {
    for (auto first = frame_.begin(); first != frame_.end();) {
      const auto last = std::find_if(first, frame_.end(),
                                     [&](const TeamSighting& z) { return z.observer != first->observer; });
      unknown_.assign(first, last);
      for (TeamSighting& z : unknown_) z.subject = TeamSighting::unidentified;
      fits_.assign(unknown_.size(), {});
      filter_.take_unidentified(unknown_, fits_);
      for (std::size_t i = 0; i < unknown_.size(); ++i) {
        unknown_[i].subject = fits_[i].subject;
        count(unknown_[i], fits_[i]);
      }
      first = last;
    }
  }

  void count(const TeamSighting& z, const TeamFit& fit) {
    TeamLocalization::Robot& of = result_.robots[at(z.observer)];
    // A wrong sighting is anywhere within 10 m and 1 rad, one time in 50.
    constexpr double cost_of_outlier = 12.4;
    if (fit.verdict == FitVerdict::accepted) {
      ++of.accepted;
      result_.cost += fit.slipped ? cost_of_outlier : fit.squared + fit.log_det;
      std::size_t component = 0;
      if (z.of != Sighted::bearing) range_[at(z.observer)].add(z, fit.white[component++]);
      if (z.of != Sighted::range) bearing_[at(z.observer)].add(z, fit.white[component]);
    } else {
      ++(fit.subject == TeamSighting::unidentified ? of.left_out : of.rejected);
      result_.cost += cost_of_outlier;
    }
    if (to_ != nullptr) to_->fit(z, fit);
  }

  std::optional<PlanarPose> truth(int robot, double t) const {
    const auto of = recording_.truth(robot, t);
    if (!of || !recording_.relative) return of;
    const auto frame = recording_.truth(0, t);
    if (!frame) return {};
    PlanarPose pose = relative_to(*frame, *of);
    pose.psi = wrap(pose.psi);
    return pose;
  }

  void compare(double t) {
    truths_.assign(at(robots_), {});
    for (int i = 0; i < robots_; ++i) {
      if (!is_started_[at(i)]) continue;
      const PoseGuess pose = filter_.pose(i);
      truths_[at(i)] = truth(i, t);
      if (to_ != nullptr) to_->estimate(t, i, pose, truths_[at(i)]);
      if (!truths_[at(i)] || (recording_.relative && i == 0)) continue;
      const PlanarPose& is = *truths_[at(i)];
      const Column<3> e = {{{{pose.pose.x - is.x}, {pose.pose.y - is.y}, {wrap(pose.pose.psi - is.psi)}}}};
      ErrorSums& sums = sums_[at(i)];
      const double squared = square(e(0, 0)) + square(e(1, 0));
      sums.squared += squared, sums.heading += square(e(2, 0));
      sums.variance += pose.P(0, 0) + pose.P(1, 1);
      sums.most = std::max(sums.most, squared);
      sums.nees.push_back(mahalanobis(e, pose.P));
    }
    for (int i = 0; i < robots_; ++i)
      for (int j = 0; j < robots_; ++j) {
        if (i == j || !truths_[at(i)] || !truths_[at(j)]) continue;
        const PlanarPose is = relative_to(*truths_[at(i)], *truths_[at(j)]);
        const PlanarPose as = relative_to(filter_.pose(i).pose, filter_.pose(j).pose);
        relative_position_ += norm(as.x - is.x, as.y - is.y);
        relative_heading_ += std::abs(wrap(as.psi - is.psi));
        ++relative_;
      }
  }

  TeamLocalization finished() {
    ErrorSums all;
    double without = 0.0;
    std::size_t samples = 0, others = 0;
    for (int i = 0; i < robots_; ++i) {
      TeamLocalization::Robot& of = result_.robots[at(i)];
      const ErrorSums& sums = sums_[at(i)];
      of.range = range_[at(i)].statistics(), of.bearing = bearing_[at(i)].statistics();
      for (int k = 0; k < robot_states; ++k) {
        of.states[at(k)] = filter_.state(i, static_cast<RobotState>(k));
        of.sigmas[at(k)] = filter_.sigma(i, static_cast<RobotState>(k));
      }
      of.samples = sums.nees.size();
      if (of.samples == 0) continue;
      const auto n = static_cast<double>(of.samples);
      of.rmse = sqrt(sums.squared / n), of.heading_rmse = sqrt(sums.heading / n);
      of.sigma = sqrt(sums.variance / n), of.max_error = sqrt(sums.most);
      double nees = 0.0;
      for (const double one : sums.nees) nees += one;
      of.anees = nees / n;
      of.independent = independent_values(sums.nees);
      of.bounds = anees_bounds(3, of.independent);
      all.squared += sums.squared, all.heading += sums.heading, all.variance += nees;
      samples += of.samples;
      if (i != run_.anchor) without += sums.squared, others += of.samples;
    }
    const auto n = static_cast<double>(samples);
    if (samples > 0)
      result_.rmse = sqrt(all.squared / n), result_.heading_rmse = sqrt(all.heading / n),
      result_.anees = all.variance / n;
    if (others > 0) result_.rmse_without_anchor = sqrt(without / static_cast<double>(others));
    if (relative_ > 0) {
      result_.relative_position = relative_position_ / static_cast<double>(relative_);
      result_.relative_heading = relative_heading_ / static_cast<double>(relative_);
    }
    result_.seconds = recording_.end - recording_.start;
    return std::move(result_);
  }

  const TeamRecording& recording_;
  const TeamRun& run_;
  TeamEstimates* const to_;
  const int robots_;
  TeamFilter filter_;
  RandomStream random_;
  std::vector<std::size_t> fed_;  // odometry samples of each robot
  std::vector<bool> is_started_;
  std::vector<ErrorSums> sums_;
  std::vector<InnovationSeries> range_, bearing_;
  std::vector<int> refused_;  // refused sightings, less twice the accepted ones, at the present time
  std::vector<TeamSighting> frame_, unknown_;
  std::vector<TeamFit> fits_;
  std::vector<std::optional<PlanarPose>> truths_;
  double relative_position_ = 0.0, relative_heading_ = 0.0;
  std::size_t relative_ = 0;
  TeamLocalization result_;
};

}  // namespace

bool InnovationStatistics::is_white() const {
  return autocorrelation.empty() || std::abs(autocorrelation.front().value) <= autocorrelation.front().bound;
}

double InnovationStatistics::correlation_time() const {
  if (is_white() || autocorrelation.front().value <= 0) return 0.0;
  return -autocorrelation.front().lag / log(std::min(0.999, autocorrelation.front().value));
}

TeamLocalization localize_team(const TeamRecording& recording, const TeamRun& run, TeamEstimates* to) {
  return TeamRunner(recording, run, to).go();
}

}  // namespace sightline
