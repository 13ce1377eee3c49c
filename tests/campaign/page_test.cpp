#include "sightline/campaign/page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "sightline/campaign/table.hpp"
#include "sightline/report/page.hpp"
#include "tests/support/command.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

CampaignPlan shown_plan() {
  CampaignPlan some{.duration = 1.0, .view_within = 0.8, .d_hard = 0.5};
  some.starts = {{.agent = "uav0",
                  .around = "uav1",
                  .range = {.values = {0.3, 6.0}},
                  .bearing = {.values = {-3.0, 3.0}},
                  .height = {.values = {-1.0, 2.0}}}};
  some.draws = {{"simulation.disturbance.yaw_lag",
                 {.kind = Distribution::Kind::choice, .values = {0.0, 0.5}, .fractions = {0.5, 0.5}}}};
  return some;
}

/// A table of 40 runs, one in four of them bad.
CampaignTable some_table(const std::filesystem::path& folder, const std::string& name,
                         bool all_good = false) {
  Scenario scenario;
  scenario.name = name;
  CampaignTable table{name, folder / (name + ".sqlite")};
  RunTable runs(table.file, scenario, shown_plan(), 1);
  for (int i = 0; i < 40; ++i) {
    RunResult result{.outcome = Outcome::recovered,
                     .min_distance = 1.0 + 0.01 * i,
                     .time_to_first_view = 0.1 + 0.01 * i,
                     .fraction_in_view = 0.5,
                     .energy = 0.2};
    if (!all_good && i % 4 == 3) {
      result.outcome = i == 3 ? Outcome::failed : i == 7 ? Outcome::too_close : Outcome::lost;
      result.time_to_first_view = std::numeric_limits<double>::quiet_NaN();
    }
    if (result.outcome == Outcome::failed) {
      result.reason = "uav0 touched uav1 at 1.2 s with 0.7 m/s";
      result.barrier_conflict = 0.125;
    }
    runs.add(draw_run(shown_plan(), 1, i), result);
  }
  runs.finish();
  return table;
}

std::string value(const std::vector<CampaignLine>& lines, const std::string& what) {
  for (const CampaignLine& line : lines) {
    if (line.what == what) return line.value;
  }
  return "";
}

/// The first tag that closes what is not open, or is never closed; empty if there is none.
std::string unbalanced(const std::string& page) {
  static const std::regex tag("<(/?)([a-zA-Z][a-zA-Z0-9]*)[^>]*?(/?)>");
  std::vector<std::string> open;
  for (std::sregex_iterator i(page.begin(), page.end(), tag), end; i != end; ++i) {
    const std::string name = (*i)[2];
    if ((*i)[3].length() > 0 || name == "meta") continue;
    if ((*i)[1].length() == 0) {
      open.push_back(name);
    } else if (open.empty() || open.back() != name) {
      return i->str();
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : open.back();
}

TEST(CampaignPage, LinesCountOutcomesWithTheirBounds) {
  const auto lines = campaign_lines(some_table(test::fresh_folder(), "some"));
  EXPECT_EQ(value(lines, "recovered"), "30 of 40, 75.00 % (95 %: 59.81 % to 85.81 %)");
  EXPECT_THAT(value(lines, "failed"), testing::StartsWith("1 of 40, 2.50 %"));
  EXPECT_EQ(value(lines, "run 3 failed"), "uav0 touched uav1 at 1.2 s with 0.7 m/s");
  EXPECT_EQ(value(lines, "barrier_conflict"),
            "in 1 of 40 runs no command keeps all that the barrier is to keep, at most 0.125 of the time");
  EXPECT_THAT(value(lines, "too_close"), testing::StartsWith("1 of 40"));
  EXPECT_THAT(value(lines, "lost"), testing::StartsWith("8 of 40"));
  EXPECT_THAT(value(lines, "time to first view"), HasSubstr("last 0.48 s; never in 10 runs"));
  EXPECT_THAT(value(lines, "least distance"), HasSubstr("of all 1 m"));
  const auto good = campaign_lines(some_table(test::fresh_folder(), "good", true));
  EXPECT_EQ(value(good, "recovered"), "40 of 40, 100.00 % (95 %: 91.24 % to 100.00 %)");
  EXPECT_EQ(value(good, "lost"), "") << "what did not come is not listed";
}

TEST(CampaignPage, ErrorsOfPositionAndHeadingStandBesideEachOtherWhereThereIsAReference) {
  Scenario scenario;
  for (const char* name : {"uav0", "uav1", "uav2"}) scenario.team.add(Multirotor{}, {.name = name});
  const CampaignTable table{"some", test::fresh_folder() / "some.sqlite"};
  {
    RunTable runs(table.file, scenario, shown_plan(), 1);
    for (int i = 0; i < 9; ++i) {
      const RobotResult both{.energy = 1.0, .rms_position_error = 0.1 + 0.01 * i, .rms_heading_error = 0.25},
          heading{.energy = 1.0, .rms_heading_error = 0.5};
      runs.add(draw_run(shown_plan(), 1, i), {.robots = {both, heading, {}}});
    }
    runs.finish();
  }
  const auto lines = campaign_lines(table);
  EXPECT_THAT(value(lines, "uav0 tracks its reference"),
              testing::AllOf(testing::StartsWith("position error (RMS) median 0.14 m (95 %"),
                             HasSubstr("; heading error (RMS) median 0.25 rad (95 %")));
  EXPECT_THAT(value(lines, "uav1 tracks its reference"),
              testing::StartsWith("heading error (RMS) median 0.5 rad"));
  EXPECT_EQ(value(lines, "uav2 tracks its reference"), "");
}

TEST(CampaignPage, ItIsWellFormedAndHasItsFigures) {
  const auto folder = test::fresh_folder();
  const std::string page = campaign_html({some_table(folder, "a"), some_table(folder, "b & c")}, shown_plan(),
                                         "sightline campaign x", "out");
  const std::string text = page.substr(0, page.size() - page_end().size());
  EXPECT_EQ(unbalanced(text + "</body></html>"), "");
  for (const char* part : {"Time to first view", "Least distance", "Fraction of the time in view",
                           "Recovered, by where uav0 starts", "Recovered, by what was chosen", "b &amp; c",
                           "simulation.disturbance.yaw_lag = 0.5"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(text, testing::Not(HasSubstr("nan")));
}

TEST(CampaignPage, TheWorstRunsComeFirstEachWithWhatFliesItAgain) {
  const auto folder = test::fresh_folder();
  const std::string page =
      campaign_html({some_table(folder, "a")}, shown_plan(), "sightline campaign x.toml --seed 5", "out/a");
  const auto at = [&](int run) {
    const std::string line = "sightline campaign x.toml --seed 5 --only " + std::to_string(run) +
                             " -o out/a/run_" + std::to_string(run);
    return page.find(line + "\n");
  };
  EXPECT_THAT(page, HasSubstr("<td>12.5 %</td><td>uav0 touched uav1 at 1.2 s with 0.7 m/s</td>"));
  EXPECT_LT(at(3), at(7)) << "failed before too close";
  EXPECT_LT(at(7), at(11)) << "too close before lost";
  EXPECT_LT(at(39), at(38)) << "lost before recovered";
  EXPECT_NE(at(38), std::string::npos) << "of those recovered the slowest";
  EXPECT_EQ(at(0), std::string::npos);
}

TEST(CampaignPage, AWordOfTheShellIsReadAsItWasMeant) {
  EXPECT_EQ(shell_word("out/run_17"), "out/run_17");
  for (const std::string text :
       {"a b", "it's", "$(touch x)", "`id`;&|", "*", "", "\"\\\n\t", "~", "#x", "ä"}) {
    const auto folder = test::fresh_folder();
    EXPECT_EQ(test::shell("printf %s " + shell_word(text), folder).out, text);
  }
}

}  // namespace
}  // namespace sightline
