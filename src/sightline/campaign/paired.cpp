#include "sightline/campaign/paired.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

#include "sightline/campaign/confidence.hpp"
#include "sightline/campaign/database.hpp"

namespace sightline {
namespace {

constexpr double rounding = 1e-9;  // smaller differences come from the order of summation

/// P(X < k), X binomial of n trials with probability 1/2.
double fewer_than(std::size_t k, std::size_t n) {
  return k == 0 ? 0.0 : incomplete_beta(static_cast<double>(n - k + 1), static_cast<double>(k), 0.5);
}

/// Values of a column in the recovered runs, by their indices.
std::map<std::int64_t, double> recovered(const CampaignTable& table, std::string_view column) {
  Database database(table.file, Database::Open::as_it_is);
  Database::Statement query(
      database, fmt::format("SELECT \"index\", {} FROM runs WHERE outcome = 'recovered'", sql_name(column)));
  std::map<std::int64_t, double> values;
  while (query.step()) {
    if (const auto value = query.number(1)) values[query.integer(0)] = *value;
  }
  return values;
}

std::string describe(const Pairing& p) {
  if (p.runs == 0) return "no run that both recovered";
  if (p.less == 0 && p.more == 0) return fmt::format("the same in {} runs that both recovered", p.runs);
  return fmt::format(
      "{:.3f} of it in the median (95 %: {:.3f} to {:.3f}), difference {:+.3g} s ({:+.3g} to {:+.3g} s), "
      "less in {} of {} runs that both recovered (sign test: p = {:.2g})",
      p.ratio.median, p.ratio.low, p.ratio.high, p.difference.median, p.difference.low, p.difference.high,
      p.less, p.runs, sign_test(p.less, p.more));
}

}  // namespace

MedianBounds median_bounds(std::vector<double> values, double confidence) {
  assert(!values.empty() && "there is a median");
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  std::size_t rank = 0, beyond = n / 2 + 1;  // bisection: greatest k with P(X < k) <= tail
  while (beyond - rank > 1) {
    const std::size_t k = (rank + beyond) / 2;
    (fewer_than(k, n) <= (1.0 - confidence) / 2 ? rank : beyond) = k;
  }
  const std::size_t low = rank == 0 ? 0 : rank - 1;
  return {values[low], 0.5 * (values[(n - 1) / 2] + values[n / 2]), values[n - 1 - low]};
}

Pairing pair_runs(const CampaignTable& a, const CampaignTable& b, std::string_view column) {
  const std::map<std::int64_t, double> of_a = recovered(a, column), of_b = recovered(b, column);
  Pairing pairing;
  std::vector<double> differences, ratios;
  for (const auto& [index, value] : of_a) {
    const auto other = of_b.find(index);
    if (other == of_b.end()) continue;
    ++pairing.runs;
    const double slack = rounding * std::abs(value);
    pairing.less += other->second < value - slack;
    pairing.more += other->second > value + slack;
    differences.push_back(other->second - value);
    if (value > 0) ratios.push_back(other->second / value);
  }
  if (!differences.empty()) pairing.difference = median_bounds(std::move(differences));
  if (!ratios.empty()) pairing.ratio = median_bounds(std::move(ratios));
  return pairing;
}

OutcomePairing pair_outcomes(const CampaignTable& a, const CampaignTable& b) {
  const auto outcomes = [](const CampaignTable& table) {
    Database database(table.file, Database::Open::as_it_is);
    Database::Statement query(database, "SELECT \"index\", outcome = 'recovered' FROM runs");
    std::map<std::int64_t, bool> all;
    while (query.step()) all[query.integer(0)] = query.integer(1) != 0;
    return all;
  };
  const std::map<std::int64_t, bool> of_a = outcomes(a), of_b = outcomes(b);
  OutcomePairing pairing;
  for (const auto& [index, good] : of_a) {
    const auto other = of_b.find(index);
    if (other == of_b.end()) continue;
    ++pairing.runs;
    pairing.only_a += good && !other->second;
    pairing.only_b += !good && other->second;
  }
  return pairing;
}

std::vector<CampaignLine> energy_lines(const CampaignTable& a, const CampaignTable& b) {
  const OutcomePairing outcomes = pair_outcomes(a, b);
  std::vector<CampaignLine> lines = {
      {"recovered",
       fmt::format("alone in {} of {} runs, the other alone in {} (McNemar: p = {:.2g})", outcomes.only_b,
                   outcomes.runs, outcomes.only_a, sign_test(outcomes.only_a, outcomes.only_b))},
      {"energy", describe(pair_runs(a, b, "energy"))}};
  const std::vector<std::string> of_b = Runs(b).energies();
  for (const std::string& column : Runs(a).energies()) {
    if (std::find(of_b.begin(), of_b.end(), column) == of_b.end()) continue;
    lines.push_back({column, describe(pair_runs(a, b, column))});
  }
  return lines;
}

}  // namespace sightline
