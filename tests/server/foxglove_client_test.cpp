// The protocol's own client, of npm, at a flight and at a log.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/command.hpp"
#include "tests/support/served.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline::test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// @param duration  [s]
fs::path scenario_of_clients(const fs::path& folder, std::string_view duration) {
  const fs::path file = folder / "listened.toml";
  std::string text = view_scenario;
  text.replace(text.rfind("duration = 1.0"), 14, fmt::format("duration = {}", duration));
  std::ofstream(file) << text;
  return file;
}

/// What the client heard of all topics in so long [s].
json hear_topics(const Served& served, double seconds, const fs::path& folder) {
  const fs::path npm = fs::path(SIGHTLINE_SOURCE_DIR) / "tests" / "npm";
  EXPECT_TRUE(fs::exists(npm / "node_modules" / "@foxglove" / "ws-protocol"))
      << "tests/npm/node_modules is old or missing, run scripts/test.sh, which installs it";
  const CommandResult reported =
      shell(fmt::format("timeout 60 node '{}' ws://127.0.0.1:{}/ {}", (npm / "foxglove_client.mjs").string(),
                        served.port(), seconds),
            folder);
  EXPECT_EQ(reported.code, 0) << reported.err;
  return reported.code == 0 ? json::parse(reported.out) : json();
}

void expect_topics_of_the_log(const json& received) {
  EXPECT_EQ(received["protocol"], "foxglove.websocket.v1");
  EXPECT_EQ(received["name"], "listened");
  EXPECT_EQ(received["statuses"], json::array());
  EXPECT_GT(received["times"]["count"], 10);
  for (const char* topic :
       {"/uav0/pose", "/uav1/pose", "/post/pose", "/uav0/twist", "/uav0/state", "/uav1/input"}) {
    const json& one = received["topics"][topic];
    ASSERT_GT(one.value("count", 0), 100) << topic;
    EXPECT_NEAR(one["gap"].get<double>(), 0.01, 1e-9) << topic;  // 100 Hz
    EXPECT_NEAR(one["last"].get<double>() - one["first"].get<double>(),
                0.01 * (one["count"].get<double>() - 1), 1e-6);
  }
  for (const char* topic : {"/uav0/path", "/uav1/reference", "/scene", "/diagnostics", "/tf", "/solver"})
    EXPECT_GT(received["topics"][topic].value("count", 0), 5) << topic;

  const json pose = received["topics"]["/post/pose"]["message"];
  EXPECT_EQ(pose["header"]["frame_id"], "map");
  EXPECT_EQ(pose["pose"]["position"], json({{"x", 4.0}, {"y", 0.0}, {"z", 1.0}}));
  const json turn = received["topics"]["/uav0/pose"]["message"]["pose"]["orientation"];
  EXPECT_NEAR(std::hypot(turn["z"].get<double>(), turn["w"].get<double>()), 1.0, 1e-9);
  EXPECT_EQ(received["topics"]["/uav0/path"]["message"]["poses"].size(), 21U);
  EXPECT_EQ(received["topics"]["/tf"]["message"]["transforms"][2]["child_frame_id"], "post");
  EXPECT_EQ(received["topics"]["/tf"]["message"]["transforms"][2]["transform"]["translation"]["x"], 4.0);
  std::string drawn;
  for (const json& marker : received["topics"]["/scene"]["message"]["markers"])
    drawn += marker["ns"].get<std::string>() + " ";
  for (const char* group : {"robots", "bodies", "names", "views", "links", "distances"})
    EXPECT_NE(drawn.find(group), std::string::npos) << group << " in " << drawn;
  const json diagnosed = received["topics"]["/diagnostics"]["message"]["status"];
  ASSERT_EQ(diagnosed.size(), 3U);
  EXPECT_EQ(diagnosed[0]["name"], "sightline: solver");
  EXPECT_EQ(diagnosed[0]["level"], 0);
  EXPECT_EQ(diagnosed[1]["name"], "sightline: uav0");
  EXPECT_EQ(diagnosed[1]["level"], 0);
}

TEST(FoxgloveClient, GetsTheTopicsOfALiveFlightAndItsPosesAtEachPeriod) {
  const fs::path folder = fresh_folder();
  // Long enough for a client that comes late, on a busy machine.
  const Served served("view " + scenario_of_clients(folder, "25.0").string() + " --port 0 --seconds 30");
  const json received = hear_topics(served, 3.0, folder);
  expect_topics_of_the_log(received);
}

TEST(FoxgloveClient, GetsTheSameOfALogThatIsPlayed) {
  const fs::path folder = fresh_folder();
  const std::string out = (folder / "out").string();
  ASSERT_NE(sightline("run " + scenario_of_clients(folder, "4.0").string() + " -o " + out, folder).code, 2);
  const Served served("view " + out + " --port 0 --seconds 30");
  const json received = hear_topics(served, 3.0, folder);
  expect_topics_of_the_log(received);
  EXPECT_EQ(received["topics"]["/uav0/pose"]["first"], 0.0);
}

}  // namespace
}  // namespace sightline::test
