/// Solver of one part of a team whose other parts run elsewhere: each update uses the latest
/// received predictions and sends the predictions of its own robots. docs/partition.md
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "sightline/solvers.hpp"

namespace sightline {

/// Transport of predictions between parts. Runs on the flight thread: never throws, allocates,
/// locks or prints.
class PartExchange : public Connectivity {
 public:
  /// Passes the messages of other parts received by t [s] to `receiver`, and removes predictions
  /// that are too old.
  virtual void receive(double t, Subteam& receiver) noexcept = 0;
  /// Sends the predictions of the own robots from t [s] on.
  virtual void send(double t, std::span<const Prediction> predictions) noexcept = 0;

 protected:
  ~PartExchange() = default;
};

/// Solver of a team in which it plans all robots; other bodies may be robots of other parts.
class PartSolver final : public Solver {
 public:
  /// @param exchange  must outlive the object
  /// @throws std::invalid_argument as Subteam does
  PartSolver(const Team& team, const MakeSolver& make, PartExchange& exchange);

  std::string_view name() const override { return subteam_.solver().name(); }
  const Ocp& ocp() const override { return subteam_.ocp(); }
  Solution solve(double time, std::span<const double> states) noexcept override;
  void set_applied(const AppliedInputs& applied) noexcept override { subteam_.set_applied(applied); }
  double kkt(double time, std::span<const double> states) noexcept override {
    return subteam_.kkt(time, states);
  }
  void planned(double time, std::span<double> u) const noexcept override { subteam_.planned(time, u); }
  void restart() noexcept override { subteam_.restart(); }
  const Connectivity* connectivity() const noexcept override { return &exchange_; }
  bool keeps_apart() const noexcept override { return subteam_.solver().keeps_apart(); }
  KernelUse kernels() const override { return subteam_.solver().kernels(); }

 private:
  Subteam subteam_;
  PartExchange& exchange_;
};

}  // namespace sightline
