#include "worlds/mujoco/engine.hpp"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <stdexcept>

#include "sightline/base/c_callback.hpp"

namespace sightline::mujoco {
namespace {

constexpr std::size_t message_size = 1000;

// State of the MuJoCo call in progress on this thread. MuJoCo's error handler must not return.
thread_local std::jmp_buf* way_back = nullptr;
thread_local std::array<char, message_size> last_message{};

void (*errors_before)(const char*) = nullptr;
void (*warnings_before)(const char*) = nullptr;

/// Jumps over MuJoCo's frames, which are C frames in the calls that set way_back.
void on_error(const char* text) {
  if (way_back == nullptr) {  // a call from another part of the program
    if (errors_before != nullptr) return errors_before(text);
    std::fprintf(stderr, "%s\n", text);
    std::exit(1);
  }
  std::strncpy(last_message.data(), text, message_size - 1);
  std::longjmp(*way_back, 1);
}

void on_warning(const char* text) {
  if (way_back != nullptr) return;  // the data record the warning
  if (warnings_before != nullptr) return warnings_before(text);
  std::fprintf(stderr, "%s\n", text);
}

/// Installs the handlers once per process. MuJoCo's own handler would write MUJOCO_LOG.TXT.
void take_over_messages() {
  static const bool done = [] {
    errors_before = mju_user_error;
    warnings_before = mju_user_warning;
    mju_user_error = c_callback<on_error>;
    mju_user_warning = c_callback<on_warning>;
    return true;
  }();
  (void)done;
}

/// Whether a call of C functions completed. It must not wrap mj_loadXML, whose reader and compiler
/// are C++: a jump over their frames would leak their objects. mj_loadXML catches its own errors
/// and returns them as text.
template <class Call>
bool came_back(const Call& call) noexcept {
  std::jmp_buf here;
  std::jmp_buf* const outer = way_back;
  if (setjmp(here) != 0) {  // NOLINT: the one way out of MuJoCo, over C frames alone
    way_back = outer;
    return false;
  }
  way_back = &here;
  call();
  way_back = outer;
  return true;
}

constexpr std::array fatal = {mjWARN_INERTIA, mjWARN_CONTACTFULL, mjWARN_CNSTRFULL,
                              mjWARN_BADQPOS, mjWARN_BADQVEL,     mjWARN_BADQACC};

/// Files in memory, which MuJoCo reads before those on disk.
class Files {
 public:
  Files() : vfs_(std::make_unique<mjVFS>()) { mj_defaultVFS(vfs_.get()); }
  ~Files() { mj_deleteVFS(vfs_.get()); }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;

  void add(const std::string& name, const std::string& text) {
    const auto bytes = static_cast<int>(text.size());
    if (mj_makeEmptyFileVFS(vfs_.get(), name.c_str(), bytes) != 0)
      throw std::invalid_argument("MuJoCo has no place for the file " + name);
    const int i = mj_findFileVFS(vfs_.get(), name.c_str());
    std::copy(text.begin(), text.end(), static_cast<char*>(vfs_->filedata[i]));
  }
  const mjVFS* get() const { return vfs_.get(); }

 private:
  std::unique_ptr<mjVFS> vfs_;
};

}  // namespace

ModelPointer load(const std::string& mjcf, const ModelFile* beside) {
  take_over_messages();
  static std::mutex one_at_a_time;  // MuJoCo's compiler keeps the last model in a global
  const std::lock_guard lock(one_at_a_time);
  Files files;
  const std::string own = "made of the team.xml";
  files.add(own, mjcf);
  if (beside != nullptr) files.add(std::filesystem::path(beside->name).filename(), beside->text);
  const std::string path = beside != nullptr ? (beside->folder / own).string() : own;
  std::array<char, message_size> error{};
  mjModel* const made = mj_loadXML(path.c_str(), files.get(), error.data(), message_size);
  if (made == nullptr) throw std::invalid_argument(on_one_line(error.data()));
  return ModelPointer(made);
}

DataPointer data_of(const mjModel& model) {
  mjData* made = nullptr;
  if (!came_back([&] { made = mj_makeData(&model); }) || made == nullptr)
    throw std::invalid_argument("MuJoCo has no memory for the model: " + on_one_line(last_error()));
  return DataPointer(made);
}

bool step_1(const mjModel& model, mjData& data) noexcept {
  return came_back([&] { mj_step1(&model, &data); });
}

bool step_2(const mjModel& model, mjData& data) noexcept {
  return came_back([&] { mj_step2(&model, &data); });
}

bool find_contacts(const mjModel& model, mjData& data) noexcept {
  return came_back([&] { mj_fwdPosition(&model, &data); });
}

bool tried(void (*calls)(void*), void* argument) noexcept {
  return came_back([&] { calls(argument); });
}

const char* last_error() noexcept { return last_message.data(); }

const char* warning(const mjData& data) noexcept {
  for (const int kind : fatal) {
    const mjWarningStat& reported = data.warning[kind];
    if (reported.number > 0) return mju_warningText(kind, reported.lastinfo);
  }
  return nullptr;
}

std::string on_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

}  // namespace sightline::mujoco
