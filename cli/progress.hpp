/// How far a command is, on stderr.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace sightline::cli {

/// Writes a line every now and then, by a thread of its own that may be held up or fail without harm to anybody.
class ProgressThread {
 public:
  /// @param line  what is to be written now, or nothing; asked ten times a second and, with `last`, once at the end;
  ///              it owns what it reads
  explicit ProgressThread(std::function<std::string(bool last)> line);
  ~ProgressThread() { end(); }
  ProgressThread(const ProgressThread&) = delete;
  ProgressThread& operator=(const ProgressThread&) = delete;

  /// Asks for the last line; leaves a thread that is held up behind.
  void end();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

/// One line on a terminal that says how far a run is; silent where stderr is no terminal.
class Progress {
 public:
  /// @param duration  simulated time of the whole run [s]
  explicit Progress(double duration);

  /// All up to this simulated time [s] is done and on disk.
  void show(double simulated) noexcept;
  /// Ends the line, if there is one.
  void end();

 private:
  struct Flight;
  std::shared_ptr<Flight> flight_;
  std::unique_ptr<ProgressThread> thread_;
};

/// How far a campaign is: a line that is written anew on a terminal, and else one every tenth of the runs.
class CampaignProgress {
 public:
  CampaignProgress(std::string name, int runs, int done, int recovered);

  void show(int done, int recovered) noexcept;

 private:
  struct Runs;
  std::shared_ptr<Runs> runs_;
  std::unique_ptr<ProgressThread> thread_;
};

}  // namespace sightline::cli
