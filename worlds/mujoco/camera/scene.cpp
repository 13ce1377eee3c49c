#include "worlds/mujoco/camera/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "sightline/base.hpp"
#include "worlds/mujoco/mjcf.hpp"

namespace sightline::mujoco {
namespace {

constexpr int pixels_of_a_cell = 32;
constexpr int side = pixels_of_a_cell * TagFinder::cells;
constexpr const char* unseen = "contype=\"0\" conaffinity=\"0\"";

std::string plates_of(const BodyTags& of, const TagNumbers& numbers) {
  const Tags& tags = of.tags;
  const double half = 0.5 * Tags::border * tags.size;
  std::string text;
  for (int face = 0; face < tags.faces; ++face) {
    const Vec3<double> n = tags.normal(face), c = tags.centre(face) - 0.002 * n;
    text += fmt::format(
        "<geom type=\"box\" size=\"{} {} 0.002\" pos=\"{} {} {}\" xyaxes=\"{} {} 0 0 0 1\" material=\"tag "
        "{}\" {}/>\n",
        half, half, c.x, c.y, c.z, -n.y, n.x, numbers.first + face, unseen);
  }
  // A solid cylinder behind the plates closes the view between them.
  const double inner = 0.9 * tags.distance * std::cos(std::numbers::pi / std::max(3, tags.faces));
  if (inner > 0.004)
    text += fmt::format("<geom type=\"cylinder\" size=\"{} {}\" pos=\"0 0 {}\" rgba=\"0.3 0.3 0.3 1\" {}/>\n",
                        inner, half, tags.height, unseen);
  return text;
}

std::string hull_text(const Hull& hull) {
  return hull.height > 0
             ? fmt::format("<geom type=\"cylinder\" size=\"{} {}\" rgba=\"0.35 0.3 0.3 1\" {}/>\n",
                           hull.radius, 0.5 * hull.height, unseen)
             : fmt::format("<geom type=\"sphere\" size=\"{}\" rgba=\"0.35 0.3 0.3 1\" {}/>\n", hull.radius,
                           unseen);
}

}  // namespace

std::vector<TagNumbers> number_tags(const CameraOptions& options) {
  std::vector<TagNumbers> all;
  int next = 0;
  for (const BodyTags& one : options.tags) {
    all.push_back({one.body, next, one.tags.faces});
    next += one.tags.faces;
  }
  if (next > TagFinder::tags)
    throw_invalid("the bodies have {} tags, tag36h11 has {}", next, TagFinder::tags);
  return all;
}

std::string scene_of(const Team& team, const CameraOptions& options,
                     const std::optional<ModelFile>& surroundings) {
  const std::vector<TagNumbers> numbers = number_tags(options);
  int width = 1, height = 1;
  for (const RobotCamera& one : options.cameras) {
    width = std::max(width, one.camera.width);
    height = std::max(height, one.camera.height);
  }
  std::string text = "<mujoco>\n<size nconmax=\"1\" njmax=\"1\"/>\n", assets, bodies;
  if (surroundings)
    text += fmt::format("<include file=\"{}\"/>\n",
                        std::filesystem::path(surroundings->name).filename().string());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    for (int face = 0; face < numbers[i].count; ++face) {
      const int number = numbers[i].first + face;
      assets += fmt::format(
          "<texture name=\"tag {0}\" type=\"2d\" builtin=\"flat\" width=\"{1}\" height=\"{1}\"/>\n"
          "<material name=\"tag {0}\" texture=\"tag {0}\" texuniform=\"false\" specular=\"0\" "
          "shininess=\"0\" "
          "reflectance=\"0\" emission=\"0.6\"/>\n",
          number, side);
    }
  }
  for (int i = 0; i < team.bodies(); ++i) {
    bodies += "<body mocap=\"true\">\n";
    const auto of = [i](const auto& one) { return one.body == BodyId{i}; };
    const auto tags = std::find_if(options.tags.begin(), options.tags.end(), of);
    const auto hull = std::find_if(options.hulls.begin(), options.hulls.end(), of);
    if (tags != options.tags.end()) {
      bodies += plates_of(*tags, numbers[size(static_cast<int>(tags - options.tags.begin()))]);
    } else if (hull != options.hulls.end()) {
      bodies += hull_text(hull->hull);
    }
    bodies += "</body>\n";
  }
  for (std::size_t i = 0; i < options.cameras.size(); ++i) {
    bodies += fmt::format(
        "<body mocap=\"true\"><camera name=\"camera {}\" xyaxes=\"0 -1 0 0 0 1\" fovy=\"{}\"/></body>\n", i,
        options.cameras[i].camera.field_of_view * 180 / std::numbers::pi);
  }
  text += fmt::format(
      "<compiler angle=\"degree\"/>\n"
      "<visual><global offwidth=\"{}\" offheight=\"{}\"/><quality offsamples=\"4\"/><map znear=\"0.01\" "
      "zfar=\"60\"/></visual>\n"
      "<statistic extent=\"2\"/>\n"
      "<asset>\n<texture type=\"skybox\" builtin=\"gradient\" rgb1=\"0.6 0.7 0.9\" rgb2=\"0.8 0.8 0.8\" "
      "width=\"64\" "
      "height=\"64\"/>\n"
      "<texture name=\"floor of the pictures\" type=\"2d\" builtin=\"checker\" width=\"256\" height=\"256\" "
      "rgb1=\"0.4 0.5 0.4\" rgb2=\"0.3 0.35 0.3\"/>\n"
      "<material name=\"floor of the pictures\" texture=\"floor of the pictures\" texrepeat=\"8 "
      "8\"/>\n{}</asset>\n",
      width, height, assets);
  text += fmt::format(
      "<worldbody>\n<light pos=\"0 0 6\" dir=\"0 0 -1\" directional=\"true\" castshadow=\"false\" "
      "diffuse=\"0.6 0.6 0.6\"/>\n"
      "<geom type=\"plane\" size=\"10 10 0.1\" material=\"floor of the pictures\" "
      "{}/>\n{}</worldbody>\n</mujoco>\n",
      unseen, bodies);
  return text;
}

Scene::Scene(const Team& team, const CameraOptions& options, const std::optional<ModelFile>& surroundings,
             const TagFinder& tags)
    : options_(options) {
  try {
    model_ = load(scene_of(team, options, surroundings), surroundings ? &*surroundings : nullptr);
  } catch (const std::invalid_argument& error) {
    throw_invalid("MuJoCo refuses what cameras are to see: {}", error.what());
  }
  data_ = data_of(*model_);
  // The bodies of the team, then the cameras' mocap bodies, come last in the model.
  const int all = team.bodies() + static_cast<int>(options.cameras.size());
  for (int i = 0; i < team.bodies(); ++i) {
    const int id = model_->nbody - all + i;
    bodies_.push_back(
        {model_->body_mocapid[id], std::max(0, model_->body_geomadr[id]), model_->body_geomnum[id]});
  }
  for (int i = team.bodies(); i < all; ++i) eyes_.push_back(model_->body_mocapid[model_->nbody - all + i]);
  for (int geom = 0; geom < model_->ngeom; ++geom) alpha_.push_back(model_->geom_rgba[4 * geom + 3]);
  draw_tags(tags);
  int pixels = 0;
  for (const RobotCamera& one : options.cameras)
    pixels = std::max(pixels, one.camera.width * one.camera.height);
  rgb_.resize(3 * size(pixels));

  mjv_defaultOption(&option_);
  mjv_defaultScene(&scene_);
  mjr_defaultContext(&context_);
  const bool made = tried(
      [](void* self) {
        auto& of = *static_cast<Scene*>(self);
        mjv_makeScene(of.model_.get(), &of.scene_, of.model_->ngeom + 8);
        mjr_makeContext(of.model_.get(), &of.context_, mjFONTSCALE_50);
        mjr_setBuffer(mjFB_OFFSCREEN, &of.context_);
      },
      this);
  if (!made || context_.currentBuffer != mjFB_OFFSCREEN)
    throw_invalid("MuJoCo renders nothing here: {}",
                  made ? "OpenGL has no buffer off screen" : on_one_line(last_error()));
  scene_.flags[mjRND_SHADOW] = 0;
  scene_.flags[mjRND_REFLECTION] = 0;
  scene_.flags[mjRND_SKYBOX] = 1;
  offscreen_.release();
}

Scene::~Scene() {
  if (offscreen_.make_current()) mjr_freeContext(&context_);
  mjv_freeScene(&scene_);
}

/// Uploads the tags in place of the flat textures.
void Scene::draw_tags(const TagFinder& tags) {
  for (const TagNumbers& numbers : number_tags(options_)) {
    for (int number = numbers.first; number < numbers.first + numbers.count; ++number) {
      const int texture = mj_name2id(model_.get(), mjOBJ_TEXTURE, fmt::format("tag {}", number).c_str());
      unsigned char* to = model_->tex_rgb + model_->tex_adr[texture];
      const std::vector<std::uint8_t> cells = tags.image(number);
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x, to += 3) {
          const int row = y / pixels_of_a_cell, column = x / pixels_of_a_cell;
          std::fill_n(to, 3, cells[size(row * TagFinder::cells + column)]);
        }
      }
    }
  }
}

void Scene::place(int mocap, const RigidPose& pose) noexcept {
  const Quaternion q = quaternion(pose.R);
  double *const p = data_->mocap_pos + 3 * mocap, *const r = data_->mocap_quat + 4 * mocap;
  p[0] = pose.p.x, p[1] = pose.p.y, p[2] = pose.p.z;
  r[0] = q.w, r[1] = q.x, r[2] = q.y, r[3] = q.z;
}

void Scene::show(const Shown& body, bool visible) noexcept {
  for (int geom = body.first_geom; geom < body.first_geom + body.geoms; ++geom)
    model_->geom_rgba[4 * geom + 3] = visible ? alpha_[size(geom)] : 0.0F;
}

struct Scene::Call {
  Scene& scene;
  std::size_t camera;
};

bool Scene::draw(std::size_t camera) noexcept {
  Call call{*this, camera};
  return tried(
      [](void* argument) {
        auto& [of, number] = *static_cast<Call*>(argument);
        const mjModel* const model = of.model_.get();
        mj_kinematics(model, of.data_.get());
        mj_comPos(model, of.data_.get());
        mj_camlight(model, of.data_.get());
        mjvCamera eye;
        mjv_defaultCamera(&eye);
        eye.type = mjCAMERA_FIXED;
        eye.fixedcamid = model->ncam - static_cast<int>(of.eyes_.size()) + static_cast<int>(number);
        mjv_updateScene(model, of.data_.get(), &of.option_, nullptr, &eye, mjCAT_ALL, &of.scene_);
        const Camera& camera_of = of.options_.cameras[number].camera;
        const mjrRect whole = {0, 0, camera_of.width, camera_of.height};
        mjr_render(whole, &of.scene_, &of.context_);
        mjr_readPixels(of.rgb_.data(), nullptr, whole, &of.context_);
      },
      &call);
}

std::span<const std::uint8_t> Scene::render(const Exposure& exposure, const RigidPose& camera) noexcept {
  if (!offscreen_.make_current()) return {};
  const RobotCamera& of = options_.cameras[exposure.camera];
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    place(bodies_[i].mocap, exposure.bodies[i].now);
    show(bodies_[i], exposure.bodies[i].there && i != at(of.observer));
  }
  place(eyes_[exposure.camera], camera);
  if (!draw(exposure.camera)) return {};
  return std::span(rgb_).first(3 * size(of.camera.width * of.camera.height));
}

}  // namespace sightline::mujoco
