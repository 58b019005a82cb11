// SPDX-License-Identifier: BSD-3-Clause
#include "procs/mesher/mesh_file.h"

#include <catch2/catch.hpp>

#include "tests/core/pgo/scratch.h"
#include "viewer_offscreen/ply.h"

using namespace covey;

namespace {

mesh_block_t triangle(std::int64_t segment, int x, float height) {
  mesh_block_t block{};
  block.segment = segment;
  block.x = x;
  block.n_vertices = 3;
  block.n_values = 9;
  block.p_O = {0, 0, height, 1, 0, height, 0, 1, height};
  block.colours = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  block.labels = {4, 5, 255};
  block.keyframes = {0, 0, 0};
  block.n_corners = 3;
  block.corners = {0, 1, 2};
  return block;
}

}  // namespace

TEST_CASE("a file has the newest of every block, and empty ones are gone from it") {
  const ScratchFile file;
  MeshFile mesh;
  mesh.put(triangle(1, 0, 1.0F));
  mesh.put(triangle(1, 1, 2.0F));
  mesh.put(triangle(2, 0, 3.0F));
  mesh.put(triangle(1, 0, 4.0F));
  mesh_block_t empty{};
  empty.segment = 1;
  empty.x = 1;
  mesh.put(empty);
  mesh.write(file.path);
  const viewer::Mesh read = viewer::read_ply(file.path);
  REQUIRE(read.vertices.size() == 6);
  REQUIRE(read.faces.size() == 2);
  CHECK(read.vertices[0].z() == 4.0F);
  CHECK(read.vertices[3].z() == 3.0F);
  CHECK(read.faces[1] == std::array<std::uint32_t, 3>{3, 4, 5});
  CHECK(read.labels[4] == 5);
  CHECK(read.labels[5] == 255);
  CHECK(read.colours[2].b == 9);
  CHECK_THAT(input_error_of([&] { mesh.write("/nowhere/mesh.ply"); }), Catch::Contains("/nowhere/mesh.ply"));
}
