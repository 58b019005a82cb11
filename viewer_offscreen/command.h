// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The command line of viewer_offscreen, read together with the files that it names.

#include <filesystem>
#include <vector>

#include "viewer_offscreen/figure.h"

namespace covey::viewer {

struct Picture {
  std::filesystem::path file;
  View view = View::kTop;
};

struct Command {
  FigureContent content;
  FigureOptions options;
  std::vector<Picture> pictures;
};

// --help was asked for (0), or the arguments are wrong (2); the text has been printed.
struct CommandDone {
  int exit_code = 0;
};

// Throws CommandDone; InputError where an argument's content or a file is refused.
Command parse_command(int argc, const char* const* argv);

}  // namespace covey::viewer
