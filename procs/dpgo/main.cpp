// SPDX-License-Identifier: BSD-3-Clause
#include "procs/dpgo/node.h"

int main(int argc, char** argv) {
  return covey::run_process(
      argc, argv,
      {.name = "dpgo", .summary = "distributed graduated non-convexity over block-coordinate descent"},
      [](covey::Process& process) { return std::make_shared<covey::DpgoNode>(process); });
}
