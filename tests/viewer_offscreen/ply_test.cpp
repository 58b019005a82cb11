// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/ply.h"

#include <catch2/catch.hpp>
#include <string>

#include "core/base/error.h"

namespace covey::viewer {
namespace {

Mesh tetrahedron() {
  Mesh mesh;
  mesh.vertices = {{0.1F, 0.0F, 1e-7F}, {1.0F / 3.0F, 0.0F, 0.0F}, {0.0F, 1e6F, 0.0F}, {0.0F, 0.0F, -2.5F}};
  mesh.colours = {{255, 0, 1}, {2, 3, 4}, {9, 128, 200}, {0, 0, 0}};
  mesh.labels = {0, 7, 300, kNoLabel};
  mesh.faces = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  return mesh;
}

void check_equal(const Mesh& a, const Mesh& b) {
  CHECK(a.vertices == b.vertices);
  CHECK(a.colours == b.colours);
  CHECK(a.labels == b.labels);
  CHECK(a.faces == b.faces);
}

// vertex lines, then face lines, of an ascii file with x y z and vertex_indices.
std::string ascii(const std::string& vertices, int vertex_count, const std::string& faces, int face_count) {
  return "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex " + std::to_string(vertex_count) +
         "\nproperty float x\nproperty double y\nproperty float z\nelement face " +
         std::to_string(face_count) + "\nproperty list uchar int vertex_indices\nend_header\n" + vertices +
         faces;
}

const std::string kTriangle = "0 0 0\n1 0 0\n0 1 0\n";

std::string refusal(const std::string& bytes) {
  try {
    parse_ply(bytes, "m.ply");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST_CASE("a mesh comes back from its file bit by bit") {
  for (const PlyFormat format : {PlyFormat::kAscii, PlyFormat::kBinary}) {
    Mesh mesh = tetrahedron();
    check_equal(parse_ply(format_ply(mesh, format), "m.ply"), mesh);
    mesh.labels.clear();
    check_equal(parse_ply(format_ply(mesh, format), "m.ply"), mesh);
    mesh.colours.clear();
    check_equal(parse_ply(format_ply(mesh, format), "m.ply"), mesh);
    check_equal(parse_ply(format_ply({}, format), "m.ply"), {});
  }
}

TEST_CASE("polygons become fans, other elements and properties are read over") {
  const Mesh mesh = parse_ply(
      "ply\r\nformat ascii 1.0\r\nelement camera 1\r\nproperty list uint8 float32 k\r\nelement vertex 4\r\n"
      "property float x\r\nproperty float nx\r\nproperty float y\r\nproperty float z\r\nproperty int "
      "label\r\n"
      "element face 1\r\nproperty uchar flags\r\nproperty list uchar uint vertex_index\r\nend_header\r\n"
      "3 1 2 3\r\n0 9 0 0 1\r\n1 9 0 0 2\r\n1 9 1 0 3\r\n0 9 1 0 4\r\n5 4 0 1 2 3\r\n",
      "m.ply");
  REQUIRE(mesh.vertices.size() == 4);
  CHECK(mesh.vertices[2] == Eigen::Vector3f(1.0F, 1.0F, 0.0F));
  CHECK(mesh.labels == std::vector<std::uint16_t>{1, 2, 3, 4});
  CHECK(mesh.faces == std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}});
}

TEST_CASE("a refused ascii file is named with its line") {
  CHECK(refusal("") == "m.ply:1: the file ends early");
  CHECK(refusal("solid\n") == "m.ply:1: not a PLY file (its first line is not 'ply')");
  CHECK(refusal("ply\nformat binary_big_endian 1.0\n") ==
        "m.ply:2: format 'binary_big_endian' is not ascii or binary_little_endian");
  CHECK(refusal("ply\nend_header\n") == "m.ply:2: the header has no format line");
  CHECK(refusal("ply\nformat ascii 1.0\nelement vertex -1\n") ==
        "m.ply:3: element 'vertex': '-1' is not a count");
  CHECK(refusal(ascii("0 0 0\n1 x 0\n0 1 0\n", 3, "", 0)) == "m.ply:12: property 'y': 'x' is not a number");
  CHECK(refusal(ascii("0 0 0\n1 0\n0 1 0\n", 3, "", 0)) == "m.ply:12: property 'z' is missing");
  CHECK(refusal(ascii("0 0 0 5\n", 1, "", 0)) == "m.ply:11: more values than the header has properties");
  CHECK(refusal(ascii("0 nan 0\n", 1, "", 0)) == "m.ply:11: vertex 0 is not finite");
  CHECK(refusal(ascii(kTriangle, 3, "3 0 1 3\n", 1)) ==
        "m.ply:14: property 'vertex_indices': 3 is not an integer in [0, 2]");
  CHECK(refusal(ascii(kTriangle, 3, "2 0 1\n", 1)) == "m.ply:14: a face of 2 corners");
  CHECK(refusal(ascii(kTriangle, 3, "", 1)) ==
        "m.ply:13: a count of 1 for element 'face' cannot stand in 0 bytes");
  CHECK(refusal(ascii(kTriangle, 3, "3 0 1 2\n7\n", 1)) ==
        "m.ply:14: the file goes on after its last element");
}

TEST_CASE("a binary file cut anywhere, or with a forged count, is refused with its byte") {
  const std::string whole = format_ply(tetrahedron(), PlyFormat::kBinary);
  const std::size_t body = whole.find("end_header\n") + 11;
  for (std::size_t length = body; length < whole.size(); ++length) {
    CHECK_THAT(refusal(whole.substr(0, length)), Catch::Matchers::StartsWith("m.ply: byte "));
  }
  CHECK_THAT(refusal(whole + "x"), Catch::Matchers::EndsWith("the file goes on after its last element"));
  std::string forged = whole;
  forged.replace(forged.find("vertex 4"), 8, "vertex 4000000000");
  CHECK_THAT(refusal(forged), Catch::Matchers::Contains("cannot stand in"));
}

}  // namespace
}  // namespace covey::viewer
