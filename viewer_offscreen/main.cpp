// SPDX-License-Identifier: BSD-3-Clause
// viewer_offscreen: trajectories, loop closures and meshes as PNG, without a screen.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>

#include "core/base/error.h"
#include "viewer_offscreen/command.h"
#include "viewer_offscreen/png.h"

int main(int argc, char** argv) {
  using namespace covey::viewer;
  try {
    const Command command = parse_command(argc, argv);
    Renderer renderer;
    for (const Picture& picture : command.pictures) {
      write_png(picture.file, draw_figure(renderer, command.content, picture.view, command.options));
    }
    return 0;
  } catch (const CommandDone& done) {
    return done.exit_code;
  } catch (const covey::InputError& error) {
    fmt::print(stderr, "viewer_offscreen: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "viewer_offscreen: {}\n", error.what());
    return 1;
  }
}
