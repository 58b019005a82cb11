// SPDX-License-Identifier: BSD-3-Clause
#include "procs/dpgo/options.h"

#include "core/pgo/chi_square.h"
#include "procs/common/read_seconds.h"

namespace covey {

pgo::AgentOptions read_agent_options(ConfigSection& section) {
  pgo::AgentOptions options;
  pgo::DgncOptions& dgnc = options.dgnc;
  if (section.has("probability") && section.has("barc2")) {
    throw_input_error("{}: give barc2 or probability, not both", section.where("probability"));
  }
  double probability = 0.99;
  section.read("probability", probability, 0.01, 0.999999);
  dgnc.barc2 = pgo::chi_square_quantile(probability, pgo::pose_degrees_of_freedom(3));
  section.read("barc2", dgnc.barc2, 1e-6, 1e12);
  section.read("rank", dgnc.rank, 3, 10);
  section.read("updates", dgnc.updates, 1, 1000);
  section.read("final_updates", dgnc.final_updates, 1, 1000);
  section.read("mu_step", dgnc.mu_step, 1.01, 100.0);
  section.read("tolerance", dgnc.tolerance, 0.0, 0.5);
  section.read("final_tolerance", dgnc.final_tolerance, 0.0, 0.5);
  section.read("momentum", dgnc.momentum);
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
