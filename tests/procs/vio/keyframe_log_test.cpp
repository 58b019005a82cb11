// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/keyframe_log.h"

#include <catch2/catch.hpp>

#include "tests/core/pgo/scratch.h"

using namespace covey;

namespace {

struct Folder : ScratchFile {
  Folder() { std::filesystem::create_directories(path); }
};

keyframe_t keyframe(Utime segment, int id) {
  keyframe_t message{};
  message.utime = segment + id;
  message.segment = segment;
  message.id = id;
  return message;
}

}  // namespace

TEST_CASE("keyframes that were said are read back, over several starts") {
  const Folder folder;
  {
    KeyframeLog log(folder.path);
    CHECK(log.restored().empty());
    for (int id = 0; id < 3; ++id) log.append(keyframe(100, id), 1000 + id);
  }
  {
    KeyframeLog log(folder.path);
    REQUIRE(log.restored().size() == 3);
    CHECK(log.restored().back().id == 2);
    CHECK(log.knows(keyframe(100, 2)));
    CHECK_FALSE(log.knows(keyframe(100, 3)));
    CHECK_FALSE(log.knows(keyframe(200, 0)));
    log.append(keyframe(200, 0), 2000);
  }
  CHECK(KeyframeLog(folder.path).restored().size() == 4);
}

TEST_CASE("a keyframe log with a torn end, or of something else, does not keep vio from starting") {
  const Folder folder;
  {
    KeyframeLog log(folder.path);
    for (int id = 0; id < 3; ++id) log.append(keyframe(100, id), 1000 + id);
  }
  const auto file = folder.path / "vio_keyframes.lcm";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 20);
  CHECK(KeyframeLog(folder.path).restored().size() == 2);
  std::ofstream(file) << "not a log";
  CHECK(KeyframeLog(folder.path).restored().empty());
}
