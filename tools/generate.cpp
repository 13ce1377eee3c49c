/// Prints the compiled functions of models and potentials: generate FOLDER PART..., one file for each
/// part, and an index of them.
///
/// The printed functions contain no parameter values, so one function serves all robots of a model,
/// at every stage length.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <vector>

#include "sightline/kernels.hpp"
#include "sightline/model.hpp"
#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"

namespace sightline {
namespace {

Generator stages_of(const char* part, const std::vector<Model>& models, const std::vector<Seen>& views) {
  Generator generator(part);
  for (const Seen seen : views) {
    for (const Model& model : models) generator.add(model, seen);
  }
  return generator;
}

Generator smooth_multirotor() {
  Generator generator("smooth_multirotor");
  const std::vector<double> R_rate(4, 1.0);
  for (const Seen seen : {Seen::pose, Seen::pose_and_motion})
    generator.add(Multirotor{}, seen, {}, {R_rate, 0.01});
  return generator;
}

Generator limits_of_a_multirotor() {
  Generator generator("multirotor_limits");
  generator.add(Multirotor{}, Seen::pose, {RelaxedBarrier{SpeedLimit{}}});
  generator.add(Multirotor{}, Seen::pose, {RelaxedBarrier{InputDisc{}}});
  return generator;
}

/// The potentials of the paper, and the walls.
Generator paper_potentials() {
  Generator generator("paper_potentials");
  const Weighted cone = 0.4 * SensorCone{}, keep_out = 0.4 * KeepOut{}, cohesion = 0.4 * Cohesion{};
  generator.add({cone, keep_out, cohesion});
  generator.add_slopes({cone, keep_out, cohesion});
  generator.add({cone, keep_out});
  generator.add({cone, cohesion});
  generator.add({keep_out, cohesion});
  for (const Weighted& one : {cone, keep_out, cohesion, 0.4 * AltitudeBand{}, 0.4 * Geofence{}})
    generator.add({one});
  generator.add({0.4 * AltitudeBand{}, 0.4 * Geofence{}});
  return generator;
}

Generator potentials() {
  Generator generator("potentials");
  const Weighted keep_out = 0.4 * KeepOut{}, cohesion = 0.4 * Cohesion{};
  const Weighted bearing = 0.4 * Bearing{}, near = 0.4 * TooNear{}, far = 0.4 * TooFar{},
                 with = 0.4 * RelativeVelocity{};
  generator.add({bearing, near, far, with});
  generator.add({bearing, near, far});
  for (const Weighted& one : {bearing, near, far, with}) generator.add({one});
  // For a camera that tilts with the body.
  constexpr SensorMount body = {.frame = MountFrame::body};
  const Weighted leaning_bearing = 0.4 * Bearing{.mount = body},
                 leaning_cone = 0.4 * SensorCone{.mount = body};
  for (const Weighted& one : {leaning_bearing, leaning_cone}) generator.add({one});
  generator.add({leaning_bearing, near, far, with});
  generator.add({leaning_bearing, near, far});
  generator.add({leaning_cone, keep_out, cohesion});
  for (const Weighted& one : {keep_out, near, 0.4 * PassRight{}}) generator.add_swarm(one);
  return generator;
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  using namespace sightline;
  if (argc < 3) {
    std::fputs("usage: generate FOLDER PART...\n", stderr);
    return 2;
  }
  const std::vector both = {Seen::pose, Seen::pose_and_motion};
  const std::vector<Model> velocity = {VelocityMultirotor{},
                                       VelocityMultirotor{.frame = VelocityFrame::level}};
  std::vector<Generator> parts = {
      stages_of("multirotor", {Multirotor{}}, {Seen::pose}),
      stages_of("multirotor_motion", {Multirotor{}}, {Seen::pose_and_motion}),
      limits_of_a_multirotor(),
      smooth_multirotor(),
      stages_of("angle_multirotor", {AngleMultirotor{}}, both),
      stages_of("velocity_multirotor", velocity, {Seen::pose}),
      stages_of("velocity_multirotor_motion", velocity, {Seen::pose_and_motion}),
      stages_of("hover_multirotor", {HoverMultirotor{}, LaggingHoverMultirotor{}}, {Seen::pose}),
      stages_of("hover_multirotor_motion", {HoverMultirotor{}, LaggingHoverMultirotor{}},
                {Seen::pose_and_motion}),
      stages_of("leaning_multirotor", {Multirotor{}}, {Seen::leaning}),
      stages_of("leaning_velocity_multirotor", velocity, {Seen::leaning}),
      stages_of("leaning_hover_multirotor", {HoverMultirotor{}, LaggingHoverMultirotor{}}, {Seen::leaning}),
      stages_of("ground_robots", {OmniRover{}, Unicycle{}}, both),
      stages_of("point_mass", {PointMass{}, PointMass{.drag = 0.3}}, both),
      paper_potentials(),
      potentials(),
  };
  const std::vector<std::string_view> chosen(argv + 2, argv + argc);
  std::erase_if(parts, [&](const Generator& part) {
    return std::find(chosen.begin(), chosen.end(), part.part()) == chosen.end();
  });
  if (parts.size() != chosen.size()) {
    std::fprintf(stderr, "generate: %zu of %zu parts are known\n", parts.size(), chosen.size());
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  for (const Generator& part : parts) {
    if (!write_text(folder / (part.part() + ".cpp"), part.text())) return 1;
  }
  return write_text(folder / "index.cpp", Generator::index(parts)) ? 0 : 1;
}
