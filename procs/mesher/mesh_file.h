// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The newest of every block that was said, and all of them as one PLY file, each segment in its own frame O.

#include <compare>
#include <covey/mesh_block_t.hpp>
#include <filesystem>
#include <map>

namespace covey {

class MeshFile {
 public:
  void put(const mesh_block_t& block);
  // Replaces the file as a whole. InputError where it cannot be written.
  void write(const std::filesystem::path& file) const;

 private:
  struct Name {
    std::int64_t segment = 0;
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    auto operator<=>(const Name&) const = default;
  };
  std::map<Name, mesh_block_t> blocks_;
};

}  // namespace covey
