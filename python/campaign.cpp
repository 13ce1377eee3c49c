// Campaigns: many runs of one scenario, each with its own draws.
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <thread>

#include "python/waited.hpp"
#include "sightline/analysis.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/campaign/page.hpp"
#include "sightline/campaign/table.hpp"
#include "sightline/log.hpp"

namespace sightline::python {
namespace {

namespace fs = std::filesystem;

/// Flies the runs that the folder's table lacks.
/// @return the path of the table
fs::path fly(const Scenario& given, const fs::path& out, int runs, const std::optional<std::uint64_t>& seed,
             int threads, const py::object& progress) {
  if (runs < 1) throw_invalid("runs = {}, expected >= 1", runs);
  if (threads < 0) throw_invalid("threads = {}, expected >= 1, or 0 for one a core", threads);
  const CampaignPlan& plan = campaign_plan(given);
  check_campaign(given, plan);
  std::atomic<bool> stop = false;
  std::atomic<int> done = 0;
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  CampaignOptions options{.runs = runs,
                          .seed = seed.value_or(given.simulation.seed),
                          .threads = threads > 0 ? threads : cores,
                          .stop = &stop};
  const FolderLock lock(out.empty() ? fs::path("out") / given.name / "campaign" : out,
                        {"campaign.sqlite", "campaign.html"});
  fs::path file = lock.folder() / "campaign.sqlite";
  auto flight = run_for_value([&] {
    RunTable table(file, given, plan, options.seed);
    check_continues(table, file, given, plan, options);
    done = options.first = table.rows();
    fly_campaign(given, plan, options, [&](const RunDraw& run, const RunResult& result) {
      table.add(run, result);
      ++done;
    });
    table.finish();
    return true;
  });
  waited_for(flight, stop, done, progress);
  return file;
}

std::vector<std::pair<std::string, std::string>> lines(const std::string& name, const fs::path& file) {
  const py::gil_scoped_release others_run;
  std::vector<std::pair<std::string, std::string>> all;
  for (CampaignLine& line : campaign_lines({name, file}))
    all.emplace_back(std::move(line.what), std::move(line.value));
  return all;
}

fs::path write_page(const Scenario& scenario, const fs::path& file, std::uint64_t seed) {
  const py::gil_scoped_release others_run;
  const fs::path folder = file.parent_path();
  const std::string command =
      fmt::format("sightline campaign {} --seed {}", shell_word(scenario.file.native()), seed);
  write_text(folder / "campaign.html",
             campaign_html({{scenario.name, file}}, campaign_plan(scenario), command, folder));
  return folder / "campaign.html";
}

}  // namespace

void bind_campaign(py::module_& module) {
  module.def("fly_campaign", &fly, py::arg("scenario"), py::arg("out"), py::arg("runs"), py::arg("seed"),
             py::arg("threads"), py::arg("progress"));
  module.def("campaign_lines", &lines, py::arg("name"), py::arg("file"));
  module.def("write_campaign_page", &write_page, py::arg("scenario"), py::arg("file"), py::arg("seed"));
}

}  // namespace sightline::python
