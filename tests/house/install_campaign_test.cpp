// What another project gets: from an installed prefix, as a subproject, by pkg-config, and as a
// Debian package.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>
#include <vector>

#include "sightline/base.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/command.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using test::fresh_folder;
using test::read_file;
using test::shell;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

const std::string tree = SIGHTLINE_SOURCE_DIR, build = SIGHTLINE_BUILD;

void write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

/// The example of README, but that it prints every bit.
std::string flight() {
  return std::regex_replace(read_file(tree + "/examples/sensor_tracking.cpp"), std::regex("%\\.12g"), "%a");
}

class Install : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    prefix_ = std::make_unique<test::Folder>("sightline_prefix");
    const fs::path folder = prefix_->path() / "log";
    fs::create_directories(folder);
    const auto done = shell("cmake --install " + build + " --prefix " + prefix(), folder);
    ASSERT_EQ(done.code, 0) << done.err;
  }
  static void TearDownTestSuite() { prefix_.reset(); }
  static std::string prefix() { return prefix_->path().string(); }

  /// A project of these lines in folder/source, configured into folder/build.
  test::CommandResult configured(const std::string& lines, const std::string& options) {
    write(folder_ / "source/CMakeLists.txt",
          "cmake_minimum_required(VERSION 3.22)\nproject(consumer LANGUAGES C CXX)\n" + lines);
    return shell(
        "cmake -G Ninja -S " + path("source") + " -B " + path("build") + " -DCMAKE_PREFIX_PATH=" + prefix() +
            " -DCMAKE_CXX_COMPILER=" SIGHTLINE_COMPILER " -DCMAKE_EXPORT_COMPILE_COMMANDS=ON " + options,
        folder_);
  }
  test::CommandResult built(const std::string& target) {
    return shell("cmake --build " + path("build") + " --target " + target, folder_);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  const fs::path folder_ = fresh_folder();

 private:
  static std::unique_ptr<test::Folder> prefix_;
};
std::unique_ptr<test::Folder> Install::prefix_;

/// As on a machine that has none of what the core does without.
const std::string bare =
    "-DCMAKE_DISABLE_FIND_PACKAGE_SQLite3=ON -DCMAKE_DISABLE_FIND_PACKAGE_tomlplusplus=ON "
    "-DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON -DCMAKE_DISABLE_FIND_PACKAGE_CLI11=ON "
    "-DCMAKE_DISABLE_FIND_PACKAGE_ZLIB=ON -DCMAKE_DISABLE_FIND_PACKAGE_PkgConfig=ON ";

TEST_F(Install, APlainProgramOnABareMachineFliesTheSameBitsAndOneOfAnotherLaneWidthIsNotLinked) {
  write(folder_ / "source/flight.cpp", flight());
  const std::string other = native_width == 2 ? "4" : "2", own = std::to_string(native_width);
  const auto done = configured(
      "find_package(sightline REQUIRED COMPONENTS core)\n"
      "foreach(name plain tuned forced)\n"
      "  add_executable(${name} flight.cpp)\n"
      "  target_link_libraries(${name} PRIVATE sightline::core)\n"
      "endforeach()\n"
      "target_compile_options(tuned PRIVATE ${SIGHTLINE_KERNEL_FLAGS})\n"
      "target_compile_definitions(forced PRIVATE SIGHTLINE_LANE_WIDTH=" +
          other + ")\n",
      "-DCMAKE_CXX_FLAGS=-O2 " + bare);
  ASSERT_EQ(done.code, 0) << done.err;
  ASSERT_EQ(built("plain tuned").code, 0) << read_file(folder_ / "stdout.txt");
  const auto plain = shell(path("build/plain"), folder_), tuned = shell(path("build/tuned"), folder_);
  EXPECT_EQ(plain.code, 0);
  EXPECT_THAT(plain.out, HasSubstr("0x1."));
  EXPECT_EQ(plain.out, tuned.out);

  // The program of the tree prints fewer digits.
  std::string digits = std::regex_replace(plain.out, std::regex("^|\n(?=.)"), "$& ");
  const auto shorter =
      shell("printf '%.12g\\n' " + std::regex_replace(digits, std::regex("\n"), " "), folder_);
  EXPECT_EQ(shorter.out, shell(SIGHTLINE_EXAMPLES "/sensor_tracking", folder_).out);

  const auto forced = built("forced");
  EXPECT_NE(forced.code, 0);
  EXPECT_THAT(forced.out + forced.err, HasSubstr("undefined reference to `sightline::lanes_" + other +
                                                 "_here_and_" + own + "_in_the_library'"));
}

TEST_F(Install, ACommandLineWithPartsOfItsOwnIsBuiltFromThePrefixAndFliesThem) {
  for (const std::string name : {"own_command_line.cpp", "own_parts.hpp", "own_solver.hpp", "own_parts.toml"})
    write(folder_ / "source" / name, read_file(fmt::format("{}/examples/{}", tree, name)));
  const auto done = configured(
      "find_package(sightline REQUIRED COMPONENTS cli)\n"
      "add_executable(own own_command_line.cpp)\n"
      "target_link_libraries(own PRIVATE sightline::cli)\n"
      "sightline_add_formulas(own own_parts.hpp)\n",
      "-DCMAKE_BUILD_TYPE=Release");
  ASSERT_EQ(done.code, 0) << done.err;
  ASSERT_EQ(built("own").code, 0) << read_file(folder_ / "stdout.txt");
  const std::string scenario = path("source/own_parts.toml");
  const auto flown = shell(path("build/own") + " run " + scenario + " -o " + path("out"), folder_);
  EXPECT_EQ(flown.code, 0) << flown.err;
  EXPECT_THAT(shell(path("build/own") + " replay " + path("out"), folder_).out, HasSubstr(" 0 differ"));
}

#ifdef SIGHTLINE_MUJOCO
TEST_F(Install, AProgramOfOnesOwnFliesInMujocoFromThePrefix) {
  ASSERT_TRUE(fs::exists(prefix() + "/include/sightline/mujoco.hpp"));
  write(folder_ / "source/own.cpp",
        "#include <sightline/command_line.hpp>\n#include <sightline/mujoco.hpp>\n"
        "int main(int argc, char** argv) {\n  sightline::Registry registry;\n  "
        "sightline::add_mujoco(registry);\n"
        "  return sightline::command_line(argc, argv, registry);\n}\n");
  const auto done = configured(
      "find_package(sightline REQUIRED COMPONENTS cli mujoco)\n"
      "add_executable(own own.cpp)\n"
      "target_link_libraries(own PRIVATE sightline::cli sightline::mujoco)\n",
      "-DCMAKE_BUILD_TYPE=Release");
  ASSERT_EQ(done.code, 0) << done.err;
  ASSERT_EQ(built("own").code, 0) << read_file(folder_ / "stdout.txt");
  write(folder_ / "a.toml",
        "[world]\nkind = \"mujoco\"\n[agent.uav]\nrobot = \"multirotor\"\n"
        "start = { p = [0.0, 0.0, 1.0], heading = 0.0 }\n[simulation]\nduration = 1.0\n");
  const auto flown = shell(path("build/own") + " run " + path("a.toml") + " -o " + path("out"), folder_);
  EXPECT_EQ(flown.code, 0) << flown.err;
}
#endif

TEST_F(Install, AComponentThatWasNotBuiltIsRefusedByName) {
  const auto done = configured("find_package(sightline REQUIRED COMPONENTS core wings)\n", "");
  EXPECT_NE(done.code, 0);
  EXPECT_THAT(
      done.err,
      ContainsRegex("component wings is not among those[ \n]+that were built:[ \n]+core;sightline;cli"));
}

TEST_F(Install, TheWholeLibraryIsFoundByCmakeAndByPkgConfig) {
  const std::string scenario = tree + "/scenarios/paper_7_1.toml";
  write(folder_ / "source/reads.cpp",
        "#include <sightline/scenario.hpp>\n#include <cstdio>\n"
        "int main(int, char** argv) { std::puts(sightline::read_scenario(argv[1]).name.c_str()); }\n");
  ASSERT_EQ(configured("find_package(sightline REQUIRED)\nadd_executable(reads reads.cpp)\n"
                       "target_link_libraries(reads PRIVATE sightline::sightline)\n",
                       "-DCMAKE_BUILD_TYPE=Release")
                .code,
            0)
      << read_file(folder_ / "stderr.txt");
  ASSERT_EQ(built("reads").code, 0) << read_file(folder_ / "stdout.txt");
  EXPECT_EQ(shell(path("build/reads") + " " + scenario, folder_).out, "paper_7_1\n");

  const std::string pc = "$(PKG_CONFIG_PATH=$(dirname $(find " + prefix() +
                         " -name sightline.pc)) pkg-config --cflags --libs sightline)";
  const auto linked = shell(
      SIGHTLINE_COMPILER " -O2 " + path("source/reads.cpp") + " " + pc + " -o " + path("reads"), folder_);
  ASSERT_EQ(linked.code, 0) << linked.err;
  EXPECT_EQ(shell(path("reads") + " " + scenario, folder_).out, "paper_7_1\n");
}

TEST_F(Install, EveryHeaderStandsByItselfAndNoneShowsWhatTheLibraryIsMadeWith) {
  std::vector<fs::path> headers;
  for (const auto& entry : fs::recursive_directory_iterator(prefix() + "/include"))
    if (entry.is_regular_file()) headers.push_back(entry.path());
  std::sort(headers.begin(), headers.end());
  std::set<std::string> installed, chosen = {"config.hpp"};
  for (const fs::path& header : headers)
    installed.insert(fs::relative(header, prefix() + "/include/sightline").string());
  for (const auto& entry : fs::directory_iterator(tree + "/include/sightline"))
    if (entry.path().extension() == ".hpp") chosen.insert(entry.path().filename().string());
  EXPECT_EQ(installed, chosen) << "exactly the public headers are installed";
  EXPECT_LE(installed.size(), 30U);
  const auto found = shell(
      "grep -rlE '#include <(toml\\+\\+|nlohmann|sqlite3|zstd|zlib|CLI)' " + prefix() + "/include", folder_);
  EXPECT_EQ(found.out, "");
  // The short form reads some.
  const std::size_t step = whole_campaign() ? 1 : 10;
  for (std::size_t i = 0; i < headers.size(); i += step) {
    const auto done = shell("echo '#include \"" + headers[i].string() +
                                "\"' | " SIGHTLINE_COMPILER
                                " -std=c++20 -Wall -Wextra -Werror -Wno-psabi -fsyntax-only -I" +
                                prefix() + "/include -x c++ -",
                            folder_);
    EXPECT_EQ(done.code, 0) << headers[i] << "\n" << done.err;
  }
}

TEST_F(Install, AHostProjectGetsTheLibraryAndNeitherFlagsNorPrograms) {
  write(folder_ / "source/flight.cpp", flight());
  const auto done = configured("add_compile_options(-Wall)\nadd_subdirectory(" + tree +
                                   " sightline)\n"
                                   "add_executable(flight flight.cpp)\n"
                                   "target_link_libraries(flight PRIVATE sightline::core)\n",
                               "-DCMAKE_BUILD_TYPE=Release");
  ASSERT_EQ(done.code, 0) << done.err;
  const auto targets = shell("ninja -C " + path("build") + " -t targets all", folder_);
  EXPECT_THAT(targets.out, AllOf(HasSubstr("sightline_core"), Not(HasSubstr("sightline_cli")),
                                 Not(HasSubstr("example_")), Not(HasSubstr("/tests/"))));
  const std::string commands = read_file(folder_ / "build/compile_commands.json");
  EXPECT_THAT(commands, AllOf(Not(HasSubstr("-Werror")), Not(HasSubstr("-march=native"))));
  std::smatch own;
  ASSERT_TRUE(std::regex_search(commands, own,
                                std::regex("\"command\": \"([^\"]* -c [^\"]*/source/flight\\.cpp)\"")));
  EXPECT_THAT(own[1].str(),
              AllOf(HasSubstr("-Wall"), HasSubstr("-ffp-contract=off"), Not(HasSubstr("-march")),
                    Not(HasSubstr("-Wextra")), Not(HasSubstr("-fno-math-errno"))));
  if (!whole_campaign()) return;
  ASSERT_EQ(built("flight").code, 0) << read_file(folder_ / "stdout.txt");
  EXPECT_EQ(shell(path("build/flight"), folder_).code, 0);
}

TEST_F(Install, AnOldProcessorIsToldSoBeforeItMeetsWhatItCannotDo) {
  ASSERT_EQ(shell("command -v qemu-x86_64", folder_).code, 0)
      << "expected the packages of scripts/deps.sh test";
  const auto done = shell("qemu-x86_64 -cpu Nehalem '" SIGHTLINE_BINARY "' version", folder_);
#if defined(__AVX__)
  EXPECT_EQ(done.code, 2);
  EXPECT_EQ(done.out, "");
  EXPECT_THAT(done.err,
              ContainsRegex("sightline: this library was built for SIGHTLINE_ARCH=.*, and this processor "
                            "lacks .*avx.*; expected a library that is built with -DSIGHTLINE_ARCH=x86-64"));
#elif defined(__x86_64__)
  EXPECT_EQ(done.code, 0) << done.err;
#endif
}

TEST_F(Install, TheProgramHasAPageForEachCommandAndItsCompletion) {
  const std::string program = "'" + prefix() + "/bin/sightline'", share = prefix() + "/share/";
  ASSERT_TRUE(fs::exists(share + "sightline/scenarios/paper_7_1.toml"));
  // Each command has a page, and the completion names it.
  const auto help = shell(program + " --help", folder_);
  const std::string completion = share + "bash-completion/completions/sightline";
  int commands = 0;
  const std::regex line("\n  ([a-z]+) +[A-Z]");
  for (std::sregex_iterator at(help.out.begin(), help.out.end(), line), end; at != end; ++at, ++commands) {
    const std::string page = share + "man/man1/sightline-" + (*at)[1].str() + ".1.gz";
    EXPECT_THAT(shell("zcat '" + page + "'", folder_).out,
                HasSubstr(".SH SYNOPSIS\n\\fBsightline " + (*at)[1].str()))
        << page;
    EXPECT_THAT(read_file(completion), HasSubstr((*at)[1].str() + ") options="));
  }
  EXPECT_GE(commands, 8);
  const auto typed = [&](const std::string& words, int at) {
    return shell("bash -c '. " + completion + "; COMP_WORDS=(" + words +
                     "); COMP_CWORD=" + std::to_string(at) + "; _sightline; echo \"${COMPREPLY[@]}\"'",
                 folder_)
        .out;
  };
  EXPECT_EQ(typed("sightline po", 1), "potential\n");
  EXPECT_EQ(typed("sightline run --re", 2), "--realtime\n");
  EXPECT_EQ(typed("sightline check scenarios/paper_7_1.t", 2), "scenarios/paper_7_1.toml\n");
}

}  // namespace
}  // namespace sightline
