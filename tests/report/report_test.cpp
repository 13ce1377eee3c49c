#include "sightline/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sightline/judge/summary.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double two_pi = 2 * std::numbers::pi;

// The paper's two robots, flown for some periods by CMSCGMRES.
Recording flown(int periods) {
  const Team team = paper::team(paper::Variant::masked);
  Cmscgmres solver(team, Horizon{});
  Recording r;
  r.name = "two";
  r.scenario = "# robots & targets\nname = \"<two>\"\n";
  r.version = "0.1.0";
  r.compiler = "GCC";
  r.solver = "cmscgmres";
  r.period = 0.01;
  r.pairs = {{.observer = 0, .target = 1, .mount = {}, .alpha = 0.5, .d_min = 1.0, .d_max = 2.0}};
  r.controllers.resize(1);
  for (int i = 0; i < team.bodies(); ++i) {
    const Agent& agent = team.agent(BodyId{i});
    Recording::Body body;
    body.name = agent.name;
    body.robot = "multirotor";
    body.is_agent = true;
    for (const auto input : agent.model.inputs()) body.inputs.emplace_back(input);
    body.u_min = agent.limits.u_min().front();
    body.u_max = agent.limits.u_max().front();
    body.u.resize(body.inputs.size());
    r.bodies.push_back(std::move(body));
  }
  fly(solver, paper::start(), periods, [&](double t, const std::vector<double>& x, const Solution& solution) {
    r.time.push_back(t);
    r.cost.push_back(stage_cost(team, t, x, solution.u));
    r.solve_us.push_back(50.0 + static_cast<double>(r.time.size() % 7));
    r.controllers[0].residual.push_back(solution.residual);
    r.controllers[0].iterations.push_back(solution.iterations);
    for (int i = 0; i < team.bodies(); ++i) {
      auto& body = r.bodies[static_cast<std::size_t>(i)];
      const double* const state = x.data() + team.state_offset(BodyId{i});
      const double* const input = solution.u.data() + team.input_offset(BodyId{i});
      const Sight<double> sight = team.model(BodyId{i}).sight(state, input);
      body.p.push_back(sight.p);
      body.heading.push_back(std::atan2(sight.d.y, sight.d.x));
      for (std::size_t j = 0; j < body.u.size(); ++j) body.u[j].push_back(input[j]);
    }
    const Pose<double> reference = paper::target_path()(t);
    r.bodies[1].reference_time.push_back(t);
    r.bodies[1].reference_p.push_back(reference.p);
  });
  return r;
}

// A team of any size that walks at random, each robot with a target.
Recording walked(Random& random, std::size_t bodies, std::size_t periods) {
  Recording r;
  r.name = "walk";
  r.solver = "newton_riccati";
  r.period = 0.02;
  for (std::size_t k = 0; k < periods; ++k) {
    r.time.push_back(0.02 * static_cast<double>(k));
    r.solve_us.push_back(uniform(random, 10, 1000));
  }
  for (std::size_t i = 0; i < bodies; ++i) {
    Recording::Body body;
    body.name = "robot" + std::to_string(i);
    body.is_agent = true;
    body.inputs = {"a"};
    body.u.resize(1);
    for (std::size_t k = 0; k < periods; ++k) {
      body.p.push_back(random_point(random, 3.0));
      body.heading.push_back(uniform(random, -9, 9));
      body.u[0].push_back(uniform(random, -1, 1));
    }
    body.reference_time = {0.0, 0.1};
    body.reference_p = {body.p[0], body.p[0]};
    body.reference_heading = {uniform(random, -20, 20), 0.0};
    r.bodies.push_back(std::move(body));
    if (i > 0)
      r.pairs.push_back(
          {.observer = i, .target = i - 1, .mount = {}, .alpha = 0.5, .d_min = nan, .d_max = nan});
  }
  return r;
}

const Drawing& drawing_of(const std::vector<Drawing>& drawings, std::string_view title) {
  for (const Drawing& drawing : drawings) {
    if (drawing.title.find(title) != std::string::npos) return drawing;
  }
  throw std::runtime_error("no such drawing: " + std::string(title));
}

TEST(DrawingsOf, HaveCurvesOfAtMost2000PointsAndATitleAndUnitsOnEveryAxis) {
  Random random(1);
  std::vector<Recording> runs = {flown(300), walked(random, 1, 5000), walked(random, 9, 3000)};
  for (const Recording& run : runs) {
    for (const Drawing& drawing : drawings_of(run)) {
      EXPECT_FALSE(drawing.title.empty());
      EXPECT_FALSE(drawing.panels.back().x_label.empty());
      for (const auto& panel : drawing.panels) {
        EXPECT_FALSE(panel.y_label.empty());
        for (const auto& curve : panel.curves) {
          EXPECT_EQ(curve.x.size(), curve.y.size());
          EXPECT_LE(curve.x.size(), 2000u) << drawing.title;
          EXPECT_LT(curve.colour, Drawing::colours + 2);
        }
      }
    }
  }
}

TEST(DrawingsOf, TellDistanceAndViewAngleOfEachPairAsTheSightsGiveThem) {
  const Recording run = flown(200);
  const auto drawings = drawings_of(run);
  const Drawing& pair = drawing_of(drawings, "uav0 sees uav1");
  ASSERT_EQ(pair.panels.size(), 2u);
  const auto &distance = pair.panels[0].curves[0].y, &angle = pair.panels[1].curves[0].y;
  ASSERT_EQ(distance.size(), run.time.size());
  for (std::size_t k = 0; k < run.time.size(); ++k) {
    const double psi = run.bodies[0].heading[k];
    const Pose<double> observer{run.bodies[0].p[k], {std::cos(psi), std::sin(psi)}};
    EXPECT_EQ(distance[k], norm(run.bodies[0].p[k] - run.bodies[1].p[k]));
    EXPECT_EQ(angle[k], view_angle({}, observer, run.bodies[1].p[k]));
  }
}

TEST(DrawingsOf, ShowEveryRobotAndEveryPairOnceHoweverManyThereAre) {
  Random random(2);
  for (const std::size_t bodies : {1u, 2u, 7u, 13u}) {
    const Recording run = walked(random, bodies, 50);
    std::size_t headings = 0, inputs = 0, pairs = 0, paths = 0;
    for (const Drawing& drawing : drawings_of(run)) {
      pairs += drawing.title.find(" sees ") != std::string::npos;
      for (const auto& panel : drawing.panels) {
        inputs += panel.y_label.ends_with("u [-]");
        for (const auto& curve : panel.curves) {
          const bool dashed = curve.mark == Drawing::Mark::dashed;
          headings += panel.y_label == "ψ [rad]" && !dashed;
          paths += panel.equal_scales && curve.mark == Drawing::Mark::line;
        }
      }
    }
    EXPECT_EQ(headings, bodies);
    EXPECT_EQ(inputs, bodies);
    EXPECT_EQ(paths, bodies);
    EXPECT_EQ(pairs, bodies - 1);
  }
}

TEST(DrawingsOf, StartTheHeadingsReferenceWithinHalfATurnOfTheHeading) {
  Random random(3);
  for (int n = 0; n < 50; ++n) {
    const Recording run = walked(random, 2, 20);
    const auto drawings = drawings_of(run);
    const auto& curves = drawing_of(drawings, "Headings").panels[0].curves;
    ASSERT_EQ(curves.size(), 4u);
    for (std::size_t i = 0; i < 4; i += 2) {
      const double apart = curves[i + 1].y.front() - curves[i].y.front();
      EXPECT_LE(std::abs(apart), two_pi / 2 + 1e-9);
      const double turns = (curves[i + 1].y.front() - run.bodies[i / 2].reference_heading.front()) / two_pi;
      EXPECT_NEAR(turns, std::round(turns), 1e-9);
    }
  }
}

TEST(DrawingsOf, CountEveryUpdateInTheHistogram) {
  Random random(4);
  const Recording run = walked(random, 1, 777);
  const auto drawings = drawings_of(run);
  double counted = 0.0;
  for (const double count : drawing_of(drawings, "Computation time").panels.back().curves[0].y)
    counted += count;
  EXPECT_EQ(counted, 777.0);
}

TEST(DrawingsOf, NameThePapersTimeBesideTheMeanOfItsSolverAlone) {
  Recording run = flown(50);
  const auto mean_of = [](const std::vector<Drawing>& drawings) {
    std::string titles;
    for (const auto& curve : drawing_of(drawings, "Computation time").panels[0].curves) titles += curve.title;
    return titles;
  };
  EXPECT_THAT(mean_of(drawings_of(run)),
              AllOf(HasSubstr("mean 0.05"), HasSubstr("the paper reports 2.5 ms")));
  run.solver = "newton_riccati";
  EXPECT_THAT(mean_of(drawings_of(run)), AllOf(HasSubstr("mean 0.05"), Not(HasSubstr("paper"))));
}

TEST(DrawingsOf, ShareTheirTimeAxisAndMarkEachEventByItsNumber) {
  Recording run = flown(300);
  run.bodies[0].barrier.assign(300, 0.0);
  run.bodies[0].barrier[100] = 1.0;
  run.events = {
      {0.1, "solver_status", 0, 1.0}, {0.5, "hold", 0, 0.0}, {0.51, "hold", 0, 1.0}, {2.0, "valid", 0, 0.0}};
  int panels = 0;
  for (const Drawing& drawing : drawings_of(run)) {
    for (const auto& panel : drawing.panels) {
      if ((panel.x_label.empty() ? drawing.panels.back() : panel).x_label != "t [s]") continue;
      ++panels;
      ASSERT_TRUE(panel.x_range) << drawing.title;
      EXPECT_EQ((*panel.x_range)[0], 0.0);
      EXPECT_NEAR((*panel.x_range)[1], 3.0, 1e-9);
      ASSERT_EQ(panel.moments.size(), 2U);
      EXPECT_EQ(panel.moments[0].x, 0.5);
      EXPECT_EQ(panel.moments[0].text, &panel == &drawing.panels.front() ? "1…" : "") << drawing.title;
      EXPECT_EQ(panel.moments[1].x, 2.0);
    }
  }
  EXPECT_GT(panels, 8);
  EXPECT_THAT(report_html(run, ""),
              AllOf(HasSubstr("<th scope=\"row\">3: 2.00 s</th>"), HasSubstr("Dotted vertical lines")));
  run.events.clear();
  EXPECT_THAT(report_html(run, ""), Not(HasSubstr("Dotted")));
}

TEST(DrawingsOf, CaptionsSpeakOfWhatIsThereAlone) {
  Recording run = flown(20);
  EXPECT_THAT(drawing_of(drawings_of(run), "Positions").caption, HasSubstr("dashed"));
  EXPECT_THAT(drawing_of(drawings_of(run), "Headings").caption, Not(HasSubstr("dashed")));
  for (auto& body : run.bodies) body.reference_time.clear(), body.reference_p.clear();
  EXPECT_THAT(drawing_of(drawings_of(run), "Positions").caption, Not(HasSubstr("dashed")));
}

TEST(DrawingsOf, HeightsHaveTheFloorAndTheCeilingWhereSomebodyIsNear) {
  Recording run = flown(20);
  const auto levels = [&] {
    const auto drawings = drawings_of(run);
    const auto& curves = drawing_of(drawings, "Positions").panels[2].curves;
    return std::count_if(curves.begin(), curves.end(),
                         [](const auto& curve) { return curve.colour == Drawing::limit_colour; });
  };
  EXPECT_EQ(levels(), 0);
  run.floor = 0.3, run.ceiling = 10.0;
  EXPECT_EQ(levels(), 1);
  run.ceiling = 0.7;
  EXPECT_EQ(levels(), 2);
}

TEST(DrawingsOf, OfManyRobotsThoseThatCameNearestHaveCurvesOfTheirOwn) {
  Random random(5);
  Recording run = walked(random, 100, 40);
  run.bodies[77].p[20] = run.bodies[33].p[20];
  const auto drawings = drawings_of(run);
  std::size_t inputs = 0, pairs = 0;
  std::string names;
  for (const Drawing& drawing : drawings) {
    pairs += drawing.title.find(" sees ") != std::string::npos;
    if (drawing.title.starts_with("Positions")) names += drawing.title;
    for (const auto& panel : drawing.panels) inputs += panel.y_label.ends_with("u [-]");
  }
  EXPECT_EQ(inputs, 12U);
  EXPECT_EQ(pairs, 12U);
  EXPECT_THAT(names, AllOf(HasSubstr("robot33"), HasSubstr("robot77")));
  EXPECT_THAT(report_html(run, ""), HasSubstr("Of the 100 robots"));
}

TEST(ReportHtml, HasTheTeamInPartsWhereTheFileIsOfThisRun) {
  Scenario scenario;
  scenario.team = paper::team(paper::Variant::joint);
  const std::string summary = Summary(scenario, 1).json();
  const std::string parts =
      R"({"parts": [["uav0"], ["uav1"]], "order": "parallel", "exchanges": 2, "cost": 0.0,
      "whole_cost": 0.0, "cost_excess": 0.01, "part_us": 5.0, "moments": 3, "sweeps": [{"sweep": 1,
      "input": {"median": 1.0}, "cost": {"median": 0.1}, "kkt": {"median": 0.01}}]})";
  EXPECT_THAT(report_html(flown(5), summary, parts),
              AllOf(HasSubstr("The team in parts"), HasSubstr("uav0, uav1")));
  const std::string other = std::string(parts).replace(parts.find("\"cost\": 0.0"), 11, "\"cost\": 1.0");
  EXPECT_THAT(report_html(flown(5), summary, other), Not(HasSubstr("The team in parts")));
  EXPECT_THROW(report_html(flown(5), summary, "{}"), std::runtime_error);
}

TEST(ReportHtml, IsOnePageThatAsksForNoOtherFile) {
  const std::string page = report_html(flown(100), "");
  EXPECT_EQ(page.find("<!DOCTYPE html>"), 0u);
  EXPECT_THAT(page, HasSubstr("</html>"));
  for (const char* word : {"<link", "<script src", "<img", " src=", "import(", "@import", "url(http",
                           "href=\"http", "href='http"}) {
    EXPECT_THAT(page, Not(HasSubstr(word)));
  }
}

TEST(ReportHtml, ShowsTextOfTheScenarioAsText) {
  Recording run = flown(5);
  run.name = "<b>&\"name\"";
  const std::string page = report_html(run, "");
  EXPECT_THAT(page, HasSubstr("<h1>&lt;b&gt;&amp;&quot;name&quot;</h1>"));
  EXPECT_THAT(page, HasSubstr("# robots &amp; targets\nname = &quot;&lt;two&gt;&quot;\n"));
  EXPECT_THAT(page, Not(HasSubstr("<b>")));
}

TEST(ReportHtml, SaysThatARunDidNotEnd) {
  Recording run = flown(5);
  run.complete = false;
  EXPECT_THAT(report_html(run, ""), HasSubstr("its log stops at 0.05 s, and there is no summary.json"));
}

TEST(ReportHtml, TellsTheFirstEventsAndThatThereAreMore) {
  Recording run = flown(5);
  for (int i = 0; i < 60; ++i) run.events.push_back({0.01 * i, "missed_period", 0, 1.0});
  const std::string page = report_html(run, "");
  EXPECT_THAT(page,
              AllOf(HasSubstr("Events (60)"), HasSubstr("missed_period 1"), HasSubstr("more in run.mcap")));
}

TEST(ReportHtml, IsMadeOfARunWithoutAPeriod) {
  EXPECT_THAT(report_html(Recording{}, ""), AllOf(HasSubstr("</html>"), Not(HasSubstr("<figure"))));
}

TEST(ReportHtml, TellsEachLineOfTheSummaryAndNoWarning) {
  Scenario scenario;
  scenario.name = "<two>";
  scenario.team = paper::team(paper::Variant::joint);
  const std::string summary = Summary(scenario, 1).json();
  const std::string page = report_html(flown(5), summary);
  ASSERT_FALSE(summary_lines(summary).empty());
  for (const SummaryLine& line : summary_lines(summary)) {
    EXPECT_THAT(page, HasSubstr("<th scope=\"row\">" + line.what + "</th><td>" + line.value + "</td>"));
  }
  EXPECT_THAT(page, Not(HasSubstr("did not end")));
}

TEST(ReportHtml, RefusesASummaryThatIsNone) {
  for (const char* text : {"{", "[]", "7", "{\"updates\": []}"}) {
    EXPECT_THROW(report_html(flown(5), text), std::runtime_error) << text;
  }
}

TEST(WriteReport, RefusesAFolderWithoutARun) {
  EXPECT_THROW(write_report(std::filesystem::temp_directory_path() / "sightline_no_run"), std::runtime_error);
}

}  // namespace
}  // namespace sightline
