#include "sightline/analysis/identification/model_family.hpp"

namespace sightline {

std::string ModelStructure::name() const {
  const bool tilts = commands == Commands::tilt;
  std::string text = tilts ? "(24)" : "lags";
  if (delay) text += " + delay";
  if (coriolis) text += " + Coriolis";
  if (lags && tilts) text += " + lags";
  return text;
}

std::vector<ModelStructure> model_structures(Commands commands) {
  std::vector<ModelStructure> all;
  for (const bool lags : {false, true}) {
    if (commands == Commands::velocity && !lags) continue;
    for (const bool coriolis : {false, true}) {
      for (const bool delay : {false, true}) all.push_back({commands, delay, coriolis, lags});
    }
  }
  return all;
}

std::vector<FittedNumber> fitted_numbers(const ModelStructure& structure) {
  using N = ModelNumbers;
  std::vector<FittedNumber> all;
  if (structure.commands == Commands::tilt) {
    all = {{"b_z", "m/s", &N::b_z, -20, 20, 2, "climb per command"},
           {"b_psi", "rad/s", &N::b_psi, -20, 20, 3, "yaw rate per command"},
           {"a_f", "1/s", &N::a_f, -10, 2, 0, "forward drag"},
           {"b_f", "m/s^2", &N::b_f, -50, 50, 0, "forward acceleration per command"},
           {"a_s", "1/s", &N::a_s, -10, 2, 1, "sideward drag"},
           {"b_s", "m/s^2", &N::b_s, -50, 50, 1, "sideward acceleration per command"}};
    if (structure.lags) all.push_back({"tau", "s", &N::tau, 0.005, 1, 4, "lag of the tilt"});
  } else {
    all = {{"tau_f", "s", &N::tau_f, 0.05, 5, 0, "lag of the forward velocity"},
           {"tau_s", "s", &N::tau_s, 0.05, 5, 1, "lag of the sideward velocity"}};
  }
  if (structure.lags) {
    all.push_back({"tau_z", "s", &N::tau_z, 0.005, 2, 2, "lag of the climb"});
    all.push_back({"tau_psi", "s", &N::tau_psi, 0.005, 2, 3, "lag of the yaw rate"});
  }
  if (structure.delay) all.push_back({"delay", "s", &N::delay, 0, 0.5, 4, "of the commands"});
  all.push_back({"w_x", "m/s^2", &N::w_x, -5, 5, 4, "wind of this flight, along x of G", true});
  all.push_back({"w_y", "m/s^2", &N::w_y, -5, 5, 4, "wind of this flight, along y of G", true});
  return all;
}

}  // namespace sightline
