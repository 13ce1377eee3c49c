// The page in a browser: it loads without a fault, draws, plays a log, and comes back after its
// server.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "sightline/server/page_server.hpp"
#include "tests/support/certified_view.hpp"
#include "tests/support/command.hpp"
#include "tests/support/page_client.hpp"
#include "tests/support/served.hpp"
#include "tests/support/tuned_flight.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline::test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// Longer than a browser takes to begin on a machine that does other things too.
constexpr int live_seconds = 60;  // [s]

fs::path page_scenario(const fs::path& folder, int seconds) {
  fs::path file = folder / "page.toml";
  std::string text = view_scenario;
  text.replace(text.rfind("duration = 1.0"), 14, fmt::format("duration = {}.0", seconds));
  std::ofstream(file) << text;
  return file;
}

/// The address of a page on a port.
std::string address(std::uint16_t port) { return fmt::format("http://127.0.0.1:{}/", port); }

std::uint16_t free_port() { return PageServer({}, {}).port(); }

/// What the browser answers to the steps, one each.
std::vector<json> browse(const std::string& url, const std::string& steps, const fs::path& folder) {
  const CommandResult reported =
      shell("printf '" + steps + "quit\\n' | timeout 120 env " SIGHTLINE_BROWSER " " + url, folder);
  EXPECT_EQ(reported.code, 0) << reported.err;
  std::vector<json> answers;
  std::istringstream lines(reported.out);
  for (std::string line; std::getline(lines, line);) answers.push_back(json::parse(line));
  return answers;
}

void expect_drawn(const json& look) {
  EXPECT_EQ(look["faults"], json::array());
  EXPECT_GT(look["colours"], 8) << "the canvas is blank";
  EXPECT_GE(look["curves"], 4);
  EXPECT_GT(look["fps"], 0.0);
  EXPECT_GE(look["fps"].get<double>(), 0.5 * look["due"].get<double>() - 1.0)
      << look["turns"];  // on any machine
  EXPECT_EQ(look["overflow"], false);
  EXPECT_THAT(look["statuses"].get<std::string>(), testing::HasSubstr("uav0"));
}

TEST(Page, ALogPlaysAndIsSought) {
  const fs::path folder = fresh_folder();
  const std::string out = (folder / "out").string();
  ASSERT_NE(sightline("run " + page_scenario(folder, 9).string() + " -o " + out, folder).code, 2);
  const Served served("view " + out + " --port 0 --seconds 30");
  const auto answers = browse(
      served.url(),
      "wait finished\\nlook\\nlook\\ntime 4\\npause 3\\nlook\\ntheme\\nkey c\\nkey c\\nkey c\\nlook\\n",
      folder);
  ASSERT_EQ(answers.size(), 11U);
  for (const std::size_t look : {1U, 2U, 5U, 10U}) expect_drawn(answers[look]);
  EXPECT_EQ(answers[9]["camera"], "pair 0");
  EXPECT_GE(answers[2]["pixels"], 0.49);
  EXPECT_NEAR(answers[5]["pixels"].get<double>(), 1.0, 0.01) << "what rests has all its pixels";
  EXPECT_LT(answers[1]["weight"], 800e3);
  EXPECT_GT(answers[2]["t"], answers[1]["t"]);
  EXPECT_EQ(answers[5]["t"], 4.0);
  EXPECT_GE(answers[1]["moments"], 800);
  EXPECT_GE(answers[1]["marks"], 1);
}

/// One flight keeps what its campaign bounds; the other looks away at first and begins too near.
TEST(Page, ACertificateIsShownBesideTheFiguresOfTheFlight) {
  const fs::path folder = fresh_folder(), file = certified_scenario(folder);
  const json certificate = json::parse(read_file(folder / "certified" / "certificate.json"));
  const std::string wrong = " --set agent.uav0.start.heading=3.14 --set 'obstacle.post.p=[0.9,0.4,0.5]'";
  for (const bool keeps : {true, false}) {
    const fs::path out = folder / (keeps ? "kept" : "broken");
    ASSERT_NE(sightline("run " + file.string() + (keeps ? "" : wrong) + " -o " + out.string(), folder).code,
              2);
    const Served served("view " + out.string() + " --certificate " + (folder / "certified").string() +
                        " --port 0 --seconds 40");
    const json look = browse(served.url(), "wait finished\\nmoments 300\\nlook\\n", folder).at(2);
    expect_drawn(look);
    const auto panel = look["certificate"].get<std::string>();
    const auto count = [&](std::string_view word) {
      int found = 0;
      for (std::size_t at = panel.find(word); at != std::string::npos; at = panel.find(word, at + 1)) ++found;
      return found;
    };
    EXPECT_EQ(count("inside"), keeps ? 3 : 1) << panel;
    EXPECT_EQ(count("outside"), keeps ? 0 : 2) << panel;
    for (const json& event : certificate["events"])
      EXPECT_THAT(panel, testing::HasSubstr(event["event"].get<std::string>()));
    EXPECT_THAT(panel, testing::HasSubstr("0 of 5 runs"));
    EXPECT_THAT(panel, testing::HasSubstr("Premises"));
    EXPECT_EQ(count("0.10 m below"), keeps ? 0 : 1) << panel << ": 0.4 m from a post of 0.5 m";
  }
}

TEST(Page, ALiveFlightIsShownAndThePageComesBackAfterItsServer) {
  const fs::path folder = fresh_folder();
  const std::string file = page_scenario(folder, live_seconds).string();
  const std::uint16_t port = free_port();
  const std::string arguments = "view " + file + " --port " + std::to_string(port) + " --seconds 60";
  std::vector<json> answers;
  std::optional<Served> server(arguments);
  EXPECT_EQ(server->port(), port) << server->end();
  std::thread browser([&] {
    answers = browse(address(port),
                     "wait live\\nmoments 20\\nlook\\nwait lost\\nwait live\\nmoments 20\\nlook\\n", folder);
  });
  const auto answered = [&](long count) {
    return eventually([&] { return lines(read_file(folder / "stdout.txt")) >= count; });
  };
  EXPECT_TRUE(answered(3));
  server.reset();
  EXPECT_TRUE(answered(4));
  server.emplace(arguments);
  browser.join();
  ASSERT_EQ(answers.size(), 7U);
  expect_drawn(answers[2]);
  expect_drawn(answers[6]);
}

/// With more than these, a small machine's processor only draws pictures. Ten clients that draw
/// nothing are a figure of scripts/accept/15.sh.
TEST(Page, ThreeMoreLookOnAtOnce) {
  const fs::path folder = fresh_folder();
  const Served server("view " + page_scenario(folder, live_seconds).string() + " --port 0 --seconds 60");
  const auto answers = browse(server.url(), "wait live\\npages 3\\nlook\\n", folder);
  ASSERT_EQ(answers.size(), 3U);
  ASSERT_EQ(answers[1]["moments"].size(), 3U);
  expect_drawn(answers[2]);
}

/// A run that is killed while two pages look on, one of them at the growing log by another server.
TEST(Page, ALogThatIsStillWrittenIsShownAsItGrowsAndAsItEnded) {
  const fs::path folder = fresh_folder();
  const std::string out = (folder / "out").string();
  std::string text = view_scenario;
  text.replace(text.rfind("duration = 1.0"), 14, "duration = 60.0");
  std::ofstream(folder / "long.toml") << text;
  std::optional<Served> run("run " + (folder / "long.toml").string() + " -o " + out +
                            " --realtime --view --port 0");
  ASSERT_TRUE(eventually([&] { return fs::exists(out + "/run.mcap"); }));
  const std::uint16_t port = free_port();
  const std::string arguments = "view " + out + " --seconds 60 --port " + std::to_string(port);
  std::optional<Served> server(arguments);
  std::vector<json> answers;
  std::thread browser([&] {
    answers = browse(
        address(port),
        "wait growing\\nnewest\\nlook\\nlook\\nwait lost\\nwait growing\\nlook\\nwait broken\\nlook\\n",
        folder);
  });
  const auto answered = [&](long count) {
    return eventually([&] { return lines(read_file(folder / "stdout.txt")) >= count; });
  };
  EXPECT_TRUE(answered(4));
  server.reset();
  EXPECT_TRUE(answered(5));
  server.emplace(arguments);
  EXPECT_TRUE(answered(7));
  run.reset();
  browser.join();
  ASSERT_EQ(answers.size(), 9U);
  for (const std::size_t look : {2U, 3U, 6U, 8U}) expect_drawn(answers[look]);
  EXPECT_GT(answers[3]["t"], answers[2]["t"]);
  EXPECT_GT(answers[6]["t"], answers[3]["t"]);  // the same log: it went on from where it was
  EXPECT_GE(answers[8]["moments"], answers[6]["moments"]);
}

// A slider, a key, the mouse and a button change the flight, which is logged, written and flown
// again with the same commands.
TEST(Page, AFlightIsTunedInTheBrowser) {
  const fs::path folder = fresh_folder(), file = folder / "page.toml";
  std::ofstream(file) << tuned_scenario(60.0);
  const std::string out = (folder / "tuned").string();
  std::string written;
  {
    Served served("view " + file.string() + " --tune -o " + out + " --port 0 --seconds 60");
    const auto answers =
        browse(served.url(),
               "wait live\\nmoments 20\\nslide weight 0.4\\nanswer weight 0.4\\narrow weight ArrowRight\\n"
               "answer weight 0.56\\ndrag 0 60 0\\nanswer another reference for uav1\\npress Pause flight\\n"
               "answer paused\\npress Step\\nanswer 1 period\\npress Fly on\\nanswer flies on\\nlook\\n",
               folder);
    ASSERT_EQ(answers.size(), 15U) << served.end();
    expect_drawn(answers[14]);
    written = PageClient(served.port()).request("GET /tuned.toml");
  }
  EXPECT_THAT(written, testing::HasSubstr("retune = { couple = \"bearing\", weight = 0.4 }"));
  EXPECT_THAT(written, testing::HasSubstr("reference = { agent = \"uav1\""));
  const CommandResult replayed = sightline("replay " + out + " --json", folder);
  EXPECT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_EQ(json::parse(replayed.out)["differing"], 0);
}

TEST(ReportPage, ShowsCurvesReadsThemZoomsAndPrints) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  ASSERT_NE(sightline("run " + page_scenario(folder, 4).string() + " -o " + out.string(), folder).code, 2);
  const auto answers = browse("file://" + (out / "report.html").string(),
                              "figures\\npoint 1 0.5\\npoint 1 0.3 0.5\\npoint 0 0.5\\nprint\\n", folder);
  ASSERT_EQ(answers.size(), 5U);
  EXPECT_EQ(answers[0]["faults"], json::array());
  std::size_t drawn = 0;
  for (const json& figure : answers[0]["figures"]) {
    for (const json& curves : figure["panels"]) EXPECT_GE(curves, 1) << figure["title"];
    drawn += figure["panels"].size();
  }
  EXPECT_GE(drawn, 10U);
  // Of 900 px, the axes begin at 102 px and are 780 px wide. Both panels of the first figure have
  // the same time axis.
  const auto time_at = [](double part, double low, double high) {
    return low + (900 * part - 102) / 780 * (high - low);
  };
  const auto time_of = [](const json& reading) { return std::stod(reading.get<std::string>().substr(6)); };
  ASSERT_EQ(answers[1]["readings"].size(), 2U);
  EXPECT_THAT(answers[1]["readings"][0].get<std::string>(), testing::HasSubstr("distance D: "));
  EXPECT_THAT(answers[1]["readings"][1].get<std::string>(), testing::HasSubstr("view angle"));
  EXPECT_NEAR(time_of(answers[1]["readings"][0]), time_at(0.5, 0.0, 4.0), 0.05);
  EXPECT_NE(answers[2]["ticks"], answers[1]["ticks"]);
  EXPECT_NEAR(time_of(answers[3]["readings"][1]),
              time_at(0.5, time_at(0.3, 0.0, 4.0), time_at(0.5, 0.0, 4.0)), 0.05);
  EXPECT_EQ(answers[4]["paper"], "rgb(255, 255, 255)");
  EXPECT_EQ(answers[4]["cut"], "avoid");
}

}  // namespace
}  // namespace sightline::test
