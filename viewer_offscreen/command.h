// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The command line of viewer_offscreen, read together with the files that it names.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"

#include "viewer_offscreen/figure.h"

namespace covey::viewer {

struct Picture {
  std::filesystem::path file;
  View view = View::kTop;
};

// What is drawn again and again, beside the files' content: what robots say on their buses.
struct Watch {
  std::vector<std::string> urls;
  int robot = -1;  // the first --robot
  Utime every_us = 0;
};

struct Command {
  FigureContent content;
  FigureOptions options;
  std::vector<Picture> pictures;
  std::optional<Watch> watch;
};

// --help was asked for (0), or the arguments are wrong (2); the text has been printed.
struct CommandDone {
  int exit_code = 0;
};

// Throws CommandDone; InputError where an argument's content or a file is refused.
Command parse_command(int argc, const char* const* argv);

// COVEY_CHECK: has_content(content). Replaces each file as a whole; InputError where one cannot be written.
void write_pictures(Renderer& renderer, const Command& command, const FigureContent& content);

}  // namespace covey::viewer
