/// Steps of the host's clock in flight: this program's CLOCK_REALTIME is shifted, as by an operator
/// or by NTP.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <optional>

#include "bridges/dds/links/px4_layout.hpp"
#include "sightline/base/now.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/child.hpp"

namespace {

std::atomic<std::int64_t> host_step{0};  // [ns]

}  // namespace

// Takes the place of the C library's in the whole program.
extern "C" int clock_gettime(clockid_t clock, timespec* t) noexcept {
  const auto failed = static_cast<int>(::syscall(SYS_clock_gettime, clock, t));
  const std::int64_t step = host_step.load(std::memory_order_relaxed);
  if (failed != 0 || clock != CLOCK_REALTIME || step == 0) return failed;
  constexpr std::int64_t second = 1'000'000'000;
  const std::int64_t stepped = t->tv_sec * second + t->tv_nsec + step;
  t->tv_sec = stepped / second, t->tv_nsec = stepped % second;
  return 0;
}

namespace sightline::dds {
namespace {

constexpr std::int64_t of_host_step = 1'500'000'000;  // more than COM_OF_LOSS_T

/// Sets the host's clock, and back at the end.
struct HostStep {
  explicit HostStep(std::int64_t by) { host_step = by; }
  ~HostStep() { host_step = 0; }
  HostStep(const HostStep&) = delete;
  HostStep& operator=(const HostStep&) = delete;
};

TEST(HostClock, AStepInFlightEndsNoOffboard) {
  for (const std::int64_t step : {-of_host_step, of_host_step}) {
    Rig rig(row_of({"1.14", "1.18"}, 3.0));
    std::optional<HostStep> stepped;
    std::int64_t seen = 0;
    const LoopOutcome outcome = rig.fly(0.5, [&] {
      const std::int64_t before = realtime_now() - monotonic_now();
      stepped.emplace(step);
      seen = realtime_now() - monotonic_now() - before;
    });
    EXPECT_NEAR(static_cast<double>(seen), static_cast<double>(step), 1e8);
    EXPECT_GE(outcome.updates + outcome.missed, 300) << fmt::format("{}", fmt::join(rig.reported, "\n"));
    EXPECT_THAT(rig.world->faults(), testing::IsEmpty()) << step;
    for (const std::size_t i : {0u, 1u}) {
      EXPECT_EQ(rig.counts_of(i).failsafe_after, 0.0) << i;
      EXPECT_FALSE(rig.vehicle(i).armed()) << i;
    }
    expect_well_treated(rig);
  }
}

// As PX4: a heartbeat is as old as its stamp, one of the future or without a stamp is of now.
TEST(HostClock, ASimulatedVehicleJudgesHeartbeatsByTheirStamps) {
  const Scenario scenario = row_of({"1.16"}, 1.0);
  const auto domain = std::make_shared<Domain>(fleet_of(scenario).network);
  const auto& link = std::get<Px4Link>(fleet_of(scenario).links[0].kind);
  Faults faults(1);
  Px4Vehicle vehicle(domain->participant(), link, {}, faults);
  const dds_entity_t other = domain->another_participant();
  const int release = px4_first + static_cast<int>(link.release);
  const Px4Layout of_status("VehicleStatus", release), of_mode("OffboardControlMode", release),
      of_request("VehicleCommand", release);
  const auto topic = [&](Px4Side side, std::string_view message) {
    return px4_topic(link.name_space, side, message, release);
  };
  std::atomic<int> nav{-1};
  std::atomic<bool> passes{false};
  RawReader status(other, of_status.descriptor(), topic(Px4Side::out, "VehicleStatus"), of_sensors,
                   of_status.size(), Writers::all,
                   [&, mode = of_status.place("nav_state"),
                    checks = of_status.place("pre_flight_checks_pass")](const void* m, const Arrival&) {
                     nav = read_at<std::uint8_t>(m, mode), passes = read_at<bool>(m, checks);
                   });
  RawWriter heartbeats({other}, of_mode.descriptor(), topic(Px4Side::in, "OffboardControlMode"), of_sensors),
      requests({other}, of_request.descriptor(), topic(Px4Side::in, "VehicleCommand"), of_ros_commands);
  ASSERT_TRUE(test::eventually([&] { return heartbeats.matched() > 0 && requests.matched() > 0; }));
  Px4Message offboard(of_request), heartbeat(of_mode);
  offboard.set("command", static_cast<std::uint32_t>(Px4Command::set_mode));
  offboard.set("param1", px4_custom_mode), offboard.set("param2", px4_mode_offboard);
  (void)requests.write(offboard.data());
  ASSERT_TRUE(test::eventually([&] { return nav == static_cast<int>(NavState::offboard); }));
  heartbeat.set("position", true);
  const auto passes_with = [&](const std::function<std::uint64_t()>& stamp, bool expected) {
    return test::eventually([&] {
      heartbeat.set("timestamp", stamp());
      (void)heartbeats.write(heartbeat.data());
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      vehicle.step(0);  // reports its status
      return passes == expected;
    });
  };
  const auto stamped = [](std::int64_t late) {
    return [late] { return static_cast<std::uint64_t>((realtime_now() - late) / 1000); };
  };
  EXPECT_TRUE(passes_with([] { return std::uint64_t{0}; }, true));
  EXPECT_TRUE(passes_with(stamped(of_host_step), false));
  EXPECT_TRUE(passes_with(stamped(0), true));
  EXPECT_TRUE(passes_with(stamped(of_host_step), false));
  EXPECT_TRUE(passes_with(stamped(-of_host_step), true));
  const HostStep back(-of_host_step);  // the vehicle's clock does not step with the host's
  EXPECT_TRUE(passes_with(stamped(0), false));
}

}  // namespace
}  // namespace sightline::dds
