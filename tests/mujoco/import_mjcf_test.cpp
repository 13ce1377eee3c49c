// What is imported from an MJCF is what MuJoCo simulates.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "sightline/base.hpp"
#include "sightline/import/vehicle_description.hpp"
#include "worlds/mujoco/engine.hpp"

namespace sightline {
namespace {

std::string drawn(std::mt19937& random, double least, double most, int count) {
  std::uniform_real_distribution<double> number(least, most);
  std::string text;
  for (int i = 0; i < count; ++i) text += fmt::format("{}{:.6f}", i == 0 ? "" : " ", number(random));
  return text;
}

std::string drawn_pose(std::mt19937& random) {
  constexpr std::array<std::pair<const char*, int>, 5> turns = {
      {{"quat", 4}, {"euler", 3}, {"axisangle", 4}, {"xyaxes", 6}, {"zaxis", 3}}};
  const auto& [name, count] = turns[random() % turns.size()];
  return fmt::format("pos='{}' {}='{}'", drawn(random, -0.2, 0.2, 3), name, drawn(random, -1.5, 1.5, count));
}

std::string drawn_geom(std::mt19937& random) {
  constexpr std::array<std::pair<const char*, int>, 5> shapes = {
      {{"sphere", 1}, {"capsule", 2}, {"cylinder", 2}, {"ellipsoid", 3}, {"box", 3}}};
  const auto& [type, count] = shapes[random() % shapes.size()];
  const std::string weight = random() % 2 == 0 ? fmt::format("mass='{}'", drawn(random, 0.1, 1, 1))
                                               : fmt::format("density='{}'", drawn(random, 100, 2000, 1));
  const bool ends = random() % 3 == 0 && std::string_view(type) != "sphere";
  if (ends)
    return fmt::format("<geom type='{}' size='{}' fromto='{}' {}/>", type, drawn(random, 0.02, 0.1, 1),
                       drawn(random, -0.3, 0.3, 6), random() % 2 == 0 ? weight : "class='dense'");
  return fmt::format("<geom type='{}' size='{}' {} {}/>", type, drawn(random, 0.02, 0.1, count),
                     drawn_pose(random), weight);
}

/// @param frame  as "frame", or as a body fixed to its parent, which is the same
std::string drawn_vehicle(std::mt19937 random, std::string_view frame) {
  constexpr std::array orders = {"xyz", "ZYX", "zxy", "XzY"};
  std::string text = fmt::format(
      "<mujoco><compiler autolimits='true' angle='{}' eulerseq='{}'/><default><default class='dense'><geom "
      "density='700'/>"
      "</default></default><worldbody><body name='v' pos='1 2 3'><freejoint/>",
      random() % 2 == 0 ? "radian" : "degree", orders[random() % orders.size()]);
  text += drawn_geom(random) + "<site name='s' pos='" + drawn(random, -0.3, 0.3, 3) + "'/>";
  text += fmt::format("<body {}>{}<body {}>", drawn_pose(random), drawn_geom(random), drawn_pose(random));
  text +=
      random() % 2 == 0
          ? fmt::format("<inertial {} mass='0.2' diaginertia='3e-3 4e-3 5e-3'/></body>", drawn_pose(random))
          : fmt::format("<inertial pos='{}' mass='0.2' fullinertia='3e-3 4e-3 5e-3 2e-4 -3e-4 1e-4'/></body>",
                        drawn(random, -0.2, 0.2, 3));
  return text + fmt::format(
                    "</body><{0} {1}>{2}</{0}></body></worldbody><actuator><motor site='s' "
                    "ctrlrange='0 7' gear='0 0 1.5 0 0 -0.03'/><motor site='s' ctrlrange='0 7' "
                    "gear='0 0 1.5 0 0 0.03'/></actuator></mujoco>",
                    frame, drawn_pose(random), drawn_geom(random));
}

TEST(ImportMjcf, MassInertiaAndRotorsAreThoseOfMuJoCo) {
  for (unsigned trial = 0; trial < 200; ++trial) {
    const std::string text = drawn_vehicle(std::mt19937(trial), "frame");
    const XmlFile file({"a.xml", text});
    const VehicleDescription found = describe_mjcf(file);

    const mujoco::ModelPointer model = mujoco::load(drawn_vehicle(std::mt19937(trial), "body"));
    const mujoco::DataPointer data = mujoco::data_of(*model);
    const auto near = [&](double ours, double theirs) {
      ASSERT_NEAR(ours, theirs, 1e-9 + 1e-6 * std::abs(theirs)) << text;
    };

    // All parts about the origin of the vehicle: its axes are those of the world at the start.
    mj_forward(model.get(), data.get());
    double m = 0.0, mass = 0.0;
    Vec3<double> mp{}, moment{};
    Mat<3, 3> I, inertia;
    for (const RigidPart& part : found.parts) {
      const Mat<3, 3> K = cross_matrix(part.p);
      m += part.m, mp = mp + part.m * part.p, I += part.I + part.m * (K * transposed(K));
    }
    for (int body = 1; body < model->nbody; ++body) {
      const double one = model->body_mass[body], *const x = data->xipos + 3 * body,
                   *const axes = data->ximat + 9 * body;
      const Vec3<double> p = {x[0] - 1, x[1] - 2, x[2] - 3};
      Mat<3, 3> R, D;
      for (int i = 0; i < 3; ++i) {
        D(i, i) = model->body_inertia[3 * body + i];
        for (int j = 0; j < 3; ++j) R(i, j) = axes[3 * i + j];
      }
      const Mat<3, 3> K = cross_matrix(p);
      mass += one, moment = moment + one * p, inertia += R * D * transposed(R) + one * (K * transposed(K));
    }
    near(m, mass);
    near(mp.x, moment.x), near(mp.y, moment.y), near(mp.z, moment.z);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) near(I(i, j), inertia(i, j));

    // The force and the torque about the origin of one motor at its limit.
    ASSERT_EQ(found.rotors.size(), 2u);
    data->ctrl[0] = 100.0;
    mj_forward(model.get(), data.get());
    const double thrust = *found.k_f * *found.speed_max * *found.speed_max;
    const double *const force = data->qfrc_actuator, *const torque = force + 3;
    near(thrust, force[2]);
    near(found.rotors[0].p.y * thrust, torque[0]);
    near(-found.rotors[0].p.x * thrust, torque[1]);
    near(-found.rotors[0].spin * *found.k_m * thrust, torque[2]);
  }
}

}  // namespace
}  // namespace sightline
