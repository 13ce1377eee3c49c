/// MuJoCo behind calls that neither end the process nor write a file: its errors and warnings become sentences.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>

#include "sightline/world/vehicle.hpp"

namespace sightline::mujoco {

struct Delete {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using ModelPointer = std::unique_ptr<mjModel, Delete>;
using DataPointer = std::unique_ptr<mjData, Delete>;

/// A model from MJCF. It may include and name files of `beside`: itself, and those in its folder.
/// @throws std::invalid_argument MuJoCo's sentence, on one line
ModelPointer load(const std::string& mjcf, const ModelFile* beside = nullptr);
/// @throws std::invalid_argument where MuJoCo has no memory for it
DataPointer data_of(const mjModel& model);

/// The calls in a step of a flight. False where MuJoCo met an error: last_error() says which, and the data are spoilt.
bool step_1(const mjModel& model, mjData& data) noexcept;
bool step_2(const mjModel& model, mjData& data) noexcept;
bool find_contacts(const mjModel& model, mjData& data) noexcept;
/// Calls of MuJoCo by a function without C++ objects of its own. False where one met an error.
bool tried(void (*calls)(void*), void* argument) noexcept;
/// Of this thread.
const char* last_error() noexcept;
/// What the data warn of that no flight goes on with, as diverged states and contacts without room; null where there is nothing.
const char* warning(const mjData& data) noexcept;

/// Without ends of lines.
std::string on_one_line(std::string text);

}  // namespace sightline::mujoco
