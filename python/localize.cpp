// Recorded teams: their poses, estimated from what they measured.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "python/bindings.hpp"
#include "sightline/analysis/localization/localize_recording.hpp"
#include "sightline/import/read_rig.hpp"

namespace sightline::python {
namespace {

namespace fs = std::filesystem;

std::string localized(const fs::path& recording, const fs::path& out, const std::string& landmarks,
                      const std::string& robots, const std::string& anchor, const std::string& start,
                      bool identities, const fs::path& noise, const std::vector<std::string>& set,
                      bool identify_noise, std::uint64_t seed, const std::string& pixels) {
  const py::gil_scoped_release others_run;
  const LocalizeOptions options{.landmarks = landmarks,
                                .robots = robots,
                                .anchor = anchor,
                                .start = start,
                                .identities = identities,
                                .noise = noise,
                                .set = set,
                                .seed = seed,
                                .identify_noise = identify_noise,
                                .pixels = pixels};
  if (is_rig_recording(recording))
    return localize_recording(read_rig_recording(recording, pixels), recording, options, out,
                              "sightline.localize")
        .json;
  return localize_recording(recording, options, out, "sightline.localize").json;
}

}  // namespace

void bind_localize(py::module_& module) {
  module.def("localize_recording", &localized, py::arg("recording"), py::arg("out"), py::arg("landmarks"),
             py::arg("robots"), py::arg("anchor"), py::arg("start"), py::arg("identities"), py::arg("noise"),
             py::arg("set"), py::arg("identify_noise"), py::arg("seed"), py::arg("pixels"));
}

}  // namespace sightline::python
