// The simulated PX4 vehicle beside recordings of PX4's firmware: same requests and heartbeats at
// the same times. States, acknowledgements and heights are compared. Set-points lead to the
// recorded heights, as the flyer's did.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

#include "bridges/dds/links/px4_layout.hpp"
#include "sightline/base/now.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/child.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

constexpr int release = 16;

struct Row {
  double t;  // [s]
  std::string name, value;
};

std::vector<Row> recorded(const std::string& file) {
  std::vector<Row> rows;
  std::ifstream in(std::string(SIGHTLINE_SOURCE_DIR) + "/tests/dds/traces/" + file);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream fields(line);
    std::string t, name, value;
    std::getline(fields, t, ','), std::getline(fields, name, ','), std::getline(fields, value);
    rows.push_back({std::stod(t), name, value});
  }
  return rows;
}

struct Change {
  double t;
  int value;
};
using Changes = std::vector<Change>;

/// Without the values that lasted less than 0.1 s: the two sides sample states at different times.
Changes lasting(const Changes& all) {
  Changes changes;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool lasts = i + 1 == all.size() || all[i + 1].t - all[i].t > 0.1;
    if (lasts && (changes.empty() || changes.back().value != all[i].value)) changes.push_back(all[i]);
  }
  return changes;
}

std::vector<int> values(const Changes& changes) {
  std::vector<int> values;
  for (const Change& change : changes) values.push_back(change.value);
  return values;
}

std::string written(const Changes& changes) {
  std::string text;
  for (const Change& change : changes) text += fmt::format("{} at {:.1f} s ", change.value, change.t);
  return text;
}

Scenario vehicle_at(double height) {
  return test::scenario_of(
      fmt::format("[fleet]\ndomain = {}\n[agent.uav0]\nrobot = \"multirotor\"\nstart = {{ p = [0, 0, {}], "
                  "heading = 0.0 }}\n[agent.uav0.link]\nkind = \"px4\"\nrelease = \"1.16\"\nnamespace = "
                  "\"/px4_0\"\norigin = {{ p = [0, 0, 0], heading = 0.0 }}\n",
                  test::own_domain(), height));
}

/// Sends what a recording sent, and records what the simulated vehicle does.
class Playback {
 public:
  explicit Playback(double altitude)
      : scenario_(vehicle_at(altitude)),
        domain_(std::make_shared<Domain>(fleet_of(scenario_).network)),
        vehicles_(scenario_, domain_),
        other_(domain_->another_participant()),
        heartbeats_({other_}, mode_.descriptor(), topic("OffboardControlMode"), of_sensors),
        setpoints_({other_}, setpoint_.descriptor(), topic("TrajectorySetpoint"), of_sensors),
        requests_({other_}, request_.descriptor(), topic("VehicleCommand"), of_ros_commands),
        stepping_([this] { vehicles_.run(1e9, stepped_, {}); }) {
    const Px4Layout status("VehicleStatus", release), ack("VehicleCommandAck", release);
    for (const auto& [name, field] : {std::pair{"arming_state", "arming_state"},
                                      {"nav_state", "nav_state"},
                                      {"failsafe", "failsafe"},
                                      {"preflight", "pre_flight_checks_pass"}})
      read("VehicleStatus", status, name, status.place(field));
    const Px4Layout landed("VehicleLandDetected", release);
    read("VehicleLandDetected", landed, "landed", landed.place("landed"));
    acks_ = std::make_unique<RawReader>(other_, ack.descriptor(), out("VehicleCommandAck"),
                                        Quality{.depth = 8}, ack.size(), Writers::all,
                                        [this, at = ack.place("result")](const void* m, const Arrival&) {
                                          const std::scoped_lock lock(lock_);
                                          results_.push_back(read_at<std::uint8_t>(m, at));
                                        });
  }
  ~Playback() {
    stepped_ = 1;
    stepping_.join();
  }

  /// Plays it, then waits `more` seconds, in which the vehicle may still do what the recorded one
  /// did.
  void play(const std::vector<Row>& rows, double more) {
    ASSERT_TRUE(test::eventually([&] {
      return requests_.matched() > 0 && heartbeats_.matched() > 0 && setpoints_.matched() > 0 &&
             changes().at("preflight").back().value == 1;
    }));
    begin_ = monotonic_now();
    for (const Row& row : rows) {
      wait_until(row.t);
      if (row.name == "heartbeats") beats_ = row.value == "1";
      if (row.name == "request") request(row.value);
      if (row.name == "height") {
        led_to_ = std::stod(row.value);
        height_error_ = std::max(height_error_, std::abs(height() - led_to_));
      }
    }
    wait_until(rows.back().t + more);
  }

  std::map<std::string, Changes> changes() const {
    const std::scoped_lock lock(lock_);
    return changes_;
  }
  std::vector<int> results() const {
    const std::scoped_lock lock(lock_);
    return results_;
  }
  double height_error() const { return height_error_; }  ///< greatest [m]

 private:
  static std::string topic(std::string_view message) {
    return px4_topic("/px4_0", Px4Side::in, message, release);
  }
  static std::string out(std::string_view message) {
    return px4_topic("/px4_0", Px4Side::out, message, release);
  }

  void read(std::string_view message, const Px4Layout& layout, const char* name, std::size_t place) {
    changes_[name] = {{0.0, -1}};
    readers_.push_back(std::make_unique<RawReader>(
        other_, layout.descriptor(), out(message), Quality{.depth = 8}, layout.size(), Writers::all,
        [this, name, place](const void* m, const Arrival& arrival) {
          const std::scoped_lock lock(lock_);
          Changes& all = changes_[name];
          const int value = read_at<std::uint8_t>(m, place);
          const Change change = {begin_ == 0 ? 0.0 : 1e-9 * static_cast<double>(arrival.monotonic - begin_),
                                 value};
          if (begin_ == 0) all.clear();
          if (all.empty() || all.back().value != value) all.push_back(change);
        }));
  }

  void wait_until(double t) {
    const Nanoseconds until = begin_ + std::llround(1e9 * t);
    do {
      if (beats_) beat();
      const auto left = std::chrono::nanoseconds(std::max<Nanoseconds>(until - monotonic_now(), 0));
      std::this_thread::sleep_for(std::min<std::chrono::nanoseconds>(left, std::chrono::milliseconds(20)));
    } while (monotonic_now() < until);
  }

  void beat() {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    Px4Message mode(mode_);
    mode.set("position", true), mode.set("velocity", true);
    heartbeats_.write(mode.data());
    px4_msgs_msg_dds__TrajectorySetpoint_ setpoint{};
    for (float& p : setpoint.position) p = nan;
    setpoint.velocity[2] = static_cast<float>(std::clamp(height() - led_to_, -1.0, 1.0));
    setpoints_.write(&setpoint);
  }

  void request(const std::string& what) {
    Px4Message message(request_);
    const auto send = [&](Px4Command command, float param1, float param2 = 0.0F, float param3 = 0.0F) {
      message.set("command", static_cast<std::uint32_t>(command));
      message.set("param1", param1), message.set("param2", param2), message.set("param3", param3);
      message.set("target_system", std::uint8_t{1});
      requests_.write(message.data());
    };
    if (what == "arm") return send(Px4Command::arm_disarm, 1.0F);
    if (what == "disarm") return send(Px4Command::arm_disarm, 0.0F);
    if (what == "takeoff") return send(Px4Command::takeoff, 0.0F);
    if (what == "land") return send(Px4Command::land, 0.0F);
    if (what == "offboard") return send(Px4Command::set_mode, px4_custom_mode, px4_mode_offboard);
    ASSERT_EQ(what, "hold");
    send(Px4Command::set_mode, px4_custom_mode, px4_mode_auto, px4_auto_loiter);
  }

  double height() { return vehicles_.of(0).motion().p.z; }

  Px4Layout mode_{"OffboardControlMode", release}, setpoint_{"TrajectorySetpoint", release},
      request_{"VehicleCommand", release};
  Scenario scenario_;
  std::shared_ptr<Domain> domain_;
  DdsVehicleSimulators vehicles_;
  dds_entity_t other_;
  RawWriter heartbeats_, setpoints_, requests_;
  mutable std::mutex lock_;  // guards the two below
  std::map<std::string, Changes> changes_;
  std::vector<int> results_;
  std::atomic<Nanoseconds> begin_{0};
  bool beats_ = false;
  double led_to_ = 0.0, height_error_ = 0.0;  // [m]
  Interrupts stepped_{0};
  std::vector<std::unique_ptr<RawReader>> readers_;
  std::unique_ptr<RawReader> acks_;
  std::thread stepping_;
};

struct Compared {
  const char* file;
  double altitude;      // MIS_TAKEOFF_ALT [m]
  double height_error;  // [m]
  double late;          // of the landing: noise delays the firmware's land detector [s]
};

void PrintTo(const Compared& of, std::ostream* to) { *to << of.file; }

class Px4Trace : public testing::TestWithParam<Compared> {};

TEST_P(Px4Trace, TheSimulatedVehicleDoesWhatTheFirmwareDid) {
  const std::vector<Row> rows = recorded(std::string(GetParam().file) + ".csv");
  ASSERT_GT(rows.size(), 40u);
  std::map<std::string, Changes> firmware;
  std::vector<int> results;
  for (const Row& row : rows) {
    if (row.name == "ack") results.push_back(std::stoi(row.value));
    const bool drives = row.name == "heartbeats" || row.name == "request";
    if (!drives && row.name != "ack" && row.name != "height")
      firmware[row.name].push_back({row.t, std::stoi(row.value)});
  }
  Playback simulated(GetParam().altitude);
  simulated.play(rows, 1.5);
  EXPECT_EQ(simulated.results(), results);
  EXPECT_LT(simulated.height_error(), GetParam().height_error);
  ASSERT_EQ(firmware.size(), 5u);
  for (const auto& [name, changes] : firmware) {
    const Changes one = lasting(changes), two = lasting(simulated.changes().at(name));
    EXPECT_EQ(values(two), values(one)) << name;
    RecordProperty(name, fmt::format("recorded {}; simulated {}", written(one), written(two)));

    for (std::size_t i = 0; i < std::min(one.size(), two.size()); ++i)
      EXPECT_NEAR(two[i].t, one[i].t, one[i].t < rows.back().t - 4.0 ? 0.7 : GetParam().late)
          << name << " = " << one[i].value;
  }
}

INSTANTIATE_TEST_SUITE_P(Recordings, Px4Trace,
                         testing::Values(Compared{"px4_flight", 1.0, 0.35, 1.5},
                                         Compared{"px4_lost", 1.0, 0.35, 1.5},
                                         Compared{"px4_high", 2.5, 0.6, 4.0},
                                         Compared{"px4_requests", 1.0, 0.5, 0.7},
                                         Compared{"px4_idle", 1.0, 0.1, 0.7}));

}  // namespace
}  // namespace sightline::dds
