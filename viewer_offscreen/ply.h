// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Polygon files (PLY 1.0; G. Turk, "The PLY Polygon File Format", 1994), ascii and binary_little_endian.
//   vertex: x y z (any number type), optionally red green blue (uchar) and label (any integer type, 0 to
//   65535); face: one list, vertex_indices or vertex_index; polygons are cut into fans of triangles.
// Other elements and properties are read over. Written files have exactly the properties that the mesh has.
// What is refused: big-endian files, vertices that are not finite, indices and labels out of range, files
// that end early or go on after their last element. InputError names the file and the line (header and ascii)
// or byte (binary).

#include <filesystem>
#include <string>
#include <string_view>

#include "viewer_offscreen/mesh.h"

namespace covey::viewer {

enum class PlyFormat { kAscii, kBinary };

Mesh read_ply(const std::filesystem::path& file);
Mesh parse_ply(std::string_view bytes, const std::string& name);

std::string format_ply(const Mesh& mesh, PlyFormat format = PlyFormat::kBinary);
void write_ply(const std::filesystem::path& file, const Mesh& mesh, PlyFormat format = PlyFormat::kBinary);

}  // namespace covey::viewer
