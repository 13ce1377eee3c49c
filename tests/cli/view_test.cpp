// The page of a flight by the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "sightline/log.hpp"
#include "tests/support/certified_view.hpp"
#include "tests/support/command.hpp"
#include "tests/support/page_client.hpp"
#include "tests/support/served.hpp"
#include "tests/support/tuned_flight.hpp"
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

/// Every message of an input in a log, in its order.
std::vector<std::string> inputs_of(const fs::path& folder) {
  std::vector<std::string> all;
  McapReader log(folder / "run.mcap");
  log.visit([&](const McapMessage& message) {
    if (message.topic.ends_with("/input"))
      all.emplace_back(reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size());
  });
  EXPECT_GT(all.size(), 100U);
  return all;
}

TEST(View, BadInputIsRefusedBeforeAnythingIsServed) {
  const fs::path folder = fresh_folder();
  const std::string file = view_file(folder);
  const auto refused = [&](const std::string& arguments, const std::string& sentence) {
    EXPECT_THAT(test::refused("view " + arguments + " --seconds 1", folder), HasSubstr(sentence));
  };
  refused("/nowhere.toml", "nowhere.toml");
  refused(folder.string(), "no run.mcap");
  refused(file + " --bind localhost", "expected an IPv4 address");
  refused(file + " --bind 192.0.2.1", "192.0.2.1:8765 cannot be listened to");
  refused(file + " --set agent.uav0.Q=1", "agent.uav0.Q");
  refused(file + " --speed 0", "--speed");
  const Served first("view " + file + " --port 0 --seconds 2");
  refused(file + " --port " + std::to_string(first.port()), "cannot be listened to");
}

TEST(View, ACertificateIsServedBesideFlightsOfItsScenario) {
  using nlohmann::json;
  const fs::path folder = fresh_folder(), file = certified_scenario(folder), certified = folder / "certified";
  const std::string text = read_file(certified / "certificate.json"), out = (folder / "out").string();
  ASSERT_NE(sightline("run " + file.string() + " -o " + out, folder).code, 2);
  const auto served_by = [&](const std::string& arguments) {
    const Served served("view " + arguments + " --port 0 --seconds 20");
    const std::string answer = PageClient(served.port()).request("GET /certificate.json");
    return json::parse(answer.substr(answer.find("\r\n\r\n")));
  };
  const std::string beside = " --certificate " + certified.string();
  const std::string tuned = " --tune -o " + (folder / "tuned").string();
  for (const std::string& of : {file.string(), out, file.string() + tuned})
    EXPECT_EQ(served_by(of + beside), json::parse(text)) << of;
  for (const std::string& of : {file.string(), out}) EXPECT_TRUE(served_by(of).is_null()) << of;

  const auto expect_refused = [&](const std::string& sentence) {
    for (const std::string& of : {file.string(), out})
      EXPECT_THAT(refused("view " + of + beside + " --port 0 --seconds 1", folder), HasSubstr(sentence))
          << of;
  };
  const auto with = [&](const json::json_pointer& key, const json& value) {
    json changed = json::parse(text);
    changed[key] = value;
    std::ofstream(certified / "certificate.json") << changed;
  };
  with(json::json_pointer("/scenario"), "another");
  expect_refused("scenario = \"another\", expected that of the flight, \"look\"");
  with(json::json_pointer("/events/0/independent/high"), 1.5);
  expect_refused("events[0].independent.high = 1.5, expected");
  with(json::json_pointer("/events/0/importance_sampling/probability"), "small");
  expect_refused(
      "events[0].importance_sampling.probability is missing or of another kind, expected a number");
  for (const char* key : {"/events", "/premises", "/scenario"}) {
    with(json::json_pointer(key), {{"a", 1}});
    expect_refused(std::string(key + 1) + " is missing or of another kind, expected a ");
  }
  with(json::json_pointer("/events"), json::array());
  expect_refused("events are none");
  std::ofstream(certified / "certificate.json") << text.substr(0, text.size() / 2);
  expect_refused("certificate.json: no JSON from byte");
  fs::remove(certified / "certificate.json");
  expect_refused("certificate.json: is missing, expected the folder of a campaign with --certify");
}

TEST(View, AFlightIsServedWhileItIsFlownAndUntilTheEnd) {
  const fs::path folder = fresh_folder();
  Served served("view " + view_file(folder) + " --port 0 --speed 4 --seconds 4");
  ASSERT_NE(served.port(), 0);
  PageClient client(served.port());
  client.watch();
  EXPECT_THAT(client.receive("\"t\":0.990"), HasSubstr("\"t\":0.990"));
  EXPECT_THAT(PageClient(served.port()).request("GET /scene.json"), HasSubstr("\"name\":\"look\""));
  EXPECT_THAT(served.end(), HasSubstr("the flight is over"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << "it writes no files";
}

TEST(View, APausedFlightShowsItsFirstMomentAndWaits) {
  Served served("view " + view_file(fresh_folder()) + " --port 0 --paused --seconds 3 < /dev/null");
  PageClient client(served.port());
  client.watch();
  EXPECT_THAT(client.receive("\"t\":0.000"), HasSubstr("\"t\":0.000"));
  EXPECT_EQ(client.receive("{\"t\"", 0.3).find("{\"t\""), std::string::npos);
  EXPECT_THAT(served.end(), HasSubstr("paused, Enter flies on"));
}

TEST(View, ALogIsServedWithAllItsMoments) {
  const fs::path folder = fresh_folder();
  const std::string out = (folder / "out").string();
  ASSERT_NE(sightline("run " + view_file(folder) + " -o " + out, folder).code, 2);
  EXPECT_THAT(refused("view " + out + " --set simulation.seed=2", folder), HasSubstr("it is flown already"));
  Served served("view " + out + " --port 0 --seconds 1");
  EXPECT_THAT(PageClient(served.port()).request("GET /moments.json"), HasSubstr("{\"t\":0.990,"));
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
    EXPECT_THAT(client.receive("\"t\":0.5"), HasSubstr("\"t\":0.5"));
    EXPECT_THAT(served.end(), HasSubstr("run.mcap"));
  }
  const CommandResult again = sightline("run " + file + " -o " + shown + " --view --port 0", folder);
  EXPECT_NE(again.code, 2) << again.err;
  EXPECT_THAT(again.err, HasSubstr("the page is http://127.0.0.1:"));
  EXPECT_EQ(read_file(plain + "/run.mcap"), read_file(shown + "/run.mcap"));
  EXPECT_EQ(sightline("run " + file + " --port 0", folder).code, 2) << "a port of no page";
}

TEST(View, OthersGetAToken) {
  Served served("view " + view_file(fresh_folder()) + " --port 0 --bind 127.0.0.2 --seconds 1");
  EXPECT_THAT(served.url(), testing::ContainsRegex("^http://127.0.0.2:[0-9]+/[?]token=[0-9a-f]{48}$"));
}

/// Sends a message and waits for the answer to it.
std::string tune(PageClient& client, const std::string& message, const std::string& id) {
  client.say(PageClient::masked(1, message));
  (void)client.receive("\"" + id + "\",", 5.0);
  return client.receive("]", 5.0);
}

// Tuned, logged, replayed, written, flown again: one flight.
TEST(View, ATunedFlightIsReplayedAndFlownAgainWithTheSameCommands) {
  const fs::path folder = fresh_folder(), file = folder / "tuned.toml";
  std::ofstream(file) << tuned_scenario(3.0);
  const std::string out = (folder / "out").string();
  std::string written, final, said;
  {
    Served served("view " + file.string() + " --tune -o " + out + " --port 0 --seconds 60");
    PageClient client(served.port());
    client.watch();
    (void)client.receive("\"t\":0.", 5.0);
    EXPECT_EQ(
        tune(client, R"({"id":"w","event":{"retune":{"couple":"bearing","weight":0.4}}})", "w").substr(0, 5),
        "true,");
    EXPECT_EQ(
        tune(client,
             R"({"id":"p","event":{"retune":{"couple":"bearing","potential":{"bearing":{"alpha":0.3}}}}})",
             "p")
            .substr(0, 5),
        "true,");
    EXPECT_THAT(tune(client, R"({"id":"n","event":{"retune":{"couple":"bearing","weight":-1}}})", "n"),
                HasSubstr("false,\"" + file.string() + ":"));
    EXPECT_EQ(
        tune(client, R"({"id":"m","event":{"move":{"obstacle":"post","p":[2,1,1]}}})", "m").substr(0, 5),
        "true,");
    EXPECT_EQ(tune(client, R"({"id":"a","event":{"wind":{"acceleration":[0.2,0,0]}}})", "a").substr(0, 5),
              "true,");
    EXPECT_TRUE(eventually([&] {
      return PageClient(served.port()).request("GET /tuned.toml").find("wind = {") != std::string::npos;
    }));
    client.receive("\"t\":2.9", 10.0);
    written = PageClient(served.port()).request("GET /tuned.toml");
    final = PageClient(served.port()).request("GET /final.toml");
  }
  const auto body = [](const std::string& answer) { return answer.substr(answer.find("\r\n\r\n") + 4); };
  const CommandResult replayed = sightline("replay " + out, folder);
  EXPECT_EQ(replayed.code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr("0 differ"));
  std::ofstream(folder / "again.toml") << body(written);
  const std::string again = (folder / "again").string();
  ASSERT_NE(sightline("run " + (folder / "again.toml").string() + " -o " + again, folder).code, 2);
  // The one may have been ended before its last period.
  std::vector<std::string> flown = inputs_of(folder / "again"), tuned = inputs_of(folder / "out");
  ASSERT_GE(flown.size(), tuned.size());
  flown.resize(tuned.size());
  EXPECT_EQ(flown, tuned);
  std::ofstream(folder / "final.toml") << body(final);
  EXPECT_EQ(sightline("check " + (folder / "final.toml").string(), folder).code, 0);
}

TEST(View, AnotherSeedBeginsAnewOnTheSamePort) {
  const fs::path folder = fresh_folder(), file = folder / "tuned.toml";
  std::ofstream(file) << tuned_scenario(60.0);
  const fs::path out = folder / "out", next = folder / "out-2";
  Served served("view " + file.string() + " --tune -o " + out.string() + " --port 0 --seconds 60");
  PageClient client(served.port());
  client.watch();
  (void)client.receive("\"t\":0.", 5.0);
  client.say(PageClient::masked(1, R"({"id":"s","seed":7})"));
  EXPECT_TRUE(eventually([&] { return fs::exists(next / "run.mcap"); }));
  EXPECT_TRUE(eventually([&] {
    return PageClient(served.port()).request("GET /scene.json").find("\"live\":true") != std::string::npos;
  }));
}

TEST(View, TuningIsRefusedWhereItCannotBe) {
  const fs::path folder = fresh_folder();
  const std::string file = view_file(folder);
  const auto refused = [&](const std::string& arguments, const std::string& sentence) {
    EXPECT_THAT(test::refused(arguments, folder), HasSubstr(sentence));
  };
  refused("run " + file + " --view --tune --port 0", "expected beside --realtime");
  refused("view " + file + " --seconds 1 -o x", "expected beside --tune");
  refused("view " + file + " --seconds 1 --tune --set solver.name=cgmres", "expected newton_riccati");
}

}  // namespace
}  // namespace sightline::test
