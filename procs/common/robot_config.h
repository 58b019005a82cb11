// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A robot's processes share one configuration file, and its programs one set of sections: each reads its own and
// leaves the others' alone. A section that is nobody's is a mistake, which check_all_read() refuses.

#include <filesystem>
#include <string>

#include "core/base/config.h"
#include "core/geometry/rig.h"

namespace covey {

// Of the program whose section is `program`; an empty configuration where `file` is empty. Throws InputError.
Config load_robot_config(const std::filesystem::path& file, const std::string& program);

// The rig that the file's key `sensors` names. Throws InputError.
Rig load_robot_rig(const std::filesystem::path& file);

}  // namespace covey
