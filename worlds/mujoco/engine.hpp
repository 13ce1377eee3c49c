/// MuJoCo calls that neither end the process nor write a file: errors and warnings become messages.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>

#include "sightline/vehicle.hpp"

namespace sightline::mujoco {

struct Delete {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using ModelPointer = std::unique_ptr<mjModel, Delete>;
using DataPointer = std::unique_ptr<mjData, Delete>;

/// Loads a model from MJCF. It may include and name `beside` itself and files in its folder.
/// @throws std::invalid_argument with MuJoCo's message on one line
ModelPointer load(const std::string& mjcf, const ModelFile* beside = nullptr);
/// @throws std::invalid_argument if MuJoCo has no memory for the data
DataPointer data_of(const mjModel& model);

/// The MuJoCo calls of a flight's step. They return false on an error; last_error() then describes
/// it, and the data are invalid.
bool step_1(const mjModel& model, mjData& data) noexcept;
bool step_2(const mjModel& model, mjData& data) noexcept;
bool find_contacts(const mjModel& model, mjData& data) noexcept;
/// Runs a function that calls MuJoCo and has no C++ objects of its own. Returns false if a call met
/// an error.
bool tried(void (*calls)(void*), void* argument) noexcept;
/// The last error of this thread.
const char* last_error() noexcept;
/// The first warning in the data that ends a flight, such as diverged states or a full contact
/// buffer; null if there is none.
const char* warning(const mjData& data) noexcept;

/// The text without line breaks.
std::string on_one_line(std::string text);

}  // namespace sightline::mujoco
