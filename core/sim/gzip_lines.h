// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The lines of a text file, gzipped or not.

#include <filesystem>
#include <functional>
#include <string>

namespace covey::sim {

// Calls `line` with each line, without its end, and its number from 1. InputError where the file cannot be opened or is torn.
void read_lines(const std::filesystem::path& file, const std::function<void(const std::string&, int)>& line);

}  // namespace covey::sim
