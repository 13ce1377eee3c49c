#include "sightline/estimate/planar_sighting.hpp"

#include <vector>

namespace sightline {
namespace {

constexpr int inputs = RangeBearing::inputs, estimated = RangeBearing::estimated;
constexpr int outputs = 2 * (1 + estimated);

/// Range, bearing, the gradient of the range and that of the bearing.
Program traced() {
  Graph graph;
  const std::vector<Symbol> z = variables(graph, 0, inputs);
  const std::array<Symbol, 2> measured = RangeBearing{}(std::span<const Symbol>(z));
  std::vector<Term> over, all;
  for (int i = 0; i < estimated; ++i) over.push_back(z[static_cast<std::size_t>(i)].in(graph));
  for (const Symbol& one : measured) all.push_back(one.in(graph));
  for (const Symbol& one : measured)
    for (const Term& derivative : gradient(graph, one.in(graph), over)) all.push_back(derivative);
  return {graph, all, inputs};
}

const Program& program() {
  static const Program once = traced();
  return once;
}

}  // namespace

SightingModel::SightingModel() : program_(program()), rows_(inputs + outputs, 1), evaluation_(program_, 1) {
  for (int i = 0; i < inputs; ++i) evaluation_.input(i, rows_[i]);
  for (int i = 0; i < outputs; ++i) evaluation_.output(i, rows_[inputs + i]);
}

SightingModel::Expected SightingModel::operator()(const std::array<double, inputs>& z) noexcept {
  for (int i = 0; i < inputs; ++i) rows_[i][0] = z[static_cast<std::size_t>(i)];
  evaluation_.run();
  Expected e;
  for (int a = 0; a < 2; ++a) {
    e.value[static_cast<std::size_t>(a)] = rows_[inputs + a][0];
    for (int i = 0; i < estimated; ++i) e.H(a, i) = rows_[inputs + 2 + a * estimated + i][0];
  }
  return e;
}

}  // namespace sightline
