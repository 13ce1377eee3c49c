// The page of a flight by the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/command.hpp"
#include "tests/support/page_client.hpp"
#include "tests/support/served.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

std::string view_file(const fs::path& folder) {
  const fs::path file = folder / "look.toml";
  std::ofstream(file) << view_scenario;
  return file.string();
}

TEST(View, BadInputIsRefusedBeforeAnythingIsServed) {
  const fs::path folder = fresh_folder();
  const std::string file = view_file(folder);
  const auto refused = [&](const std::string& arguments, const std::string& sentence) {
    const CommandResult told = sightline("view " + arguments + " --seconds 1", folder);
    EXPECT_EQ(told.code, 2) << arguments;
    EXPECT_EQ(told.out, "") << arguments;
    EXPECT_THAT(told.err, HasSubstr(sentence)) << arguments;
  };
  refused("/nowhere.toml", "nowhere.toml");
  refused(folder.string(), "no run.mcap");
  refused(file + " --listen localhost", "expected an IPv4 address");
  refused(file + " --listen 192.0.2.1", "192.0.2.1:8765 cannot be listened to");
  refused(file + " --set agent.uav0.Q=1", "agent.uav0.Q");
  refused(file + " --speed 0", "--speed");
  const Served first("view " + file + " --port 0 --seconds 2");
  refused(file + " --port " + std::to_string(first.port()), "cannot be listened to");
}

TEST(View, AFlightIsServedWhileItIsFlownAndUntilTheEnd) {
  const fs::path folder = fresh_folder();
  Served served("view " + view_file(folder) + " --port 0 --speed 4 --seconds 4");
  ASSERT_NE(served.port(), 0);
  PageClient client(served.port());
  client.watch();
  EXPECT_THAT(client.hear("\"t\":0.990"), HasSubstr("\"t\":0.990"));
  EXPECT_THAT(PageClient(served.port()).ask("GET /scene.json"), HasSubstr("\"name\":\"look\""));
  EXPECT_THAT(served.end(), HasSubstr("the flight is over"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << "it writes no files";
}

TEST(View, APausedFlightShowsItsFirstMomentAndWaits) {
  Served served("view " + view_file(fresh_folder()) + " --port 0 --paused --seconds 3 < /dev/null");
  PageClient client(served.port());
  client.watch();
  EXPECT_THAT(client.hear("\"t\":0.000"), HasSubstr("\"t\":0.000"));
  EXPECT_EQ(client.hear("{\"t\"", 0.3).find("{\"t\""), std::string::npos);
  EXPECT_THAT(served.end(), HasSubstr("paused, Enter flies on"));
}

TEST(View, ALogIsServedWithAllItsMoments) {
  const fs::path folder = fresh_folder();
  const std::string out = (folder / "out").string();
  ASSERT_NE(sightline("run " + view_file(folder) + " -o " + out, folder).code, 2);
  const CommandResult set = sightline("view " + out + " --set simulation.seed=2", folder);
  EXPECT_EQ(set.code, 2);
  EXPECT_THAT(set.err, HasSubstr("it is flown already"));
  Served served("view " + out + " --port 0 --seconds 1");
  EXPECT_THAT(PageClient(served.port()).ask("GET /moments.json"), HasSubstr("{\"t\":0.990,"));
  EXPECT_THAT(served.end(), HasSubstr("1 connections, 0 refused"));
}

TEST(View, ARunThatIsLookedAtFliesTheSameBytes) {
  const fs::path folder = fresh_folder();
  const std::string file = view_file(folder), plain = (folder / "plain").string(),
                    shown = (folder / "shown").string();
  ASSERT_NE(sightline("run " + file + " -o " + plain, folder).code, 2);
  {
    Served served("run " + file + " -o " + shown + " --realtime --view --port 0");
    PageClient client(served.port());
    client.watch();
    EXPECT_THAT(client.hear("\"t\":0.5"), HasSubstr("\"t\":0.5"));
    EXPECT_THAT(served.end(), HasSubstr("run.mcap"));
  }
  const CommandResult again = sightline("run " + file + " -o " + shown + " --view --port 0", folder);
  EXPECT_NE(again.code, 2) << again.err;
  EXPECT_THAT(again.err, HasSubstr("the page is http://127.0.0.1:"));
  EXPECT_EQ(read_file(plain + "/run.mcap"), read_file(shown + "/run.mcap"));
  EXPECT_EQ(sightline("run " + file + " --port 0", folder).code, 2) << "a port of no page";
}

TEST(View, OthersGetAToken) {
  Served served("view " + view_file(fresh_folder()) + " --port 0 --listen 127.0.0.2 --seconds 1");
  EXPECT_THAT(served.url(), testing::ContainsRegex("^http://127.0.0.2:[0-9]+/[?]token=[0-9a-f]{48}$"));
}

}  // namespace
}  // namespace sightline::test
