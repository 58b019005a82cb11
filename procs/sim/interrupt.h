// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// SIGINT and SIGTERM end a long run between two images, so that what is half written can be taken away; the second one ends the process at once.

#include <stdexcept>

namespace covey {

class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted; nothing was written") {}
};

void handle_interrupts();
void throw_if_interrupted();

}  // namespace covey
