#include "bench/estimate.hpp"

#include <algorithm>
#include <chrono>
#include <string>

#include "tests/support/synthetic_flight.hpp"

namespace sightline {

std::vector<BenchRow> run_estimate_bench(const BenchOptions& options) {
  using Time = std::chrono::steady_clock;
  const auto count = [&] { return options.allocations == nullptr ? 0 : options.allocations(); };
  std::vector<BenchRow> rows;
  int estimated = 0;
  for (const FilterKind kind : {FilterKind::heading, FilterKind::attitude}) {
    test::SyntheticFlight flight({.seed = 1, .latency_min = 0.08, .latency_max = 0.08});
    const auto filter = make_pose_filter({.filter = kind}, flight.o.mount);
    std::vector<double> samples, sightings;
    std::vector<Measurement> arrived;
    std::int64_t allocations = 0;
    const auto timed = [&](std::vector<double>& us, const auto& call) {
      const std::int64_t before = count();
      const Time::time_point begin = Time::now();
      call();
      const Time::time_point end = Time::now();
      allocations = std::max(allocations, count() - before);
      us.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
    };
    estimated = 0;
    for (int k = 0; k < options.updates; ++k) {
      const MotionSample motion = flight.advance(arrived);
      timed(samples, [&] { filter->advance(motion); });
      const bool known = filter->estimate().known;
      Fit fit;
      for (const Measurement& z : arrived) {
        std::vector<double> start;
        timed(known ? sightings : start, [&] { fit = filter->take(z); });
        estimated += fit.verdict == FitVerdict::accepted ? 1 : 0;
      }
    }
    const std::string name(filter_kinds[static_cast<std::size_t>(kind)]);
    for (auto&& [what, us] : {std::pair{"_sample", samples}, std::pair{"_late_sighting", sightings}}) {
      rows.push_back(row_of(name + what, 1, us));
      rows.back().solver = estimate_case_name;
      rows.back().allocations = allocations;
    }
  }
  if (options.progress) options.progress(estimated);
  return rows;
}

}  // namespace sightline
