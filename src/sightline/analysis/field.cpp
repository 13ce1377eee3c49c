#include "sightline/analysis/field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <span>
#include <string_view>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr int free_size = FieldValue::variables;
constexpr int inputs = free_size + 3;  // and the observer's position
constexpr int outputs = 1 + free_size + free_size * (free_size + 1) / 2;
constexpr int batch = 512;

std::array<double, inputs> numbers_of(const Station& s) {
  return {s.target.x, s.target.y, s.target.z, s.psi, s.psi_target, s.observer.x, s.observer.y, s.observer.z};
}

void move(Station& s, int variable, double by) {
  const std::array<double*, free_size> of = {&s.target.x, &s.target.y, &s.target.z, &s.psi, &s.psi_target};
  *of[at(variable)] += by;
}

/// Solves (H + damping I) x = -g over the free variables; false if the matrix is not positive
/// definite.
bool newton_step(const FieldValue& f, std::span<const int> free, double damping,
                 std::array<double, free_size>& x) {
  std::array<std::array<double, free_size>, free_size> L{};
  const std::size_t n = free.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = f.at(free[i], free[j]) + (i == j ? damping : 0.0);
      for (std::size_t k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
      if (i == j && !(sum > 1e-12)) return false;
      L[i][j] = i == j ? std::sqrt(sum) : sum / L[j][j];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    double sum = -f.first[at(free[i])];
    for (std::size_t k = 0; k < i; ++k) sum -= L[i][k] * x[k];
    x[i] = sum / L[i][i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) x[i] -= L[k][i] * x[k];
    x[i] /= L[i][i];
  }
  return true;
}

double steepness(const FieldValue& f, std::span<const int> free) {
  double most = 0.0;
  for (const int v : free) most = std::max(most, std::fabs(f.first[at(v)]));
  return most;
}

/// A potential with another origin of G; its third body, if it has one, is fixed at `third`.
struct Moved {
  Potential of;
  Vec3<double> origin, third{};

  template <class S>
  Sight<S> there(Sight<S> s) const {
    s.p = {s.p.x + origin.x, s.p.y + origin.y, s.p.z + origin.z};
    s.third = {third.x, third.y, third.z};
    return s;
  }
  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b, const S& t) const {
    return of(there(a), there(b), t);
  }
  double violation(const Sight<double>& a, const Sight<double>& b, double t) const {
    return of.violation(there(a), there(b), t);
  }
  double sloped(const Sight<double>& a, const Sight<double>& b, double t) const {
    return of.sloped(there(a), there(b), t);
  }
  std::string_view name() const { return of.name(); }
  std::optional<double> kappa_A() const { return of.kappa_A(); }
  Moved sigmoid(double kappa_A) const { return {of.sharpened(kappa_A), origin, third}; }
  bool is_view() const { return of.mount() != nullptr; }
  const SensorMount& mount() const { return *of.mount(); }
  Moved seen_from(const SensorMount& mount) const { return {of.seen_from(mount), origin, third}; }
};

}  // namespace

Potential moved_to(const Vec3<double>& place, const Potential& potential) { return Moved{potential, place}; }

Vec3<double> place_at(const Team& team, BodyId body, std::span<const double> x) {
  if (x.empty()) return {};
  const std::vector<double> none(static_cast<std::size_t>(team.nu()) + 1, 0.0);
  return team.model(body).sight(x.data() + team.state_offset(body), none.data()).p;
}

std::vector<Coupling> with_thirds_at(const Team& team, std::span<const double> x) {
  std::vector<Coupling> couplings = team.couplings();
  for (Coupling& c : couplings) {
    if (c.has_third()) c.term.potential = Moved{c.term.potential, {}, place_at(team, c.third, x)};
  }
  return couplings;
}

Sight<double> observer_of(const Station& s) { return {{s.observer, {std::cos(s.psi), std::sin(s.psi)}}, {}}; }
Sight<double> target_of(const Station& s) {
  return {{s.target, {std::cos(s.psi_target), std::sin(s.psi_target)}}, {}};
}

Station seen_at(const Vec3<double>& p_S, const SensorMount* mount) {
  return {.target = mount != nullptr ? mount->point_in_F(p_S) : p_S};
}

Vec3<double> in_sensor_frame(const Station& s, const SensorMount* mount) {
  return (mount != nullptr ? *mount : SensorMount{0.0, 0.0})(observer_of(s), s.target);
}

double FieldValue::slope() const { return norm(Vec3<double>{first[0], first[1], first[2]}); }

std::array<double, 3> FieldValue::curvatures() const {
  return eigenvalues({at(0, 0), at(0, 1), at(0, 2), at(1, 1), at(1, 2), at(2, 2)});
}

std::array<double, 3> eigenvalues(const std::array<double, 6>& m) {
  const auto [xx, xy, xz, yy, yz, zz] = m;
  // Roots of the characteristic polynomial by the trigonometric method.
  const double mean = (xx + yy + zz) / 3;
  const double a = xx - mean, b = yy - mean, c = zz - mean;
  const double off = xy * xy + xz * xz + yz * yz;
  const double p = std::sqrt((a * a + b * b + c * c + 2 * off) / 6);
  if (!(p > 0)) return {mean, mean, mean};
  const double half_det =
      (a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)) / (2 * p * p * p);
  const double third = std::acos(std::clamp(half_det, -1.0, 1.0)) / 3;
  const double high = mean + 2 * p * std::cos(third);
  const double low = mean + 2 * p * std::cos(third + 2 * std::numbers::pi / 3);
  return {low, 3 * mean - low - high, high};
}

Program formula_of(const Potential& potential) {
  Graph graph;
  const std::vector<Symbol> in = variables(graph, 0, 2 * sight_size + 1);
  const Symbol l =
      potential(sight_from<Symbol>(in.data()), sight_from<Symbol>(in.data() + sight_size), in.back());
  return Program(graph, std::vector{l.in(graph)}, 2 * sight_size + 1);
}

bool sees_place(const Potential& potential) {
  constexpr int size = 2 * sight_size + 1, samples = 64;
  constexpr double reach = 10.0, rounding = 1e-9;
  Graph graph;
  const std::vector<Symbol> in = variables(graph, 0, size);
  const Symbol l =
      potential(sight_from<Symbol>(in.data()), sight_from<Symbol>(in.data() + sight_size), in.back());
  std::vector<Term> of;
  for (const int body : {0, sight_size}) {
    for (int axis = 0; axis < 3; ++axis) of.push_back(graph.input(body + axis));
  }
  const Program slopes(graph, gradient(graph, l.in(graph), of), size);
  std::mt19937_64 random(1);
  const auto draw = [&](double most) { return std::uniform_real_distribution<double>(-most, most)(random); };
  for (int n = 0; n < samples; ++n) {
    std::array<double, size> z{};
    for (const std::size_t body : {std::size_t{0}, std::size_t{sight_size}}) {
      const double psi = draw(std::numbers::pi);
      write_sight(
          Sight<double>{{{draw(reach), draw(reach), draw(reach)}, {std::cos(psi), std::sin(psi)}}, {}},
          std::span(z).subspan(body));
    }
    const std::vector<double> slope = evaluate(slopes, z);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double a = slope[axis], b = slope[axis + 3];
      if (std::fabs(a + b) > rounding * (std::fabs(a) + std::fabs(b))) return true;
    }
  }
  return false;
}

Field::Field(const Potential& potential) : Field(std::array{FieldTerm{{1.0, potential}}}) {}

Field::Field(std::span<const FieldTerm> terms) {
  Graph graph;
  const std::vector<Symbol> in = variables(graph, 0, inputs);
  const Vec3<Symbol> still = {0.0, 0.0, 0.0};
  const auto sight = [&](std::size_t p, std::size_t psi) {
    return Sight<Symbol>{{{in[p], in[p + 1], in[p + 2]}, {cos(in[psi]), sin(in[psi])}}, still};
  };
  const Sight<Symbol> observer = sight(free_size, 3), target = sight(0, 4);
  Symbol sum = 0.0;
  for (const auto& [term, turned] : terms) {
    sum += term.weight * term.potential(turned ? target : observer, turned ? observer : target, Symbol(0.0));
  }
  const Term l = sum.in(graph);
  std::vector<Term> of;
  for (int i = 0; i < free_size; ++i) of.push_back(graph.input(i));
  const Derivatives d = derive(graph, l, of);
  sees_heading_ = !graph.is_zero(d.first[3]);
  std::vector<Term> out = {l};
  out.insert(out.end(), d.first.begin(), d.first.end());
  out.insert(out.end(), d.second.begin(), d.second.end());
  program_ = Program(graph, out, inputs);
}

std::vector<FieldValue> Field::operator()(std::span<const Station> stations) const {
  std::vector<FieldValue> values(stations.size());
  Rows in(inputs, batch), out(outputs, batch);
  Evaluation evaluation(program_, batch);
  for (int i = 0; i < inputs; ++i) evaluation.input(i, in[i]);
  for (int i = 0; i < outputs; ++i) evaluation.output(i, out[i]);
  for (std::size_t done = 0; done < stations.size(); done += batch) {
    const int n = static_cast<int>(std::min<std::size_t>(batch, stations.size() - done));
    for (int k = 0; k < n; ++k) {
      const auto numbers = numbers_of(stations[done + at(k)]);
      for (int i = 0; i < inputs; ++i) in[i][k] = numbers[at(i)];
    }
    evaluation.run();
    for (int k = 0; k < n; ++k) {
      FieldValue& value = values[done + at(k)];
      value.l = out[0][k];
      for (int i = 0; i < free_size; ++i) value.first[at(i)] = out[1 + i][k];
      for (int i = 0; i < outputs - 1 - free_size; ++i) value.second[at(i)] = out[1 + free_size + i][k];
    }
  }
  return values;
}

FieldValue Field::operator()(const Station& station) const {
  const std::vector<double> out = evaluate(program_, numbers_of(station));
  FieldValue value;
  value.l = out[0];
  std::copy_n(out.begin() + 1, free_size, value.first.begin());
  std::copy(out.begin() + 1 + free_size, out.end(), value.second.begin());
  return value;
}

Rest descend(const Field& field, const Station& start, std::span<const int> free) {
  constexpr double resting = 1e-9, longest = 0.5;  // gradient [1/m, 1/rad], step [m, rad]
  Station here = start;
  FieldValue value = field(here);
  double damping = 1e-3;
  for (int n = 0; n < 200 && steepness(value, free) > resting && damping < 1e12; ++n) {
    std::array<double, free_size> step{};
    if (newton_step(value, free, damping, step)) {
      double length = 0.0;
      for (const double s : step) length = std::max(length, std::fabs(s));
      Station next = here;
      for (std::size_t i = 0; i < free.size(); ++i) {
        move(next, free[i], step[i] * std::min(1.0, longest / std::max(length, 1e-300)));
      }
      if (const FieldValue there = field(next); there.l <= value.l) {
        here = next, value = there, damping = std::max(1e-12, damping / 10);
        continue;
      }
    }
    damping *= 10;
  }
  std::array<double, free_size> ignored{};
  return {here, value.l, steepness(value, free) < 1e-6 && newton_step(value, free, 1e-6, ignored)};
}

}  // namespace sightline
