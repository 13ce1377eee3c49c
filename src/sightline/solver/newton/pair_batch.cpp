#include "sightline/solver/newton/pair_batch.hpp"

#include "sightline/formula.hpp"

namespace sightline {

bool PairBatch::suits(const BodyPotential& pair) const {
  const BodyPotential& first = *pairs[0];
  const PosePotential &ours = first.potential, &other = pair.potential;
  return first.ramp == pair.ramp && ours.derivatives == other.derivatives && ours.others == other.others &&
         ours.variables == other.variables && first.ends.a_feels == pair.ends.a_feels &&
         first.ends.b_feels == pair.ends.b_feels && first.ends.a_is_agent == pair.ends.a_is_agent &&
         first.ends.b_is_agent == pair.ends.b_is_agent;
}

void PairBatch::gather(const Layout& layout, const StageParameters& parameters, const double* s) noexcept {
  int point = 0;
  for (const BodyPotential* pair : pairs) {
    gather(*pair, point, layout, parameters, s);
    point += layout.stages;
  }
}

void PairBatch::sum_values(const Layout& layout, const StageParameters& parameters, const double* s,
                           const BodyPotential* first, std::span<double> sums,
                           std::span<const char> wanted) noexcept {
  const auto each = [&](auto&& f) {
    int point = 0;
    for (const BodyPotential* pair : pairs) {
      const auto place = static_cast<std::size_t>(pair - first);
      if (!wanted.empty() && wanted[place] == 0) continue;
      f(*pair, place, point);
      point += layout.stages;
    }
    return point;
  };
  points.evaluate(each([&](const BodyPotential& pair, std::size_t, int point) {
    gather(pair, point, layout, parameters, s);
  }));
  each([&](const BodyPotential&, std::size_t place, int point) {
    sums[place] = 0.0;
    for (int k = 0; k < layout.stages; ++k) sums[place] += points.value(point + k);
  });
}

/// Writes the inputs of one pair, starting at a point.
void PairBatch::gather(const BodyPotential& pair, int point, const Layout& layout,
                       const StageParameters& parameters, const double* s) noexcept {
  const int N = layout.stages;
  const PosePotential& potential = pairs[0]->potential;
  const Layout::View a = pair.a >= 0 ? layout.s(pair.a) : Layout::View{};
  const Layout::View b = pair.b >= 0 ? layout.s(pair.b) : Layout::View{};
  if (potential.relative) {
    for (int k = 0; k < N; ++k, ++point) {
      for (int i = 0; i < 3; ++i) points.in(point, i) = s[a(k, i)] - s[b(k, i)];
      for (int i = 3; i < PosePotential::relative_size; ++i) points.in(point, i) = s[a(k, i)];
    }
    return;
  }
  for (std::size_t i = 0; i < potential.variables.size(); ++i) {
    const int v = potential.variables[i];
    const bool of_b = v >= sight_size, of_third = v >= PosePotential::third_variable;
    const int agent = of_third ? pair.third : of_b ? pair.b : pair.a;
    const int body = of_third ? pair.third_body : of_b ? pair.body_b : pair.body_a;
    const int component = of_third ? v - PosePotential::third_variable : of_b ? v - sight_size : v;
    const double* from = nullptr;
    std::ptrdiff_t stride = 1;
    if (v == PosePotential::time_variable) {
      from = parameters.time[0];
    } else if (v == PosePotential::uncertainty_variable) {
      from = parameters.uncertainty[pair.body_a];
    } else if (agent >= 0) {
      const Layout::View view = of_third ? layout.s(agent) : of_b ? b : a;
      from = s + view(0, component), stride = view.stage;
    } else {
      from = parameters.bodies[body * sight_size + component];
    }
    points.each_in(point, N, static_cast<int>(i), [&](int k, double& in) { in = from[k * stride]; });
  }
}

void PairBatch::scatter(const Layout& layout, double* c) const noexcept {
  const PosePotential& potential = pairs[0]->potential;
  const int N = layout.stages;
  int first = 0;
  for (const BodyPotential* pair : pairs) {
    const auto add = [&](bool of_b, const auto& index, int output, bool negative) {
      const int agent = of_b ? pair->b : pair->a;
      const Layout::View view = layout.c(agent);
      const int entry = index(layout.part(agent).ns);
      double* const to = c + view(0, entry);
      const double sign = negative ? -1.0 : 1.0;
      points.each_out(first, N, output, [&](int k, double value) { to[k * view.stage] += sign * value; });
    };
    for (const auto& g : potential.gradient) {
      const bool of_b = g.variable >= sight_size;
      add(
          of_b, [&](int) { return g.variable - (of_b ? sight_size : 0); }, g.output, g.negative);
    }
    for (const auto& h : potential.own) {
      const bool of_b = h.row >= sight_size;
      const int from = of_b ? sight_size : 0;
      add(
          of_b, [&](int ns) { return ns + upper_index(h.row - from, h.column - from, ns); }, h.output,
          h.negative);
    }
    first += N;
  }
}

}  // namespace sightline
