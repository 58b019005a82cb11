// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Third-party data that tests can do without. It is looked for in the folder of the environment variable
// COVEY_DATA, else beside the source tree in ../shared/data. A test that wants some begins with
//
//   const auto file = test_data("pose_graphs/intel.g2o");
//   if (!file) return;                                       // the reason has been printed, and ctest shows
//   it as skipped

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace covey {

inline std::optional<std::filesystem::path> test_data(const std::string& name) {
  const char* variable = std::getenv("COVEY_DATA");
  const std::filesystem::path folder =
      variable != nullptr ? std::filesystem::path(variable)
                          : std::filesystem::path(COVEY_SOURCE_DIR).parent_path() / "shared/data";
  if (std::filesystem::exists(folder / name)) return folder / name;
  std::printf("SKIPPED: %s is not in the data folder %s\n", name.c_str(), folder.c_str());
  return std::nullopt;
}

}  // namespace covey
