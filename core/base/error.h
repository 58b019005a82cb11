// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The three tiers of things that go wrong, and what each becomes:
//  - A mistake of the user's (command line, configuration, an input file at start-up): throw InputError with one
//    sentence that names the file, line, key or channel and says what to do. main() prints it and exits with 2.
//  - Bad data at run time (a message, a packet, a log event): never an exception across a handler; it is counted with
//    its reason and dropped.
//  - A mistake of ours: COVEY_CHECK, which ends the process with the condition and the place.

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <utility>

namespace covey {

class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <typename... Args>
[[noreturn]] void throw_input_error(fmt::format_string<Args...> format, Args&&... args) {
  throw InputError(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace covey

#define COVEY_CHECK(condition)                                                                           \
  do {                                                                                                   \
    if (!(condition)) {                                                                                  \
      std::fprintf(stderr, "%s:%d: internal error: %s does not hold\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                                      \
    }                                                                                                    \
  } while (false)
