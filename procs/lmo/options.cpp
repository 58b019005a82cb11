// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lmo/options.h"

#include "procs/common/read_seconds.h"

namespace covey {

LmoOptions read_lmo_options(ConfigSection& section) {
  LmoOptions options;
  mesh::DeformationOptions& deformation = options.deformation;
  section.read("cell_m", deformation.simplify.min_cell_m, 0.01, 100.0);
  section.read("max_nodes", deformation.simplify.max_nodes, 10, 100'000);
  read_seconds(section, "pass_s", deformation.simplify.pass_us, 0.1, 1e6);
  section.read("neighbours", deformation.neighbours, 1, 20);
  section.read("keyframe_sigma_m", deformation.keyframe_sigma_m, 1e-6, 10.0);
  section.read("keyframe_sigma_rad", deformation.keyframe_sigma_rad, 1e-6, 10.0);
  section.read("edge_sigma_m", deformation.edge_sigma_m, 1e-6, 1e3);
  section.read("sighting_sigma_m", deformation.sighting_sigma_m, 1e-6, 1e3);
  section.read("max_iterations", deformation.max_iterations, 1, 1000);
  read_seconds(section, "settle_s", options.settle_us, 0.0, 600.0);
  read_seconds(section, "patience_s", options.patience_us, 0.1, 3600.0);
  return options;
}

}  // namespace covey
