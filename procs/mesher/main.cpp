// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "procs/common/process.h"
#include "procs/mesher/node.h"

int main(int argc, char** argv) {
  covey::MesherOptions options;
  const covey::ProcessOptions process_options{
      .name = "mesher",
      .summary = "depth images and odometry in, the changed blocks of a labelled mesh out",
      .reads_depth = true,
      .add_options = [&options](CLI::App& app) {
        app.add_option("--ply", options.ply, "write the whole mesh to this file at the end, in frame O");
      }};
  return covey::run_process(argc, argv, process_options, [&options](covey::Process& process) {
    return std::make_unique<covey::MesherNode>(process, options);
  });
}
