// SPDX-License-Identifier: BSD-3-Clause
#include "procs/dpgo/options.h"

#include <initializer_list>
#include <string>
#include <utility>

#include "core/base/angle.h"
#include "core/pgo/chi_square.h"
#include "procs/common/read_seconds.h"

namespace covey {
namespace {

template <typename T>
T read_choice(ConfigSection& section, const std::string& key, T value,
              std::initializer_list<std::pair<const char*, T>> choices) {
  std::string word;
  section.read(key, word);
  if (word.empty()) return value;
  std::string known;
  for (const auto& [name, choice] : choices) {
    if (word == name) return choice;
    known += (known.empty() ? "" : " | ") + std::string(name);
  }
  throw_input_error("{}: '{}' is not one of {}", section.where(key), word, known);
}

enum class Covariances { kFull, kScaled, kPaper };

void read_noise(ConfigSection& section, pgo::DgncOptions& dgnc) {
  pgo::NoiseOptions& noise = dgnc.noise;
  const Covariances covariances = read_choice(
      section, "covariances", Covariances::kScaled,
      {{"full", Covariances::kFull}, {"scaled", Covariances::kScaled}, {"paper", Covariances::kPaper}});
  if (covariances == Covariances::kFull && dgnc.solver != pgo::RoundSolver::kElected) {
    throw_input_error("{}: 'full' wants solver: elected", section.where("covariances"));
  }
  dgnc.full_covariances = covariances == Covariances::kFull;
  noise.isotropic = covariances == Covariances::kPaper;
  // Floored odometry counts with its floor to the end where no refinement with the true cost follows: 0.021 m instead of 0.014 m in
  // the demo. So only the full ones have it.
  noise.floored_odometry = covariances == Covariances::kFull;
  section.read("floor_translation_sigma_m", noise.floor_translation_sigma, 0.0, 10.0);
  double floor_rotation_deg = noise.floor_rotation_sigma / kDegree;
  section.read("floor_rotation_sigma_deg", floor_rotation_deg, 0.0, 90.0);
  noise.floor_rotation_sigma = floor_rotation_deg * kDegree;
}

}  // namespace

pgo::AgentOptions read_agent_options(ConfigSection& section) {
  pgo::AgentOptions options;
  pgo::DgncOptions& dgnc = options.dgnc;
  if (section.has("probability") && section.has("barc2")) {
    throw_input_error("{}: give barc2 or probability, not both", section.where("probability"));
  }
  dgnc.solver = read_choice(section, "solver", pgo::RoundSolver::kDgnc,
                            {{"dgnc", pgo::RoundSolver::kDgnc}, {"elected", pgo::RoundSolver::kElected}});
  read_noise(section, dgnc);
  double probability = dgnc.noise.isotropic ? 0.5 : 0.99;
  section.read("probability", probability, 0.01, 0.999999);
  dgnc.barc2 = pgo::chi_square_quantile(probability, pgo::pose_degrees_of_freedom(3));
  section.read("barc2", dgnc.barc2, 1e-6, 1e12);
  section.read("updates", dgnc.updates, 1, 1000);
  section.read("final_updates", dgnc.final_updates, 1, 1000);
  if (section.has("mu_step")) section.read("mu_step", dgnc.mu_step, 1.01, 100.0);
  section.read("tolerance", dgnc.tolerance, 0.0, 0.5);
  section.read("final_tolerance", dgnc.final_tolerance, 0.0, 0.5);
  section.read("look_back", dgnc.look_back, 0, 100);
  section.read("alignment_rotation_sigma_rad", dgnc.alignment.rotation_sigma, 1e-4, 3.0);
  section.read("alignment_translation_sigma_m", dgnc.alignment.translation_sigma, 1e-4, 1e3);
  section.read("alignment_min_inliers", dgnc.alignment.min_inliers, 1, 1000);
  read_seconds(section, "silence_s", options.silence_us, 1.0, 600.0);
  read_seconds(section, "settle_s", options.settle_us, 0.0, 600.0);
  read_seconds(section, "patience_s", options.patience_us, 0.0, 3600.0);
  read_seconds(section, "request_s", options.request_us, 0.05, 60.0);
  read_seconds(section, "stall_s", options.stall_us, 1.0, 3600.0);
  return options;
}

}  // namespace covey
