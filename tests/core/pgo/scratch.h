// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A file or folder of a test's own, gone when the test ends; and the message of the InputError that an action throws
// ("" for none).

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/error.h"

namespace covey {

class ScratchFile {
 public:
  struct Extension {
    std::string text;
  };

  ScratchFile() : ScratchFile(Extension{}) {}
  explicit ScratchFile(const std::string& text) : ScratchFile() { std::ofstream(path) << text; }
  explicit ScratchFile(const Extension& extension) {
    static std::atomic<int> count{0};
    const std::string name = "covey_test_" + std::to_string(getpid()) + "_" + std::to_string(count++);
    path = std::filesystem::temp_directory_path() / (name + extension.text);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  ~ScratchFile() { std::filesystem::remove_all(path); }

  // `text` behind the file's name, as error messages begin.
  std::string said(const std::string& text) const { return path.string() + text; }

  std::filesystem::path path;
};

struct ScratchFolder : ScratchFile {
  ScratchFolder() { std::filesystem::create_directories(path); }
};

template <typename Action>
std::string input_error_of(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

}  // namespace covey
