/// The commands fly and vehicles as a person uses them: two programs, on loopback.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include "tests/dds/own_domain.hpp"
#include "tests/support/child.hpp"
#include "tests/support/command.hpp"

namespace sightline::dds {

class FlyTest : public testing::Test {
 protected:
  /// A shipped fleet, on a domain of its own, for so long [s].
  std::filesystem::path fleet_of(const std::string& name, const std::string& duration) const {
    std::string text = test::read_file(SIGHTLINE_SOURCE_DIR "/fleets/" + name + ".toml");
    text = std::regex_replace(text, std::regex("\nduration = 60.0 "), "\nduration = " + duration + " ");
    text = std::regex_replace(text, std::regex("\ndomain = [0-9]+ "),
                              "\ndomain = " + std::to_string(test::own_domain()) + " ");
    std::ofstream(folder / (name + ".toml")) << text;
    return folder / (name + ".toml");
  }
  std::filesystem::path desk(const std::string& duration) const { return fleet_of("desk", duration); }
  /// The command with stdout and stderr in files of that name.
  std::unique_ptr<test::Child> begin(std::vector<std::string> words, const std::string& name) const {
    const std::string out = (folder / (name + ".out")).string(), err = (folder / (name + ".err")).string();
    return std::make_unique<test::Child>(std::move(words), [out, err] {
      if (std::freopen(out.c_str(), "w", stdout) == nullptr ||
          std::freopen(err.c_str(), "w", stderr) == nullptr)
        ::_exit(125);
    });
  }
  std::string printed(const std::string& name) const { return test::read_file(folder / name); }
  bool prints(const std::string& name, const std::string& what) const {
    return test::eventually([&] { return printed(name).find(what) != std::string::npos; },
                            std::chrono::seconds(20));
  }
  void expect_replayed(const std::string& flight) const {
    const auto done = test::sightline("replay " + (folder / flight).string(), folder);
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_THAT(done.out, testing::HasSubstr(" commands, 0 differ"));
  }
  /// Takes off on a desk, flies for so long, lands, and flies again from its log; hard distances
  /// are kept, all exit with 0.
  /// @param set  further words of `fly`
  void expect_flies(const std::string& name, const std::string& duration, const std::string& set = "") const {
    expect_file_flies(fleet_of(name, duration), set);
  }
  /// The same of a fleet file.
  void expect_file_flies(const std::filesystem::path& fleet, const std::string& set) const {
    const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
    const auto flown =
        test::sightline("fly " + fleet.string() + " -o " + (folder / "flown").string() + set, folder);
    EXPECT_EQ(flown.code, 0) << flown.out << flown.err;
    EXPECT_THAT(flown.out, testing::ContainsRegex("allocations in an update +0\n"));
    vehicles->end(SIGINT);
    EXPECT_EQ(vehicles->code(), 0);
    for (const char* bad : {"failsafe", "levelled out", "stopped by itself", "in the air", "flying"})
      EXPECT_THAT(printed("vehicles.out"), testing::Not(testing::HasSubstr(bad)));
    EXPECT_THAT(printed("vehicles.out"), testing::Not(testing::ContainsRegex("[1-9][0-9]* (while|bad)")));
    expect_replayed("flown");
  }
  std::vector<std::string> flight(const std::filesystem::path& fleet,
                                  const std::string& out = "flown") const {
    return {"fly", fleet.string(), "-o", (folder / out).string()};
  }
  struct Flying {
    std::filesystem::path fleet;
    std::unique_ptr<test::Child> vehicles, flyer;
  };
  /// A shipped fleet in its task, so long after the task began.
  Flying in_task(const std::string& name, std::chrono::milliseconds since) const {
    const std::filesystem::path fleet = fleet_of(name, "60.0");
    auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
    auto flyer = begin(flight(fleet), "fly");
    EXPECT_TRUE(prints("fly.err", "the task begins")) << printed("fly.err") << printed("vehicles.err");
    std::this_thread::sleep_for(since);
    return {fleet, std::move(vehicles), std::move(flyer)};
  }

  std::filesystem::path folder = test::fresh_folder();
};

}  // namespace sightline::dds
