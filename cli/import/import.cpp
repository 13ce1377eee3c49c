#include "sightline/import/import.hpp"

#include <memory>

#include "cli/arguments.hpp"
#include "cli/output.hpp"
#include "sightline/base/text_file.hpp"

namespace sightline::cli {
namespace {

struct ImportCommand {
  std::vector<std::filesystem::path> files;
  std::filesystem::path output;
  ImportOptions options;
};

int import(const ImportCommand& command) {
  const Imported made = import_files(command.files, command.options);
  for (const std::string& note : made.notes) print_message("note: {}\n", note);
  if (command.output.empty()) {
    print("{}", made.text);
  } else {
    write_text(command.output, made.text);
    print("{}: {}\n", command.output.native(), made.what);
  }
  return 0;
}

}  // namespace

Execute describe_import(CLI::App& app) {
  const auto command = std::make_shared<ImportCommand>();
  ImportOptions& options = command->options;
  app.description("Make a fleet, or tables of a scenario, of the files of other programs");
  app.add_option(
         "FILE", command->files,
         "crazyflies.yaml and server.yaml of Crazyswarm2, a camera's calibration by ROS (also in a "
         "bag) or kalibr, tags of apriltag_ros or TagSLAM (YAML), or the SDF, URDF or MJCF of a multirotor")
      ->required();
  app.add_option("-o,--output", command->output, "File for the result [standard output]");
  app.add_option(
      "--agent", options.agent,
      "Robot that has the camera or is the vehicle [uav0], or has all the tags [each is of a target]");
  app.add_option("--camera", options.camera,
                 "Camera of a chain of kalibr, as cam1, or topic in a bag [its first]");
  return [command](const Registry&, char**) { return refusing([&] { return import(*command); }); };
}

}  // namespace sightline::cli
