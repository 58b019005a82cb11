// SPDX-License-Identifier: BSD-3-Clause
// viewer_offscreen: trajectories, loop closures and meshes as PNG, without a screen.

#include <fmt/format.h>

#include <exception>
#include <memory>

#include "core/base/error.h"
#include "viewer_offscreen/command.h"
#include "viewer_offscreen/node.h"

namespace covey::viewer {
namespace {

int watch_buses(const Command& command) {
  std::vector<std::string> arguments = {"viewer_offscreen", "--url", command.watch->urls.front()};
  if (command.watch->robot >= 0)
    arguments.insert(arguments.end(), {"--robot", std::to_string(command.watch->robot)});
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  return run_process(static_cast<int>(argv.size()), argv.data(),
                     {.name = "viewer_offscreen", .summary = "", .serves_robot = false},
                     [&](Process& process) { return std::make_shared<ViewerNode>(process, command); });
}

int draw_files(const Command& command) {
  Renderer renderer;
  write_pictures(renderer, command, command.content);
  return 0;
}

}  // namespace
}  // namespace covey::viewer

int main(int argc, char** argv) {
  using namespace covey::viewer;
  try {
    const Command command = parse_command(argc, argv);
    return command.watch ? watch_buses(command) : draw_files(command);
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
