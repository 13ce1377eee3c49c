/// Progress of a command, on stderr.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace sightline::cli {

/// Writes a line at intervals from a detached thread, which may block or fail without effect on
/// other threads.
class ProgressThread {
 public:
  /// @param line  returns the next text, or an empty one; called ten times a second and, with
  ///   `last`, once at the end; it owns the data it reads
  explicit ProgressThread(std::function<std::string(bool last)> line);
  ~ProgressThread() { end(); }
  ProgressThread(const ProgressThread&) = delete;
  ProgressThread& operator=(const ProgressThread&) = delete;

  /// Requests the last line; a blocked thread is left behind.
  void end();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

/// One line on a terminal with the progress of a run; silent if stderr is no terminal.
class Progress {
 public:
  /// @param duration  simulated time of the whole run [s]
  explicit Progress(double duration);

  /// Shows that all periods up to this simulated time [s] are done and on disk.
  void show(double simulated) noexcept;
  /// Ends the line, if one was written.
  void end();

 private:
  struct Flight;
  std::shared_ptr<Flight> flight_;
  std::unique_ptr<ProgressThread> thread_;
};

/// Progress of a campaign: one line, rewritten on a terminal; otherwise one line per tenth of the
/// runs.
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
