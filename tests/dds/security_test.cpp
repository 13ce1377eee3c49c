#include "bridges/dds/security.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>

#include "bridges/dds/topics/channel.hpp"
#include "tests/dds/fly.hpp"
#include "tests/dds/keys.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/refusal.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Odometry = px4_msgs_msg_dds__VehicleOdometry_;

class Security : public FlyTest {
 protected:
  FleetNetwork with(const fs::path& keys) const {
    FleetNetwork network = test::own_network();
    network.keys = keys;
    return network;
  }
  /// The keys of a fleet that must be refused once they are changed so.
  std::string refused_keys(const std::string& change) {
    const fs::path keys = folder / fmt::format("changed{}", ++changed_);
    fs::copy(fleet_keys(), keys, fs::copy_options::recursive);
    EXPECT_EQ(test::shell("cd '" + keys.string() + "/flyer' && " + change, folder).code, 0) << change;
    return refusal_of([&] { check_keys(keys, Identity::flyer); });
  }
  const fs::path& fleet_keys() {
    if (keys_.empty()) keys_ = keys_in(folder / "keys");
    return keys_;
  }
  const fs::path& foreign_keys() {
    if (foreign_.empty()) foreign_ = keys_in(folder / "foreign");
    return foreign_;
  }

 private:
  fs::path keys_, foreign_;
  int changed_ = 0;
};

/// One who writes to a topic as fast as a vehicle, and hears the others: each message names who
/// sent it.
class Talker {
 public:
  Talker(dds_entity_t participant, std::uint64_t number)
      : number_(number),
        in_(participant, px4_msgs_msg_dds__VehicleOdometry__desc, "/talk", of_sensors, 114, Writers::all,
            taking<Odometry>([this](const Odometry& m, const Arrival&) { ++received_.at(m.timestamp); })),
        out_(participant, px4_msgs_msg_dds__VehicleOdometry__desc, "/talk", of_px4_output) {}

  void say() {
    Odometry m{};
    m.timestamp = number_;
    out_(m);
  }
  int received(std::uint64_t other) const { return received_.at(other); }

 private:
  std::uint64_t number_;
  std::array<std::atomic<int>, 5> received_{};
  RawReader in_;
  Writer<Odometry> out_;
};

TEST_F(Security, AStrangerAndOneOfAnotherAuthorityExchangeNothingWithTheFleet) {
  const Domain flyer(with(fleet_keys()));
  const OtherProgram vehicles(with(fleet_keys()), Identity::vehicles), stranger(with({}), Identity::flyer),
      foreign(with(foreign_keys()), Identity::flyer), another(with({}), Identity::flyer);
  std::array<std::unique_ptr<Talker>, 5> all;
  std::uint64_t number = 0;
  for (const dds_entity_t one : {flyer.participant(), vehicles.participant(), stranger.participant(),
                                 foreign.participant(), another.participant()}) {
    ASSERT_GT(one, 0) << number << last_complaint();
    all.at(number) = std::make_unique<Talker>(one, number), ++number;
  }
  // The fleet talks for 2 s, after it has met.
  const auto talk = [&] {
    for (const auto& one : all) one->say();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  };
  ASSERT_TRUE(test::eventually(
      [&] {
        talk();
        return all[0]->received(1) > 0 && all[1]->received(0) > 0;
      },
      std::chrono::seconds(20)))
      << last_complaint();
  for (int k = 0; k < 200; ++k) talk();
  EXPECT_GT(all[0]->received(1), 100);
  EXPECT_GT(all[1]->received(0), 100);
  // Strangers hear each other: it is the keys that keep them out.
  EXPECT_GT(all[2]->received(4), 100);
  EXPECT_GT(all[4]->received(2), 100);
  for (const std::uint64_t ours : {0U, 1U}) {
    for (const std::uint64_t other : {2U, 3U, 4U}) {
      EXPECT_EQ(all.at(ours)->received(other), 0) << other << " to " << ours;
      EXPECT_EQ(all.at(other)->received(ours), 0) << ours << " to " << other;
    }
  }
  for (auto& one : all) one.reset();
}

TEST_F(Security, KeysThatDoNotHoldAreRefusedWithASentence) {
  EXPECT_NO_THROW(check_keys(fleet_keys(), Identity::flyer));
  EXPECT_NO_THROW(check_keys(fleet_keys(), Identity::vehicles));
  EXPECT_THAT(
      refused_keys("rm permissions.p7s"),
      AllOf(HasSubstr("fleet.security: "), HasSubstr("flyer/permissions.p7s cannot be read, expected")));
  EXPECT_THAT(refused_keys("cp ../vehicles/key.pem ."),
              HasSubstr("key.pem is not the key of cert.pem, expected the two of one identity"));
  EXPECT_THAT(refused_keys("echo none >key.pem"), HasSubstr("key.pem is no private key, expected"));
  EXPECT_THAT(refused_keys("echo none >cert.pem"), HasSubstr("cert.pem is no certificate, expected"));
  const std::string from = "cp '" + foreign_keys().string() + "/flyer/";
  EXPECT_THAT(refused_keys(from + "key.pem' . && " + from + "cert.pem' ."),
              HasSubstr("cert.pem is not signed by identity_ca.cert.pem, expected"));
  EXPECT_THAT(
      refused_keys("openssl ec -in key.pem -aes128 -passout pass:secret -out locked && mv locked key.pem"),
      HasSubstr("key.pem is no private key, expected one in PEM without a passphrase"));
  EXPECT_THAT(refusal_of([&] { check_keys(fleet_keys(), Identity::flyer, {}); }),
              HasSubstr("built without the security plugins of Cyclone DDS, expected one with them"));
  SecurityPlugins moved = plugins_found();
  moved.access_control = "/nowhere/libdds_security_ac.so";
  EXPECT_THAT(refusal_of([&] { check_keys(fleet_keys(), Identity::flyer, moved); }),
              HasSubstr("/nowhere/libdds_security_ac.so is missing, expected"));
}

TEST_F(Security, ACertificateThatEndedIsRefusedByUsAndByCycloneDds) {
  const fs::path old = keys_in(folder / "old", "--days -1");
  EXPECT_THAT(
      refusal_of([&] { Domain domain(with(old)); }),
      AllOf(HasSubstr("flyer/cert.pem holds until 20"), HasSubstr("expected one that holds for a flight")));
  EXPECT_LT(OtherProgram(with(old), Identity::flyer).participant(), 0);
}

TEST_F(Security, WhatThePermissionsDoNotAllowIsNotWrittenAndOfAnotherNameTheyDoNotCount) {
  const auto make = [&](const fs::path& keys, Identity who, const std::string& topic) {
    return refusal_of<std::runtime_error>([&] {
      const Domain domain(with(keys), {}, who);
      const RawWriter out(domain.participant(), px4_msgs_msg_dds__VehicleOdometry__desc, topic, of_sensors);
    });
  };
  const std::string in = "/px4_1/fmu/in/trajectory_setpoint", out = "/fmu/out/vehicle_odometry";
  const std::string not_allowed = ": Not Allowed By Security";
  EXPECT_EQ(make(fleet_keys(), Identity::flyer, in), "");
  EXPECT_EQ(make(fleet_keys(), Identity::vehicles, out), "");
  EXPECT_THAT(make(fleet_keys(), Identity::flyer, out), HasSubstr("writer of rt" + out + not_allowed));
  EXPECT_THAT(make(fleet_keys(), Identity::vehicles, in), HasSubstr("writer of rt" + in + not_allowed));
  // An observer's, and a robot's that says no more than where it is.
  const fs::path more = keys_in(folder / "more", "--only 'rt/r/odom'", "flyer");
  made_keys(folder / "more", "'" + (folder / "more").string() + "' vehicles_of_others");
  fs::rename(folder / "more/vehicles_of_others", folder / "more/vehicles");
  EXPECT_EQ(make(more, Identity::flyer, "/r/odom"), "");
  EXPECT_THAT(make(more, Identity::flyer, in), HasSubstr(not_allowed));
  EXPECT_THAT(make(more, Identity::vehicles, out), HasSubstr(not_allowed));
  // Those of another, and those that another authority signed.
  for (const fs::path& from : {fleet_keys() / "vehicles", foreign_keys() / "flyer"}) {
    const fs::path keys = folder / from.parent_path().filename() += "_mixed";
    fs::copy(fleet_keys(), keys, fs::copy_options::recursive);
    fs::copy_file(from / "permissions.p7s", keys / "flyer/permissions.p7s",
                  fs::copy_options::overwrite_existing);
    EXPECT_THAT(make(keys, Identity::flyer, in), HasSubstr("fleet.domain = ")) << from;
  }
}

class SecureFlight : public Security {
 protected:
  /// The shipped fleet with keys, or without them.
  fs::path fleet_with(const std::string& keys, const std::string& duration) {
    std::string text = test::read_file(desk(duration));
    if (!keys.empty()) text.insert(text.find("\ndomain = "), "\nsecurity = { folder = \"" + keys + "\" }");
    fs::path file = folder / ("with_" + keys + ".toml");
    std::ofstream(file) << text;
    return file;
  }
};

TEST_F(SecureFlight, AFleetWithKeysFliesAndIsReplayedWithoutThem) {
  fleet_keys();
  const fs::path fleet = fleet_with("keys", "1.0");
  EXPECT_THAT(test::sightline("check " + fleet.string(), folder).out,
              HasSubstr("no multicast, DDS security; "));
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto flown = test::sightline("fly " + fleet.string() + " -o " + (folder / "flown").string(), folder);
  EXPECT_EQ(flown.code, 0) << flown.err << printed("vehicles.err");
  vehicles->end(SIGINT);
  EXPECT_THAT(printed("vehicles.out"), HasSubstr("(0 outside offboard, 0 bad)"));
  EXPECT_THAT(printed("vehicles.out"), Not(HasSubstr("failsafe")));
  fs::remove_all(folder / "keys");
  expect_replayed("flown");
  const auto without = test::sightline("fly " + fleet.string(), folder);
  EXPECT_EQ(without.code, 2);
  EXPECT_THAT(without.err,
              HasSubstr("fleet.security.folder = \"keys\", expected a folder with flyer/ or vehicles/"));
}

TEST_F(SecureFlight, VehiclesWithoutKeysAreNobodyToAFlyerWithKeys) {
  fleet_keys();
  const auto vehicles = begin({"vehicles", fleet_with("", "1.0").string()}, "vehicles");
  ASSERT_TRUE(prints("vehicles.err", "simulated vehicles"));
  const Scenario scenario = read_scenario(fleet_with("keys", "1.0"), with_links());
  const Fields reported = not_ready(scenario, std::make_shared<Domain>(with(fleet_keys())), 2.5);
  EXPECT_THAT(reported, testing::Contains("uav0: done, it was not ready in time"));
  EXPECT_THAT(reported, testing::Contains(HasSubstr("vehicle_odometry: no message of PX4 1.16")));
  vehicles->end(SIGINT);
  EXPECT_THAT(printed("vehicles.out"), HasSubstr("uav0: 0 set-points"));
  EXPECT_THAT(printed("vehicles.out"), HasSubstr(" 0 requests to arm"));
}

}  // namespace
}  // namespace sightline::dds
