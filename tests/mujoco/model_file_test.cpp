// A user's own MJCF: what else is in the world, and what a vehicle is.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "sightline/scenario.hpp"
#include "sightline/world/rotorcraft.hpp"
#include "tests/mujoco/team.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
namespace fs = std::filesystem;

const std::string base = R"toml([world]
kind = "mujoco"
#model

[agent.uav]
robot = "velocity_multirotor"
parameters = { preset = "px4" }
start = { p = [0.0, 0.0, 2.0], heading = 0.0 }
Q = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
R = [1.0, 1.0, 0.1, 1.0]
reference = { state = [0.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0] }

[agent.uav.vehicle]
#vehicle

[simulation]
duration = 2.0
)toml";

const std::string wall =
    "<mujoco><worldbody><geom name='the wall' type='box' size='0.1 3 3' pos='2 0 3'/></worldbody></mujoco>";
/// A plate with two legs on a stiff arm: mass, inertia and centre are told by hand below.
const std::string drone = R"(<mujoco><compiler angle="radian"/><worldbody>
<body name="stand"><geom type="box" size="1 1 0.1" pos="9 0 0"/></body>
<body name="quad" pos="0 0 1" quat="0.7071067811865476 0 0 0.7071067811865476"><freejoint/>
<geom type="box" size="0.2 0.1 0.02" mass="1.2"/>
<body name="skid" pos="0 0 -0.1"><geom type="box" size="0.15 0.08 0.01" mass="0.3"/></body>
<geom name="shell" type="sphere" size="2" mass="0" contype="0" conaffinity="0"/>
</body></worldbody></mujoco>)";

class ModelFiles : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  fs::path scenario(const std::string& world, const std::string& vehicle) const {
    std::string text = base;
    text.replace(text.find("#model"), 6, world);
    text.replace(text.find("#vehicle"), 8, vehicle);
    return write("a.toml", text);
  }
  Scenario read(const std::string& world, const std::string& vehicle = "") const {
    return read_scenario(scenario(world, vehicle), with_mujoco());
  }
  /// Without the folder.
  std::string refusal(const std::string& world, const std::string& vehicle = "") const {
    std::string said = refusal_of<ScenarioError>([&] { read(world, vehicle); });
    if (const auto at = said.find(folder_.string() + "/"); at == 0)
      said.erase(0, folder_.string().size() + 1);
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    return said;
  }
  static Registry with_mujoco() {
    Registry registry;
    add_mujoco(registry);
    return registry;
  }

  const fs::path folder_ = fresh_folder();
};

End flown(const Scenario& scenario, const Vec3<double>& v, double duration = 5.0) {
  return end_of(*make_world(scenario), v, duration);
}
const MujocoWorld& of(const World& world) { return dynamic_cast<const MujocoWorld&>(world); }

TEST_F(ModelFiles, SurroundingsAreTouchedByTheirNames) {
  write("rooms/hall.xml", wall);
  const Scenario scenario = read("model = \"rooms/hall.xml\"");
  EXPECT_THAT(summary(scenario), HasSubstr("world       mujoco with rooms/hall.xml\n"));
  EXPECT_THAT(flown(scenario, {1, 0, 0}).why,
              AllOf(StartsWith("uav touched the wall at "), HasSubstr(" m/s, expected at most 0.5 m/s")));
  EXPECT_EQ(flown(scenario, {-1, 0, 0}).why, "");
  EXPECT_EQ(flown(scenario, {0.3, 0, 0}, 10.0).why, "") << "a slow touch is carried";
  EXPECT_THAT(flown(scenario, {0, 0, -1}).why, StartsWith("uav touched the ground at "));
}

TEST_F(ModelFiles, SurroundingsIncludeFilesBesideThemAndChangeNeitherStepNorAir) {
  write("rooms/wall.xml", wall);
  write("rooms/hall.xml",
        "<mujoco><option timestep='0.01' gravity='0 0 -1' density='1.2' integrator='RK4' wind='9 0 0'>"
        "<flag contact='disable' gravity='disable'/></option><compiler inertiafromgeom='true' "
        "settotalmass='1'/>"
        "<default><geom contype='4' conaffinity='4' margin='0.5' mass='3' density='7'/></default>"
        "<include file='wall.xml'/></mujoco>");
  const Scenario scenario = read("model = \"rooms/hall.xml\"");
  EXPECT_THAT(flown(scenario, {1, 0, 0}).why, StartsWith("uav touched the wall at "));
  const auto in_hall = make_world(scenario), in_none = make_world(read(""));
  const auto u = [](double t) { return Numbers{-std::abs(std::sin(t)), 0.5, std::cos(t), 0.3}; };
  EXPECT_EQ(fly(*in_hall, 200, u), fly(*in_none, 200, u));
}

TEST_F(ModelFiles, WhatIsFreeInTheSurroundingsFallsAndCanBeTouched) {
  write("drop.xml",
        "<mujoco><worldbody><body name='the crate' pos='0 0 6'><freejoint/><geom type='box' size='.2 .2 "
        ".2'/></body>"
        "</worldbody></mujoco>");
  const End end = flown(read("model = \"drop.xml\""), {0, 0, 0.8});
  EXPECT_THAT(end.why, StartsWith("uav touched the crate at "));
  EXPECT_LT(end.t, 1.2) << "sqrt(2 3.9 / g) = 0.89 s if it stayed";
}

TEST_F(ModelFiles, AVehicleHasMassInertiaAndGeomsOfItsBodyInTheAxesOfTheBody) {
  write("drone.xml", drone);
  const std::string vehicle = "model = \"drone.xml\"\nbody = \"quad\"\n";
  const Scenario scenario = read("", vehicle);
  const Vehicle& v = scenario.vehicles.at(0).vehicle;
  // Box: m (b^2 + c^2) / 3 by half sides; the centre of mass lies 0.02 m below the plate's.
  const auto about = [](double m, double b, double c, double z) { return m * ((b * b + c * c) / 3 + z * z); };
  EXPECT_NEAR(v.mass, 1.5, 1e-12);
  EXPECT_NEAR(v.inertia.x, about(1.2, 0.1, 0.02, 0.02) + about(0.3, 0.08, 0.01, 0.08), 1e-12);
  EXPECT_NEAR(v.inertia.y, about(1.2, 0.2, 0.02, 0.02) + about(0.3, 0.15, 0.01, 0.08), 1e-12);
  EXPECT_NEAR(v.inertia.z, about(1.2, 0.2, 0.1, 0) + about(0.3, 0.15, 0.08, 0), 1e-12);
  EXPECT_EQ(v.k_f, Vehicle::x500().k_f);
  EXPECT_THAT(summary(scenario), HasSubstr("uav: x500 as quad of drone.xml, 1.5 kg, 4 rotors"));
  EXPECT_EQ(read("", vehicle + "mass = 1.7\n").vehicles[0].vehicle.mass, 1.7) << "a number beside it counts";

  // It flies as the same numbers written out, and stands on its skid.
  Scenario numbers = scenario;
  numbers.vehicles[0].model.reset();
  const auto u = [](double t) { return Numbers{std::sin(t), 0.5, 0.2 * std::cos(t), 0.3}; };
  EXPECT_EQ(fly(*make_world(scenario), 300, u), fly(*make_world(numbers), 300, u));
  const auto world = make_world(scenario);
  EXPECT_EQ(end_of(*world, {0, 0, -0.35}, 8.0).why, "");
  EXPECT_NEAR(of(*world).rotorcraft(BodyId{0})->body().p.z, 0.09, 2e-3);
}

TEST_F(ModelFiles, AVehicleOfAMeshTouchesWithItsHull) {
  write("drone.obj",
        "v -.3 -.3 -.1\nv .3 -.3 -.1\nv .3 .3 -.1\nv -.3 .3 -.1\nv -.3 -.3 .1\nv .3 -.3 .1\nv .3 .3 .1\nv "
        "-.3 .3 .1\n"
        "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 "
        "5\nf 4 5 8\n");
  write(
      "drone.xml",
      "<mujoco><asset><mesh name='shell' file='drone.obj'/></asset><worldbody><body name='quad'>"
      "<geom type='mesh' mesh='shell' pos='0 0 0.5' euler='0 0 30' mass='1.5'/></body></worldbody></mujoco>");
  const auto world = make_world(read("", "model = \"drone.xml\"\nbody = \"quad\"\n"));
  EXPECT_EQ(end_of(*world, {0, 0, -0.35}, 8.0).why, "");
  EXPECT_NEAR(of(*world).rotorcraft(BodyId{0})->body().p.z, 0.1, 2e-3);
}

TEST_F(ModelFiles, OtherBodiesTouchTheGeomsOfAVehicle) {
  write("drone.xml", drone);
  for (const double z : {0.0, -0.08, -0.2}) {
    const ModelBody body = {{"drone.xml", drone, folder_}, "quad"};
    Scene s = scene(vehicle_of_mjcf(Vehicle::x500(), body), 3.0, Other::post, 1.0);
    s.vehicles[0].model = body;
    s.x0[11] += z;
    MujocoWorld world(s.team, s.x0, s.vehicles);
    EXPECT_EQ(end_of(world, {0.5, 0, 0}).why.empty(), z < -0.1) << z;
  }
}

TEST_F(ModelFiles, AReplayOfALogNeedsNoFile) {
  write("hall.xml", wall);
  write("drone.xml", drone);
  const auto file =
      scenario("model = \"hall.xml\"", "model = \"drone.xml\"\nbody = \"quad\"\nk_f = 7e-6\n").string();
  const std::string out = (folder_ / "run").string();
  const auto run = sightline("run " + file + " -o " + out, folder_);
  ASSERT_EQ(run.code, 0) << run.err;
  fs::remove(folder_ / "hall.xml"), fs::remove(folder_ / "drone.xml");
  const auto replayed = sightline("replay " + out, folder_);
  EXPECT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr("200 commands, 0 differ"));
}

TEST_F(ModelFiles, ATouchEndsARunWithExitCodeOneAndASentence) {
  write("hall.xml",
        "<mujoco><worldbody><geom name='roof' type='box' size='3 3 .1' pos='0 0 0.5'/></worldbody></mujoco>");
  const auto file = scenario("model = \"hall.xml\"", "").string();
  std::string text = read_file(file);
  text.replace(text.find("state = [0.0, 0.0, 2.0"), 22, "state = [0.0, 0.0, -9.0");
  write("a.toml", text);
  const auto run = sightline("run " + file + " -o " + (folder_ / "run").string(), folder_);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("uav touched roof at "));
}

TEST_F(ModelFiles, WhatIsBrokenEndsInOneLineWithFileLineAndKey) {
  struct Case {
    std::string file, vehicle, said;
  };
  const auto in_world = [](const std::string& bodies) {
    return "<mujoco><worldbody>" + bodies + "</worldbody></mujoco>";
  };
  for (const Case& broken : std::vector<Case>{
           {"no XML at all", "", "a.toml:3: world.model = \"room.xml\", MuJoCo refuses it: XML "},
           {"<mujoco><worldbody>", "", "XML "},
           {"<robot/>", "", "Empty include file"},
           {in_world("<geom type='box'/>"), "", "sizes must be positive in object"},
           {in_world("<geom size='1' colour='red'/>"), "", "unrecognized attribute: 'colour'"},
           {in_world("<body><freejoint/></body>"), "",
            "mass and inertia of moving bodies must be larger than"},
           {in_world("<body name='uav'/>"), "", "repeated name in body array"},
           {in_world("<geom type='mesh' mesh='none'/>"), "", "mesh 'none' not found in geom"},
           {"<mujoco><include file='none.xml'/></mujoco>", "", "none.xml"},
           {"<mujoco><asset><mesh file='none.stl'/></asset></mujoco>", "", "none.stl"},
           {in_world("<geom name='table' type='box' size='1 1 1' pos='0 0 1.5'/>"), "",
            "a.toml:1: world: uav starts 0.5 m deep in table, expected outside of it"},
           {drone, "body = \"quad\"",
            "a.toml:13: agent.uav.vehicle.model is missing, expected the file that body is of"},
           {drone, "model = \"room.xml\"",
            "body = \"\", expected one of room.xml: \"stand\", \"quad\", \"skid\""},
           {drone, "model = \"room.xml\"\nbody = \"quat\"",
            "a.toml:15: agent.uav.vehicle.body = \"quat\", expected one of room.xml: \"stand\", \"quad\", "
            "\"skid\""},
           {in_world("<geom size='1'/>"), "model = \"room.xml\"\nbody = \"a\"",
            "a.toml:14: agent.uav.vehicle.model = \"room.xml\", expected an MJCF with a body that has a "
            "name"},
           {in_world("<body name='a'/>"), "model = \"room.xml\"\nbody = \"a\"",
            "expected one with mass, it has none"},
           {in_world("<body name='a'><geom type='box' size='.3 .1 .1' euler='0 0 30' mass='1'/></body>"),
            "model = \"room.xml\"\nbody = \"a\"", "a product of inertia is 0.01"},
           {in_world("<body name='a'><geom size='.3' mass='1'/><geom type='plane' size='1 1 1'/></body>"),
            "model = \"room.xml\"\nbody = \"a\"", "expected one without planes and height fields that touch"},
           {in_world("<body name='a'><geom size='.3' mass='9'/></body>"),
            "model = \"room.xml\"\nbody = \"a\"", "agent.uav.vehicle: vehicle.mass = 9 kg with 4 rotors"},
           {in_world("<body name='a'><geom size='.3' mass='1'/></body"), "model = \"room.xml\"\nbody = \"a\"",
            "a.toml:14: agent.uav.vehicle.model = \"room.xml\", MuJoCo refuses it: XML "},
       }) {
    write("room.xml", broken.file);
    EXPECT_THAT(refusal(broken.vehicle.empty() ? "model = \"room.xml\"" : "", broken.vehicle),
                HasSubstr(broken.said));
  }
  EXPECT_THAT(refusal("model = \"missing.xml\""),
              HasSubstr("a.toml:3: world.model = \"missing.xml\", expected the name of a model file, "
                        "relative to this one ("));
  EXPECT_THAT(
      refusal("model = 3"),
      HasSubstr("a.toml:3: world.model = 3, expected the name of a model file, relative to this one"));
  EXPECT_THAT(refusal("modell = \"a.xml\""), HasSubstr("the nearest is \"model\""));
}

TEST_F(ModelFiles, AnotherWorldKnowsNoModels) {
  write("room.xml", wall);
  const auto refused = [&](const std::string& world, const std::string& vehicle) {
    std::string text = base;
    text.replace(text.find("mujoco"), 6, "rotors");
    text.replace(text.find("#model"), 6, world);
    text.replace(text.find("#vehicle"), 8, vehicle);
    return refusal_of<ScenarioError>([&] { parse_scenario(text, folder_ / "a.toml", with_mujoco()); });
  };
  EXPECT_THAT(refused("model = \"room.xml\"", ""),
              HasSubstr("world.model = \"room.xml\", expected no such key in the world \"rotors\""));
  EXPECT_THAT(refused("", "model = \"room.xml\""),
              HasSubstr("vehicle.model = \"room.xml\", expected no such key in the world \"rotors\""));
  EXPECT_THAT(refusal_of<ScenarioError>([] { parse_scenario(base, "a.toml"); }),
              HasSubstr("a.toml:2: world.kind = \"mujoco\", expected one of \"model\", \"rotors\""));
}

TEST_F(ModelFiles, WhatMuJoCoMeetsInFlightEndsItWithASentence) {
  const auto ended = [&](const std::string& settings, const Vec3<double>& v) {
    write("room.xml", "<mujoco>" + settings + "</mujoco>");
    return flown(read("model = \"room.xml\""), v, 20.0).why;
  };
  EXPECT_THAT(ended("<size nconmax='1'/>", {0, 0, -0.4}),
              AllOf(StartsWith("MuJoCo ended it at "), HasSubstr("nconmax")));
  EXPECT_THAT(ended("<size njmax='2'/>", {0, 0, -0.4}),
              AllOf(StartsWith("MuJoCo ended it at "), HasSubstr("njmax")));
  EXPECT_THAT(ended("<size nstack='200'/>", {0, 0, -0.4}),
              AllOf(StartsWith("MuJoCo ended it at "), HasSubstr("Stack overflow")));
  EXPECT_FALSE(fs::exists("MUJOCO_LOG.TXT"));
}

}  // namespace
}  // namespace sightline
