// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "core/base/config.h"
#include "core/mesh/deformation.h"

namespace covey {

struct LmoOptions {
  mesh::DeformationOptions deformation;
  // After the mesh alone has changed: once nothing has come for so long, or once so long has gone by. A round is not waited for.
  Utime settle_us = 2'000'000;
  Utime patience_us = 15'000'000;
  std::filesystem::path mesh_dir;  // --mesh; no files where empty
};

// Section `lmo` of the configuration; procs/lmo/README.md explains the keys.
LmoOptions read_lmo_options(ConfigSection& section);

}  // namespace covey
