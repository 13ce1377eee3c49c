#include "cli/output.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/socket.h>

#include "sightline/log.hpp"
#include "tests/support/child.hpp"
#include "tests/support/command.hpp"

namespace sightline::cli {
namespace {

namespace fs = std::filesystem;
using test::Child;
using test::eventually;
using test::fresh_folder;
using test::shell;
using test::short_scenario;
using testing::HasSubstr;

const std::string binary = "'" SIGHTLINE_BINARY "' ";

TEST(Output, ResultsThatNobodyGetsAreAFailureThatIsSaid) {
  const fs::path folder = fresh_folder();
  for (const char* words : {"version", "--help", "run --help", "check scenarios/paper_7_1.toml",
                            "explain scenarios/paper_7_1.toml"}) {
    for (const char* stream : {" >/dev/full", " >&-", " </dev/null >&0"}) {
      const auto done = shell(binary + words + stream, folder);
      EXPECT_EQ(done.code, 1) << words << stream;
      EXPECT_THAT(done.err, HasSubstr("sightline: stdout: ")) << words << stream;
      EXPECT_THAT(done.err, HasSubstr(", the results could not be shown there\n")) << words << stream;
    }
  }
  const auto left = shell("( sleep 0.2; " + binary + "version; echo $? >&2 ) | true", folder);
  EXPECT_THAT(left.err, HasSubstr("Broken pipe"));
  EXPECT_THAT(left.err, testing::EndsWith("\n1\n"));
}

TEST(Output, ARefusalIsOneWhoeverHearsIt) {
  const fs::path folder = fresh_folder();
  for (const char* words : {"", "fly", "run", "check none.toml", "run none.toml", "campaign none.toml",
                            "report none", "explain none.toml", "potential none.toml", "bench --case none"}) {
    for (const char* streams :
         {" 2>&-", " 2>/dev/full", " >&- 2>&-", " >/dev/full 2>/dev/full", " <&- >&- 2>&-"})
      EXPECT_EQ(shell(binary + words + streams, folder).code, 2) << words << streams;
  }
}

TEST(Output, NoFileOfOursIsOpenedInPlaceOfAClosedStream) {
  const fs::path folder = fresh_folder(), open = folder / "open", closed = folder / "closed";
  const std::string run =
      binary + "run " + short_scenario(folder, "paper_7_1_joint", "0.5").string() + " -o ";
  (void)shell(run + open.string(), folder);
  EXPECT_EQ(shell(run + closed.string() + " <&- >&- 2>&-", folder).code, 1);
  const std::string log = test::read_file(open / "run.mcap");
  EXPECT_GT(log.size(), 10'000U);
  EXPECT_TRUE(test::read_file(closed / "run.mcap") == log);
}

TEST(Output, AFileThatMayNotGrowIsToldAndNoSignal) {
  const fs::path folder = fresh_folder();
  const auto run =
      shell("ulimit -f 64; " + binary + "run " + short_scenario(folder, "paper_7_1_joint", "2.0").string() +
                " -o " + (folder / "out").string(),
            folder);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, testing::ContainsRegex("run.mcap: cannot be written at byte [0-9]+: File too large"));
  EXPECT_TRUE(fs::exists(folder / "out" / "summary.json"));
  EXPECT_GT(read_recording(folder / "out").time.size(), 10U) << "what was written opens";
}

// Whoever gets neither messages nor progress: a pipe, a socket, a terminal, that is full and that
// nobody reads.
TEST(Output, AStreamThatNobodyReadsHoldsNothingUp) {
  const fs::path folder = fresh_folder();
  for (const char* kind : {"pipe", "socket", "terminal"}) {
    // Beside its comparisons the first tells of three faults, of which each may wait.
    const std::string scenario =
        short_scenario(folder, *kind == 'p' ? "paper_7_1" : "paper_7_1_joint", "0.5");
    int ends[2];  // we, they
    const int made = *kind == 'p'   ? ::pipe(ends)
                     : *kind == 's' ? ::socketpair(AF_UNIX, SOCK_STREAM, 0, ends)
                                    : ::openpty(&ends[0], &ends[1], nullptr, nullptr, nullptr);
    ASSERT_EQ(made, 0) << kind;
    ::fcntl(ends[1], F_SETFL, O_NONBLOCK);
    const std::string much(4096, 'x');
    while (::write(ends[1], much.data(), much.size()) > 0) {
    }
    while (::write(ends[1], "x", 1) > 0) {
    }
    ::fcntl(ends[1], F_SETFL, 0);
    const std::string out = folder / kind;
    Child child({"run", scenario, "-o", out}, [&] {
      ::dup2(ends[1], STDERR_FILENO);
      ::dup2(::open("/dev/null", O_WRONLY), STDOUT_FILENO);
    });
    EXPECT_TRUE(eventually([&] { return child.ended(); })) << kind;
    EXPECT_TRUE(child.code() == 0 || child.code() == 1) << kind;
    EXPECT_TRUE(read_recording(out).complete) << kind;
    ::close(ends[0]);
    ::close(ends[1]);
  }
}

TEST(Output, ATerminalThatHangsUpEndsNoFlight) {
  const fs::path folder = fresh_folder();
  int terminal = -1;
  const std::string scenario = short_scenario(folder, "paper_7_1_joint", "1.0").string(),
                    out = folder / "out";
  const pid_t child = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::execl(SIGHTLINE_BINARY, "sightline", "run", "--realtime", scenario.c_str(), "-o", out.c_str(), nullptr);
    ::_exit(127);
  }
  EXPECT_TRUE(eventually([&] { return fs::exists(fs::path(out) / "run.mcap"); }));
  ::close(terminal);
  int status = -1;
  EXPECT_TRUE(eventually([&] { return ::waitpid(child, &status, WNOHANG) == child; }));
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1) << "the results are lost";
  EXPECT_TRUE(read_recording(out).complete);
  EXPECT_TRUE(fs::exists(fs::path(out) / "report.html"));
}

}  // namespace
}  // namespace sightline::cli
