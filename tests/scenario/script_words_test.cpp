#include "sightline/scenario/script_words.hpp"

#include <gtest/gtest.h>

#include "sightline/potential/distance.hpp"
#include "sightline/potential/sensor_cone.hpp"

namespace sightline {
namespace {

struct Scene {
  Team team;
  AgentId uav0 = team.add(Multirotor{});
  AgentId uav1 = team.add(Multirotor{});
  BodyId rock = team.add(Obstacle{"rock"});

  std::string of(const Trigger& trigger) const { return in_words(trigger, team); }
  std::string of(const Action& action) const { return in_words(action, team); }
};

TEST(ScriptWords, each_trigger_is_said) {
  const Scene s;
  EXPECT_EQ(s.of(AtTime{20}), "at 20 s");
  EXPECT_EQ(s.of(AfterTime{2.5}), "after 2.5 s");
  EXPECT_EQ(s.of(Signal{"go"}), "on the signal go");
  EXPECT_EQ(s.of(Condition{.measure = DistanceOf{s.uav0, s.rock},
                           .side = Condition::Side::below,
                           .threshold = 1.5,
                           .hysteresis = 0.2,
                           .dwell = 0.5}),
            "when the distance of uav0 and rock is below 1.5, hysteresis 0.2, for 0.5 s");
  EXPECT_EQ(s.of(Condition{.measure = ViewAngleOf{s.uav0, s.uav1, {}}, .threshold = 0.5}),
            "when the view angle of uav0 to uav1 is above 0.5");
  EXPECT_EQ(s.of(Condition{.measure = AgeOf{s.uav1}, .threshold = 0.5}),
            "when the age of what is known of uav1 is above 0.5");
  const ExcessOf view{SensorCone{}, s.uav0, s.uav1};
  EXPECT_EQ(s.of(Condition{.measure = view}), "when sensor_cone is broken between uav0 and uav1");
  EXPECT_EQ(s.of(Condition{.measure = view, .side = Condition::Side::below}),
            "when sensor_cone holds between uav0 and uav1");
  EXPECT_EQ(s.of(Condition{.measure = view, .threshold = 0.1}),
            "when the excess of sensor_cone between uav0 and uav1 is above 0.1");
}

TEST(ScriptWords, each_action_is_said) {
  const Scene s;
  EXPECT_EQ(s.of(RemoveBody{s.rock}), "remove rock");
  EXPECT_EQ(s.of(RemoveBody{s.uav1, Afterwards::hold}), "remove uav1, which holds");
  EXPECT_EQ(s.of(RemoveBody{s.uav1, Afterwards::land}), "remove uav1, which lands");
  EXPECT_EQ(s.of(AddBody{s.uav1}), "add uav1");
  EXPECT_EQ(s.of(AddCoupling{{.term = 0.5 * KeepOut{}, .between = {s.uav0, s.rock}, .felt_by = {s.uav0}}}),
            "add 0.5 keep_out between uav0 and rock");
  EXPECT_EQ(s.of(RemoveTerm{"apart"}), "remove apart");
  EXPECT_EQ(s.of(RetuneTerm{"apart", 0.25, Potential(KeepOut{})}),
            "retune apart, weight 0.25, another keep_out");
  EXPECT_EQ(s.of(RetuneAgent{.agent = s.uav0, .Q = std::vector<double>(7), .u_ref = std::vector<double>(4)}),
            "retune Q, u_ref of uav0");
  EXPECT_EQ(s.of(SetReference{s.uav1, {}}), "another reference for uav1");
  EXPECT_EQ(s.of(Observe{s.uav1, s.rock}), "uav1 observes rock");
}

TEST(ScriptWords, an_event_says_its_name_stage_changes_and_ramp) {
  const Scene s;
  const TeamEvent event{.name = "hand over",
                        .trigger = AfterTime{2},
                        .actions = {RemoveBody{s.rock}, Observe{s.uav0, s.uav1}},
                        .stage = "near",
                        .enter = "far"};
  EXPECT_EQ(
      in_words(event, s.team),
      "hand over, after 2 s, in stage near: remove rock; uav0 observes uav1; enter stage far, over 1 s");
  const TeamEvent each{.name = "e", .trigger = Signal{"go"}, .actions = {AddBody{s.rock}}, .repeat = true};
  EXPECT_EQ(in_words(each, s.team), "e, on the signal go, as often as that comes about: add rock");
}

}  // namespace
}  // namespace sightline
