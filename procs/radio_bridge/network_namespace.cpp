// SPDX-License-Identifier: BSD-3-Clause
#include "procs/radio_bridge/network_namespace.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/base/error.h"

namespace covey {
namespace {

struct File {
  explicit File(const std::string& path) : fd(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~File() {
    if (fd >= 0) close(fd);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int fd;
};

bool same_file(const std::string& left, const std::string& right) {
  struct stat a {};
  struct stat b {};
  return stat(left.c_str(), &a) == 0 && stat(right.c_str(), &b) == 0 && a.st_dev == b.st_dev &&
         a.st_ino == b.st_ino;
}

}  // namespace

void enter_network_namespace(const std::string& path) {
  const std::string user_path = (std::filesystem::path(path).parent_path() / "user").string();
  // Both are opened before either is entered: from inside the user namespace the path may not be readable.
  const File network(path);
  if (network.fd < 0) throw_input_error("--netns {}: {}", path, std::strerror(errno));
  const File user(user_path);
  if (user.fd >= 0 && !same_file(user_path, "/proc/self/ns/user") && setns(user.fd, CLONE_NEWUSER) != 0) {
    throw_input_error("--netns {}: the user namespace {} cannot be entered: {}", path, user_path,
                      std::strerror(errno));
  }
  if (setns(network.fd, CLONE_NEWNET) != 0) {
    throw_input_error("--netns {}: cannot be entered: {}", path, std::strerror(errno));
  }
}

}  // namespace covey
