#include "sightline/estimate/team_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sightline/estimate/kalman.hpp"

namespace sightline {
namespace {

// States of a robot, after RobotState, and of a pair.
enum State { x, y, psi, s_v, s_r, c, b, delta, alpha, mu, s_d, gamma, eps, o, s_b };
enum PairState { rho, eta };
static_assert(s_b + 1 == robot_states && s_b == static_cast<int>(RobotState::bearing_scale));

constexpr double longest_filter_step = 0.1;  // [s], of one linearisation
constexpr double faded = 5.0;                // correlation times after which a pair's errors are new ones
constexpr int pairs_per_robot = 16;          // with states at one time
constexpr double unknown_place = 1e3;        // [m]

/// A pose in the frame of a, in the frame of that frame.
PlanarPose composed(const PlanarPose& a, const PlanarPose& b) {
  const SinCos<double> e = sincos(a.psi);
  return {a.x + e.cos * b.x - e.sin * b.y, a.y + e.sin * b.x + e.cos * b.y, a.psi + b.psi};
}

}  // namespace

void TeamNoise::check() const {
  check_parameters(*this);
  if (!(range_noise > 0 || range_share > 0))
    throw std::invalid_argument("localize.range_noise = 0 m and range_share = 0, expected one of them > 0");
}

TeamFilter::TeamFilter(std::vector<double> heights, std::vector<Landmark> landmarks, const TeamNoise& noise,
                       double t0, int antennas)
    : noise_(noise),
      landmarks_(std::move(landmarks)),
      heights_(std::move(heights)),
      robots_(static_cast<int>(heights_.size())),
      antennas_(antennas),
      first_pair_(robots_ * (robot_states + antennas_ * bodies())),
      capacity_(first_pair_ + robots_ * 2 * pairs_per_robot),
      n_(first_pair_),
      x_(at(capacity_)),
      P_(at(capacity_) * at(capacity_)),
      decay_(at(capacity_), 1.0),
      G_(3 * at(capacity_)),
      candidate_G_(2 * at(frame_max * candidates_max) * at(capacity_)),
      odometry_(heights_.size()),
      lasting_(4 * at(bodies())),
      now_(t0) {
  noise_.check();
  if (robots_ == 0) throw std::invalid_argument("robots = 0, expected at least 1");
  pairs_.reserve(at(pairs_per_robot * robots_));
  for (int i = 0; i < robots_; ++i) {
    const int k = i * robot_states;
    for (const auto& [state, sigma] : {std::pair{x, unknown_place},
                                       {y, unknown_place},
                                       {psi, 2.0},
                                       {s_v, noise_.speed_scale},
                                       {s_r, noise_.turn_scale},
                                       {c, noise_.turn_loss},
                                       {b, noise_.yaw_rate_bias},
                                       {delta, noise_.clock_offset},
                                       {alpha, noise_.wheel_turn},
                                       {mu, noise_.sensor_turn},
                                       {s_d, noise_.range_scale},
                                       {gamma, noise_.range_depth},
                                       {eps, noise_.axis_turn},
                                       {o, noise_.range_offset},
                                       {s_b, noise_.bearing_scale}})
      P(k + state, k + state) = square(sigma);
    for (int a = 0; a < antennas_; ++a)
      for (int body = 0; body < bodies(); ++body) {
        const int error = antenna_index(i, a, body);
        P(error, error) = 0.5 * square(noise_.antenna_error);
      }
  }
}

void TeamFilter::start(int robot, const PoseGuess& guess) noexcept {
  const int k = robot * robot_states;
  for (int i = k; i < k + 3; ++i)
    for (int j = 0; j < n_; ++j) P(i, j) = P(j, i) = 0.0;
  x_[at(k + x)] = guess.pose.x, x_[at(k + y)] = guess.pose.y, x_[at(k + psi)] = guess.pose.psi;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) P(k + i, k + j) = guess.P(i, j);
}

void TeamFilter::take(int robot, const WheelOdometry& sample) noexcept {
  Robot& of = odometry_[at(robot)];
  if (!(std::isfinite(sample.t) && std::isfinite(sample.v) && std::isfinite(sample.yaw_rate))) return;
  if (of.count > 0) {
    const WheelOdometry& last = of[of.count - 1];
    const double held = sample.t - last.t;
    if (held <= 0) return;
    if (held <= gap()) {
      driven_ += held * square(last.v), turned_ += held * square(last.yaw_rate), covered_ += held;
      ++intervals_;
    }
  }
  if (of.count == of.ring.size()) {
    of.first = (of.first + 1) % of.ring.size();
    --of.count;
  }
  of.ring[(of.first + of.count++) % of.ring.size()] = sample;
}

/// Longest age of odometry that still holds: some recorders write changes of the motion alone.
double TeamFilter::gap() const noexcept {
  constexpr double enough = 10.0, mean_intervals = 8.0;
  if (intervals_ < enough) return infinity;
  return std::max(noise_.odometry_gap, mean_intervals * covered_ / intervals_);
}

void TeamFilter::advance(double t) noexcept {
  if (!(t > now_) || !std::isfinite(t)) return;
  const int steps = static_cast<int>(std::min(std::ceil((t - now_) / longest_filter_step), 1e6));
  const double dt = (t - now_) / steps;
  for (int i = 0; i < steps; ++i) step(dt);
  now_ = t;
}

void TeamFilter::step(double dt) noexcept {
  for (int i = 0; i < robots_; ++i) move(i, dt);
  now_ += dt;
  const double kept = faded * std::max(noise_.range_error_time, noise_.bearing_error_time);
  for (int k = static_cast<int>(pairs_.size()) - 1; k >= 0; --k)
    if (now_ - pairs_[at(k)].seen > kept) drop_pair(k);
  fade(dt);
}

/// Lasting errors of the pairs: e' = a e + w, a = exp(-dt / tau), E w^2 = sigma^2 (1 - a^2).
void TeamFilter::fade(double dt) noexcept {
  const std::array a = {exp(-dt / noise_.range_error_time), exp(-dt / noise_.bearing_error_time)};
  const std::array sigma = {noise_.range_error, noise_.bearing_error};
  const int first = first_pair_;
  for (int i = first; i < n_; ++i) decay_[at(i)] = a[at((i - first) % 2)];
  for (int i = first; i < n_; ++i) {
    x_[at(i)] *= decay_[at(i)];
    for (int j = 0; j < first; ++j) P(j, i) = P(i, j) *= decay_[at(i)];
    for (int j = first; j < n_; ++j) P(i, j) *= decay_[at(i)] * decay_[at(j)];
    P(i, i) += square(sigma[at((i - first) % 2)]) * (1 - square(decay_[at(i)]));
  }
}

/// Propagates one robot by the odometry of [now - delta, now - delta + dt].
///
/// With the pose T(s) that the odometry alone gives at its time s, the robot moves by
/// T(s_0)^-1 T(s_1). So a change of delta changes its displacement by the body velocities at both
/// ends: d psi = r_0 - r_1, d p = v_0 + r_0 e_z x (p_1 - p_0) - v_1. Those at the start are those of
/// the previous step's end, also if a sample falls between the two.
void TeamFilter::move(int robot, double dt) noexcept {
  const int k = robot * robot_states;
  Robot& of = odometry_[at(robot)];
  double* const s = &x_[at(k)];
  const double from = now_ - s[delta], until = from + dt;
  const double x0 = s[x], y0 = s[y], psi_0 = s[psi];
  const SinCos<double> e0 = sincos(s[psi] + s[alpha]);
  const Vec2<double> v_0{of.v * e0.cos, of.v * e0.sin};
  const double r_0 = of.yaw_rate;
  Vec2<double> per_v{}, per_r{}, per_c{}, per_b{};  // d p / d s_v, s_r, c, b
  double turned_m = 0.0, driven = 0.0, turned = 0.0, unknown = 0.0;
  Mat<2, 2> Q{};
  // In a gap v and r are as likely as any of the drive, so they differ from the last ones by twice their
  // mean square, and as these errors last, by that times age^2 in the pose.
  const double longest = gap();
  const auto squared_gap = [&](double age) { return age > longest ? square(age) : 0.0; };
  const auto differing = [&](double integral) { return covered_ > 0 ? 2 * integral / covered_ : 0.0; };
  std::size_t i = of.count;
  while (i > 0 && of[i - 1].t > from) --i;  // before the first sample the robot is at rest
  for (double t = from; t < until; ++i) {
    const WheelOdometry u = i > 0 ? of[i - 1] : WheelOdometry{};
    const double end = i < of.count ? std::min(of[i].t, until) : until, h = end - t;
    const double ideal = (1 + s[s_v]) * u.v, lost = s[c] * std::abs(u.yaw_rate);
    const bool drives = u.v != 0 && std::abs(ideal) > lost;  // a turn on the spot loses nothing
    const double per_c_v = drives ? -std::copysign(std::abs(u.yaw_rate), ideal) : 0.0;
    const double v = drives ? ideal + s[c] * per_c_v : 0.0, r = (1 + s[s_r]) * u.yaw_rate + s[b];
    const double middle = s[psi] + s[alpha] + 0.5 * h * r;
    const SinCos<double> e = sincos(middle);
    const Vec2<double> left{-h * v * e.sin, h * v * e.cos};  // d (displacement) / d heading
    if (drives) per_v = {per_v.x + h * u.v * e.cos, per_v.y + h * u.v * e.sin};
    per_c = {per_c.x + h * per_c_v * e.cos, per_c.y + h * per_c_v * e.sin};
    const double by_r = turned_m + 0.5 * h * u.yaw_rate, by_b = t - from + 0.5 * h;
    per_r = {per_r.x + left.x * by_r, per_r.y + left.y * by_r};
    per_b = {per_b.x + left.x * by_b, per_b.y + left.y * by_b};
    s[x] += h * v * e.cos, s[y] += h * v * e.sin, s[psi] += h * r;
    turned_m += h * u.yaw_rate;
    const double along = square(noise_.distance_noise) * std::abs(h * v),
                 across = square(noise_.skid_noise) * std::abs(h * v);
    Q(0, 0) += along * e.cos * e.cos + across * e.sin * e.sin;
    Q(1, 1) += along * e.sin * e.sin + across * e.cos * e.cos;
    Q(0, 1) += (along - across) * e.cos * e.sin;
    driven += std::abs(h * v), turned += std::abs(h * u.yaw_rate);
    if (i > 0) unknown += squared_gap(end - u.t) - squared_gap(t - u.t);
    if (end == until) of.v = v, of.yaw_rate = r;
    t = end;
  }
  of.path = composed(of.path, relative_to({x0, y0, psi_0}, {s[x], s[y], s[psi]}));
  const SinCos<double> e1 = sincos(s[psi] + s[alpha]);
  const Vec2<double> v_1{of.v * e1.cos, of.v * e1.sin};
  const double r_1 = of.yaw_rate;
  const double dx = s[x] - x0, dy = s[y] - y0;
  // Rows of F - 1: x, y, psi over psi, s_v, s_r, c, b, delta, alpha.
  const std::array<std::array<double, 7>, 3> F = {
      {{-dy, per_v.x, per_r.x, per_c.x, per_b.x, v_0.x - r_0 * dy - v_1.x, -dy},
       {dx, per_v.y, per_r.y, per_c.y, per_b.y, v_0.y + r_0 * dx - v_1.y, dx},
       {0.0, 0.0, turned_m, 0.0, dt, r_0 - r_1, 0.0}}};
  for (int j = 0; j < n_; ++j)
    for (std::size_t a = 0; a < 3; ++a) {
      double sum = P(k + static_cast<int>(a), j);
      for (int l = 0; l < 7; ++l) sum += F[a][at(l)] * P(k + psi + l, j);
      P(k + static_cast<int>(a), j) = sum;
    }
  for (int j = 0; j < n_; ++j)
    for (std::size_t a = 0; a < 3; ++a) {
      if (j >= k && j < k + robot_states) {
        double sum = P(j, k + static_cast<int>(a));
        for (int l = 0; l < 7; ++l) sum += F[a][at(l)] * P(j, k + psi + l);
        P(j, k + static_cast<int>(a)) = sum;
      } else {
        P(j, k + static_cast<int>(a)) = P(k + static_cast<int>(a), j);
      }
    }
  const double walk = square(noise_.position_walk) * dt + differing(driven_) * unknown;
  P(k + x, k + x) += Q(0, 0) + walk;
  P(k + y, k + y) += Q(1, 1) + walk;
  P(k + x, k + y) += Q(0, 1), P(k + y, k + x) = P(k + x, k + y);
  P(k + psi, k + psi) += square(noise_.curve_noise) * driven + square(noise_.turn_noise) * turned +
                         square(noise_.heading_walk) * dt + differing(turned_) * unknown;
  P(k + b, k + b) += square(noise_.yaw_rate_walk) * dt;
}

/// Index of the pair of a sighting, or -1.
int TeamFilter::pair_of(const TeamSighting& z) const noexcept {
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const Pair& one = pairs_[k];
    if (one.observer == z.observer && one.subject == z.subject) return static_cast<int>(k);
  }
  return -1;
}

/// The pair of a sighting; a new one begins with stationary errors.
int TeamFilter::pair_for(const TeamSighting& z) noexcept {
  if (const int known = pair_of(z); known >= 0) {
    pairs_[at(known)].seen = now_;
    return known;
  }
  if (pairs_.size() == pairs_.capacity()) {
    const auto oldest = std::min_element(pairs_.begin(), pairs_.end(),
                                         [](const Pair& a, const Pair& c) { return a.seen < c.seen; });
    drop_pair(static_cast<int>(oldest - pairs_.begin()));
  }
  pairs_.push_back({z.observer, z.subject, now_});
  const std::array sigma = {noise_.range_error, noise_.bearing_error};
  for (const double of : sigma) {
    for (int j = 0; j < n_; ++j) P(n_, j) = P(j, n_) = 0.0;
    x_[at(n_)] = 0.0;
    P(n_, n_) = square(of);
    ++n_;
  }
  return static_cast<int>(pairs_.size()) - 1;
}

/// Removes a pair; the last one takes its place.
void TeamFilter::drop_pair(int pair) noexcept {
  const int to = first_pair_ + 2 * pair, from = n_ - 2;
  if (to != from) {
    for (int a = 0; a < 2; ++a) {
      x_[at(to + a)] = x_[at(from + a)];
      for (int j = 0; j < n_; ++j) P(to + a, j) = P(from + a, j);
    }
    for (int a = 0; a < 2; ++a)
      for (int j = 0; j < n_; ++j) P(j, to + a) = P(j, from + a);
    pairs_[at(pair)] = pairs_.back();
  }
  pairs_.pop_back();
  n_ -= 2;
}

/// Linearises a sighting of a known subject. Without a pair its lasting errors are part of R.
TeamFilter::Row TeamFilter::row_of(const TeamSighting& z, int pair) noexcept {
  using In = RangeBearing::Input;
  constexpr int width = RangeBearing::estimated;
  std::array<int, width> state;
  state.fill(-1);
  std::array<double, RangeBearing::inputs> in{};
  const int i = z.observer * robot_states;
  state[In::x_i] = i + x, state[In::y_i] = i + y, state[In::psi_i] = i + psi, state[In::mu] = i + mu;
  state[In::s_d] = i + s_d, state[In::gamma] = i + gamma, state[In::eps] = i + eps, state[In::o] = i + o,
  state[In::s_b] = i + s_b;
  double height = heights_[at(z.observer)];
  if (z.subject < robots_) {
    const int j = z.subject * robot_states;
    state[In::x_j] = j + x, state[In::y_j] = j + y, state[In::psi_j] = j + psi;
    height = heights_[at(z.subject)] - height;
  } else {
    const Landmark& mark = landmarks_[at(z.subject - robots_)];
    in[In::x_j] = mark.x, in[In::y_j] = mark.y;
    height = mark.z - height;
  }
  if (pair >= 0) {
    state[In::rho] = first_pair_ + 2 * pair + rho;
    state[In::eta] = first_pair_ + 2 * pair + eta;
  }
  for (std::size_t l = 0; l < width; ++l)
    if (state[l] >= 0) in[l] = x_[at(state[l])];
  in[In::a_i_x] = z.sensor.x, in[In::a_i_y] = z.sensor.y;
  in[In::a_j_x] = z.point.x, in[In::a_j_y] = z.point.y;
  in[In::h] = height + z.point.z - z.sensor.z;
  const SightingModel::Expected expected = model_(in);

  Row row;
  std::array<std::size_t, width> input_of;
  for (std::size_t l = 0; l < width; ++l) {
    if (state[l] < 0) continue;
    input_of[at(row.used)] = l;
    row.columns[at(row.used++)] = state[l];
  }
  double range = expected.value[0];
  const int linearised = row.used;
  if (z.of == Sighted::range)
    for (const auto& [robot, antenna] : {std::pair{z.observer, z.antenna}, {z.subject, z.other_antenna}}) {
      if (antenna < 0) continue;
      for (const int body : {z.observer, z.subject}) {
        const int error = antenna_index(robot, antenna, body);
        row.H(0, row.used) = 1.0;
        row.columns[at(row.used++)] = error;
        range += x_[at(error)];
      }
    }
  for (int a = 0; a < 2; ++a) {
    if (z.of == Sighted::range && a == 1) continue;
    if (z.of == Sighted::bearing && a == 0) continue;
    const int m = row.m++;
    for (int l = 0; l < linearised; ++l) row.H(m, l) = expected.H(a, static_cast<int>(input_of[at(l)]));
    row.y(m, 0) = a == 0 ? z.range - range : wrap(z.bearing - expected.value[1]);
    row.R(m, m) = a == 0 ? square(noise_.range_noise) + square(noise_.range_share * range)
                         : square(noise_.bearing_noise);
    if (pair < 0) row.R(m, m) += a == 0 ? square(noise_.range_error * range) : square(noise_.bearing_error);
  }
  return row;
}

/// G = H P, a row for each component.
void TeamFilter::times_P(const Row& row, double* G) const noexcept {
  const std::size_t stride = at(capacity_);
  for (int a = 0; a < row.m; ++a) {
    double* const g = G + at(a) * stride;
    std::fill_n(g, n_, 0.0);
    for (int l = 0; l < row.used; ++l) {
      const double h = row.H(a, l);
      const double* const p = &P_[at(row.columns[at(l)]) * stride];
      for (int j = 0; j < n_; ++j) g[j] += h * p[j];
    }
  }
}

/// Kalman update with a gate: G = H P, S = H P H^T + R = L L^T, W = L^-1 G, x <- x + W^T L^-1 y,
/// P <- P - W^T W, which keeps P symmetric.
TeamFit TeamFilter::apply(const Row& row) noexcept {
  TeamFit fit{FitVerdict::rejected};
  fit.dimension = row.m;
  Mat<3, 3> S = row.R;
  for (int a = row.m; a < 3; ++a) S(a, a) = 1.0;
  double* const G = G_.data();
  const std::size_t stride = at(capacity_);
  times_P(row, G);
  for (int a = 0; a < row.m; ++a)
    for (int c = 0; c < row.m; ++c)
      for (int l = 0; l < row.used; ++l) S(a, c) += G[at(a) * stride + at(row.columns[at(l)])] * row.H(c, l);
  const Cholesky<3> factor(S);
  if (!factor.positive) return fit;
  const Column<3> white = factor.forward(row.y);
  for (int a = 0; a < row.m; ++a) {
    fit.squared += square(white(a, 0));
    fit.log_det += 2 * log(factor.L(a, a));
    if (a < 2) fit.y[at(a)] = row.y(a, 0), fit.white[at(a)] = white(a, 0);
  }
  const double gate = row.m == 1   ? chi_squared_gate<1>
                      : row.m == 2 ? chi_squared_gate<2>
                                   : chi_squared_gate<3>;
  if (!(fit.squared <= gate)) return fit;
  for (int a = 0; a < row.m; ++a) {
    double* const w = G + at(a) * stride;
    for (int c = 0; c < a; ++c) {
      const double* const above = G + at(c) * stride;
      for (int j = 0; j < n_; ++j) w[j] -= factor.L(a, c) * above[j];
    }
    const double scale = 1.0 / factor.L(a, a);
    for (int j = 0; j < n_; ++j) w[j] *= scale;
    for (int j = 0; j < n_; ++j) x_[at(j)] += w[j] * white(a, 0);
  }
  for (int i = 0; i < n_; ++i) {
    double* const p = &P_[at(i) * stride];
    for (int a = 0; a < row.m; ++a) {
      const double* const w = G + at(a) * stride;
      const double wi = w[i];
      for (int j = 0; j < n_; ++j) p[j] -= wi * w[j];
    }
  }
  fit.verdict = FitVerdict::accepted;
  return fit;
}

/// Wheels slip, so the heading jumps by more than the noise of the odometry. A bearing shows a slip
/// where that is the likelier reason than chance (99 %), up to a slip that is possible at all. The
/// variance of the heading grows by the excess. A bearing beyond the gate may be false, so it waits
/// until the next one shows the same slip.
TeamFilter::Slip TeamFilter::slip_of(const Row& row, int robot) noexcept {
  constexpr double slip_max = 0.3, likely = 6.635;  // [rad], chi^2 of one degree of freedom
  constexpr double agreed = 5.0;                    // [s], between two bearings of one slip
  const int bearing = row.m - 1, heading = robot * robot_states + psi;
  double S = row.R(bearing, bearing), apart = S;
  for (int k = 0; k < row.used; ++k)
    for (int l = 0; l < row.used; ++l) {
      const double part = row.H(bearing, k) * P(row.columns[at(k)], row.columns[at(l)]) * row.H(bearing, l);
      S += part;
      if (row.columns[at(k)] != heading && row.columns[at(l)] != heading) apart += part;
    }
  const double y = row.y(bearing, 0), squared = square(y);
  const double excess = std::min(squared - S, square(slip_max));
  if (!(squared > likely * S && squared < likely * (S + excess))) return Slip::none;
  Robot& of = odometry_[at(robot)];
  const bool same = now_ - of.slip_seen < agreed && square(y - of.slip) < likely * (apart + of.slip_variance);
  const bool unseen =
      of.refusals == 0 && now_ - of.accepted > 1.0;        // so long, a slip is likelier than chance
  const bool within = squared <= chi_squared_gate<2> * S;  // a false one among them does little
  of.slip = y, of.slip_variance = apart, of.slip_seen = same || unseen || within ? -infinity : now_;
  if (!same && !unseen && !within) return Slip::shown;
  P(heading, heading) += excess;
  return Slip::admitted;
}

/// y^T S^-1 y of a measurement; infinite where S is not positive definite.
double TeamFilter::squared_distance(const Row& row) const noexcept {
  Mat<3, 3> S = row.R;
  Column<3> y = row.y;
  for (int a = row.m; a < 3; ++a) S(a, a) = 1.0, y(a, 0) = 0.0;
  for (int a = 0; a < row.m; ++a)
    for (int c = 0; c < row.m; ++c)
      for (int k = 0; k < row.used; ++k)
        for (int l = 0; l < row.used; ++l)
          S(a, c) += row.H(a, k) * P(row.columns[at(k)], row.columns[at(l)]) * row.H(c, l);
  return mahalanobis(y, S);
}

/// Keeps a refused sighting. After many in a row that one pose nearby explains, the estimate is wrong.
void TeamFilter::refuse(const TeamSighting& z) noexcept {
  Robot& of = odometry_[at(z.observer)];
  of.refused[at(of.refusals++ % refused_sightings_max)] = {
      z, of.path, z.subject >= 0 && z.subject < robots_ ? odometry_[at(z.subject)].path : PlanarPose{}};
  if (z.subject >= 0 && of.refusals >= noise_.restart_sightings) agree(z.observer);
}

/// Starts a robot again where one pose near the estimate explains its last refused sightings, which
/// false ones do not have.
void TeamFilter::agree(int robot) noexcept {
  const Robot& of = odometry_[at(robot)];
  std::array<TeamSighting, refused_sightings_max> frame;
  const auto count = at(noise_.restart_sightings);
  for (std::size_t i = 0; i < count; ++i)
    frame[i] = moved(of.refused[(at(of.refusals) - 1 - i) % at(refused_sightings_max)]);
  Mat<3, 3> P;
  for (int a = 0; a < 3; ++a)
    P(a, a) = square(a < 2 ? wrong_position : wrong_heading) +
              this->P(index(robot, RobotState::x) + a, index(robot, RobotState::x) + a);
  const PlanarPose here = pose(robot).pose;
  if (const auto found = fit_near(robot, {frame.data(), count}, {here, P}, here)) restart(robot, *found);
}

/// Starts a robot at a pose from refused sightings; dead reckoning between them has errors, too.
void TeamFilter::restart(int robot, PoseGuess found) noexcept {
  constexpr double reckoned_m = 0.1, reckoned_rad = 0.1;
  for (int a = 0; a < 3; ++a) found.P(a, a) += square(a < 2 ? reckoned_m : reckoned_rad);
  start(robot, found);
  odometry_[at(robot)].refusals = 0;
}

/// Maximum a posteriori of the pose of a robot from identified sightings by it, by Gauss-Newton from a
/// pose. Sightings of one body share its lasting error, so together they count as one. Empty where
/// they do not fit.
std::optional<PoseGuess> TeamFilter::fit_near(int robot, std::span<const TeamSighting> frame,
                                              const PoseGuess& prior, const PlanarPose& from) noexcept {
  constexpr int iterations = 8;
  const int k = robot * robot_states;
  const std::array before = {x_[at(k)], x_[at(k + 1)], x_[at(k + 2)]};
  const Cholesky<3> prior_factor(prior.P);
  if (!prior_factor.positive) return {};
  const Mat<3, 3> weight = prior_factor.solve(identity<3>());
  x_[at(k)] = from.x, x_[at(k + 1)] = from.y, x_[at(k + 2)] = from.psi;
  double cost = infinity;
  int components = 0;
  PoseGuess found;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const Column<3> off = {{{{prior.pose.x - x_[at(k)]},
                             {prior.pose.y - x_[at(k + 1)]},
                             {wrap(prior.pose.psi - x_[at(k + 2)])}}}};
    Mat<3, 3> information = weight;
    Column<3> slope = weight * off;
    cost = mahalanobis(off, prior.P), components = 0;
    for (const TeamSighting& z : frame) {
      const Row row = row_of(z, -1);
      const auto shared = std::count_if(frame.begin(), frame.end(),
                                        [&](const TeamSighting& one) { return one.subject == z.subject; });
      for (int a = 0; a < row.m; ++a, ++components) {
        Column<3> H;
        double w = row.R(a, a);
        for (int l = 0; l < row.used; ++l) {
          const int j = row.columns[at(l)] - k;
          if (j >= 0 && j < 3) {
            H(j, 0) = row.H(a, l);
          } else {
            w += square(row.H(a, l)) * P(row.columns[at(l)], row.columns[at(l)]);
          }
        }
        cost += square(row.y(a, 0)) / w;
        w *= static_cast<double>(shared);
        information += (1 / w) * (H * transposed(H));
        slope += (row.y(a, 0) / w) * H;
      }
    }
    const Cholesky<3> factor(information);
    if (!factor.positive || !std::isfinite(cost)) {
      cost = infinity;
      break;
    }
    found = {{x_[at(k)], x_[at(k + 1)], x_[at(k + 2)]}, factor.solve(identity<3>())};
    const Column<3> d = factor.solve(slope);
    for (int a = 0; a < 3; ++a) x_[at(k + a)] += d(a, 0);
  }
  for (int a = 0; a < 3; ++a) x_[at(k + a)] = before[at(a)];
  if (!(cost <= sum_gate(components))) return {};
  return found;
}

/// What a sensor measures of a distance at a bearing, as far as it measures depths.
double TeamFilter::depth_share(int robot, double bearing) const noexcept {
  const int i = robot * robot_states;
  return 1 + x_[at(i + gamma)] * (cos(bearing - x_[at(i + eps)]) - 1);
}

/// A refused sighting as if it were of the present time: its sensor and its point are where they were.
TeamSighting TeamFilter::moved(const Refused& one) const noexcept {
  TeamSighting z = one.z;
  const auto moved_by = [](const PlanarPose& then, const PlanarPose& now, Vec3<double>& place) {
    const PlanarPose back = relative_to(now, then);
    const SinCos<double> e = sincos(back.psi);
    place = {back.x + e.cos * place.x - e.sin * place.y, back.y + e.sin * place.x + e.cos * place.y, place.z};
    return back.psi;
  };
  const double turned = moved_by(one.observer, odometry_[at(z.observer)].path, z.sensor);
  if (z.subject >= 0 && z.subject < robots_) moved_by(one.subject, odometry_[at(z.subject)].path, z.point);
  // Ranges are depths along the axis, which has turned.
  z.range *= depth_share(z.observer, z.bearing + turned) / depth_share(z.observer, z.bearing);
  z.bearing += turned;
  return z;
}

/// The pose may be wrong by more than it claims.
void TeamFilter::widen(int robot) noexcept {
  const int k = robot * robot_states;
  P(k + x, k + x) += square(wrong_position);
  P(k + y, k + y) += square(wrong_position);
  P(k + psi, k + psi) += square(wrong_heading);
  odometry_[at(robot)].refusals = 0;
}

bool TeamFilter::is_usable(const TeamSighting& z) const noexcept {
  return (z.of == Sighted::bearing || (std::isfinite(z.range) && z.range > 0)) &&
         (z.of == Sighted::range || std::isfinite(z.bearing)) && is_finite(z.sensor) && is_finite(z.point) &&
         z.observer >= 0 && z.observer < robots_ && z.subject < bodies() && z.subject != z.observer &&
         z.antenna < antennas_ && z.other_antenna < antennas_ && (z.other_antenna < 0 || z.subject < robots_);
}

TeamFit TeamFilter::take(const TeamSighting& z) noexcept {
  if (!is_usable(z) || z.subject < 0) return {FitVerdict::unusable, z.subject};
  const int pair = pair_for(z);
  const Slip slip = z.of == Sighted::range ? Slip::none : slip_of(row_of(z, pair), z.observer);
  TeamFit fit{FitVerdict::rejected};
  if (slip != Slip::shown) fit = apply(row_of(z, pair));
  fit.slipped = slip == Slip::admitted;
  fit.subject = z.subject;
  if (fit.verdict == FitVerdict::accepted) {
    odometry_[at(z.observer)].refusals = 0;
    odometry_[at(z.observer)].accepted = now_;
    odometry_[at(z.observer)].slip_seen = -infinity;
  } else {
    refuse(z);
  }
  return fit;
}

TeamFit TeamFilter::take_pose(int robot, const PoseGuess& known) noexcept {
  double sum = known.pose.x + known.pose.y + known.pose.psi;  // not finite if one of them is not
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum += known.P(i, j);
  if (!std::isfinite(sum)) return {FitVerdict::unusable};
  const int k = robot * robot_states;
  Row row;
  row.m = row.used = 3;
  for (int a = 0; a < 3; ++a) row.columns[at(a)] = k + a, row.H(a, a) = 1.0;
  row.y = {{{{known.pose.x - x_[at(k + x)]},
             {known.pose.y - x_[at(k + y)]},
             {wrap(known.pose.psi - x_[at(k + psi)])}}}};
  row.R = known.P;
  TeamFit fit = apply(row);
  if (fit.verdict == FitVerdict::rejected) {  // the pose is known, so the estimate is wrong
    widen(robot);
    fit = apply(row);
  }
  return fit;
}

PoseGuess TeamFilter::pose(int robot) const noexcept {
  const int k = robot * robot_states;
  PoseGuess of{{x_[at(k + x)], x_[at(k + y)], wrap(x_[at(k + psi)])}, {}};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) of.P(i, j) = P(k + i, k + j);
  return of;
}

double TeamFilter::sigma(int robot, RobotState k) const noexcept {
  const int i = index(robot, k);
  return sqrt(std::max(P(i, i), 0.0));
}

}  // namespace sightline
