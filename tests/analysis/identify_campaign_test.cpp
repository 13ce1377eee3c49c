// What an identification is worth: 20 s of excitation in noise, judged on other flights.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/support/campaign.hpp"
#include "tests/support/identified.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using test::alone;
using test::identified;
using test::judged_on;
using test::number;
using test::uav;
using test::usual_noise;

struct Judged {
  double r2 = 1.0, position = 0.0;  // least and most
  void add(const PredictionError& e) {
    r2 = std::min(r2, e.r2);
    position = std::max(position, e.position);
  }
};

TEST(IdentifyCampaign, TwentySecondsPredictATaskAndBangBangOfTheVehicleThatTheyAreOf) {
  const int seeds = whole_campaign() ? 10 : 2;
  for (const char* const preset : {"x500", "crazyflie"}) {
    const Scenario quiet = test::vehicle(preset, "");
    std::vector<FlownMotion> tasks, hostile;
    for (const char* const robot : {"uav0", "uav1"})
      tasks.push_back(test::task_flight(preset, robot, whole_campaign() ? 60.0 : 20.0));
    hostile.push_back(fly_excitation(
        quiet, uav(quiet),
        {.kind = ExcitationKind::bang_bang, .seconds = whole_campaign() ? 120.0 : 30.0, .seed = 100}));
    for (const ExcitationKind kind : {ExcitationKind::steps, ExcitationKind::chirp}) {
      Judged task, bang_bang, lumped;
      for (int seed = 1; seed <= seeds; ++seed) {
        const Identification found =
            identified(test::vehicle(preset), {.kind = kind, .seed = static_cast<std::uint64_t>(seed)});
        EXPECT_TRUE(found.best.structure.coriolis && found.best.structure.lags) << preset << " " << seed;
        for (const FlownMotion& flight : tasks) {
          const PredictionError e = judged_on(flight, found.best);
          task.add(e);
          if (found.lumped) lumped.add(judged_on(flight, *found.lumped));
        }
        bang_bang.add(judged_on(hostile.front(), found.best));
      }
      std::printf(
          "%-9s %-5s %2d seeds: task R^2 >= %.4f, position <= %4.1f mm; lumped delay R^2 >= %.4f, <= %4.1f "
          "mm; "
          "bang-bang R^2 >= %.4f, <= %4.1f mm\n",
          preset, excitation_names[static_cast<std::size_t>(kind)].data(), seeds, task.r2,
          1e3 * task.position, lumped.r2, 1e3 * lumped.position, bang_bang.r2, 1e3 * bang_bang.position);
      EXPECT_GE(task.r2, 0.99) << preset;
      EXPECT_LE(task.position, 0.020) << preset;
      EXPECT_GE(bang_bang.r2, 0.93) << preset;
    }
  }
}

TEST(IdentifyCampaign, TheIntervalsHoldTheTruthOfDrawnVehicles) {
  const int vehicles = whole_campaign() ? 20 : 5;
  Random random(7);
  int held = 0, all = 0;
  for (int k = 0; k < vehicles; ++k) {
    LaggingHoverMultirotor truth;
    truth.b_z = uniform(random, 0.7, 1.5), truth.b_psi = uniform(random, 1.0, 2.2);
    truth.a_f = uniform(random, -0.7, -0.2), truth.b_f = uniform(random, 1.2, 2.5);
    truth.a_s = uniform(random, -0.7, -0.2), truth.b_s = uniform(random, 1.2, 2.5);
    truth.tau = uniform(random, 0.06, 0.2), truth.tau_z = uniform(random, 0.15, 0.4);
    truth.tau_psi = uniform(random, 0.1, 0.3);
    const double delay = uniform(random, 0.02, 0.12);
    const Scenario scenario = alone(
        fmt::format(
            "robot = \"hover_multirotor\"\nparameters = {{ b_z = {}, b_psi = {}, a_f = {}, b_f = {}, a_s "
            "= {}, b_s = {}, tau = {}, tau_z = {}, tau_psi = {} }}",
            truth.b_z, truth.b_psi, truth.a_f, truth.b_f, truth.a_s, truth.b_s, truth.tau, truth.tau_z,
            truth.tau_psi),
        11, fmt::format("input_delay = {}\n{}", delay, usual_noise));
    const Identification found = identified(scenario, {.seed = static_cast<std::uint64_t>(k + 1)});
    EXPECT_EQ(found.best.structure.name(), "(24) + delay + Coriolis + lags") << k;
    const std::array<std::pair<const char*, double>, 10> truths = {{{"b_z", truth.b_z},
                                                                    {"b_psi", truth.b_psi},
                                                                    {"a_f", truth.a_f},
                                                                    {"b_f", truth.b_f},
                                                                    {"a_s", truth.a_s},
                                                                    {"b_s", truth.b_s},
                                                                    {"tau", truth.tau},
                                                                    {"tau_z", truth.tau_z},
                                                                    {"tau_psi", truth.tau_psi},
                                                                    {"delay", delay}}};
    for (const auto& [key, value] : truths) {
      for (const FoundNumber& one : found.best.found) {
        if (one.number.key != key) continue;
        ++all;
        held += value >= one.low() && value <= one.high() ? 1 : 0;
        EXPECT_NEAR(one.value, value, 4 * one.interval) << key << " of " << k;
      }
    }
  }
  std::printf("%d drawn vehicles: %d of %d intervals hold the truth, %.1f %%\n", vehicles, held, all,
              100.0 * held / all);
  EXPECT_GE(held, 0.9 * all);
}

TEST(IdentifyCampaign, TheArDroneIsThatOfEquation16) {
  const Multirotor paper;
  const int seeds = whole_campaign() ? 5 : 2;
  double worst = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Identification found =
        identified(test::vehicle("ar_drone"), {.seed = static_cast<std::uint64_t>(seed)});
    for (const auto& [key, value] :
         {std::pair{"b_z", paper.b_z}, std::pair{"b_psi", paper.b_psi}, std::pair{"a_f", paper.a_f},
          std::pair{"b_f", paper.b_f}, std::pair{"a_s", paper.a_s}, std::pair{"b_s", paper.b_s}}) {
      const double off = std::abs(number(found.best, key) / value - 1);
      worst = std::max(worst, off);
      EXPECT_LE(off, 0.1) << key << ", seed " << seed;
    }
  }
  std::printf("ar_drone, %d seeds: numbers within %.1f %% of (16)\n", seeds, 100 * worst);
}

TEST(IdentifyCampaign, ThePresetsAreWhatIsFound) {
  for (const auto& preset : LaggingHoverMultirotor::presets()) {
    const Identification found =
        identified(test::vehicle(preset.name), {.seconds = 60.0, .seed = whole_campaign() ? 11U : 12U});
    const LaggingHoverMultirotor& m = preset.part;
    for (const auto& [key, value] :
         {std::pair{"b_z", m.b_z}, std::pair{"b_psi", m.b_psi}, std::pair{"a_f", m.a_f},
          std::pair{"b_f", m.b_f}, std::pair{"a_s", m.a_s}, std::pair{"b_s", m.b_s}, std::pair{"tau", m.tau},
          std::pair{"tau_z", m.tau_z}, std::pair{"tau_psi", m.tau_psi}})
      EXPECT_NEAR(number(found.best, key) / value, 1.0, 0.15) << preset.name << " " << key;
    ASSERT_TRUE(found.lumped);
    std::printf("%-9s delay %.3f s, lumped %.3f s\n", preset.name.data(), number(found.best, "delay"),
                number(*found.lumped, "delay"));
  }
}

}  // namespace
}  // namespace sightline
