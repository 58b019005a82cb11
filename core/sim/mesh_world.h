// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A simulated world: a labelled, textured triangle mesh in W (z up, metres), made from a seed. Textures are procedural and rich in
// corners at all scales; most things look like nothing else in the world, and some are alike on purpose.
//
// town: a square grid of straight streets on the flat ground z = 0, closed in by houses. Every block holds a house, or is a garden or a
// car park. A third of the houses are of one type, so that places look alike.
// rooms: eight furnished rooms off a corridor, floor z = 0; some are furnished alike, with things and pictures of their own.
// room: a furnished room around the volume in which the EuRoC V1 sequences fly (frame of their ground truth, floor z = 0).
// hall: a machine hall around any flight, such as those of the EuRoC MH sequences.

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "viewer_offscreen/mesh.h"

namespace covey::sim {

// Where one drives, as a graph of straight centre lines on the ground.
struct RoadGraph {
  std::vector<Eigen::Vector2d> junctions_W;
  std::vector<std::array<int, 2>> roads;  // pairs of junctions, first < second
  // Nothing stands within this distance of a centre line, nor on the square of this half side about a junction.
  double clear_half_width_m = 0.0;
};

struct MeshWorld {
  std::string name;
  viewer::Mesh mesh;  // colours: of the texture's mean, for pictures and files
  viewer::Textures textures;
  RoadGraph roads;                               // empty where nobody drives
  std::vector<Eigen::AlignedBox3d> buildings_W;  // what radio and sight do not pass
};

struct TownOptions {
  std::uint64_t seed = 1;
  int blocks = 4;          // along a side; there are (blocks + 1)^2 junctions, (0, 0) at the first
  double block_m = 14.0;   // between junctions
  int texture_side = 512;  // texels; smaller is quicker to make
};

MeshWorld make_town(const TownOptions& options = {});

struct RoomOptions {
  std::uint64_t seed = 1;
  int texture_side = 512;
};

// Nothing but air within 0.5 m of this box.
inline Eigen::AlignedBox3d room_flight_volume() {
  return {Eigen::Vector3d(-2.4, -2.6, 0.75), Eigen::Vector3d(2.3, 3.6, 2.65)};
}
MeshWorld make_room(const RoomOptions& options = {});

struct RoomsOptions {
  std::uint64_t seed = 1;
  int texture_side = 512;
};

// `roads` lead along the corridor and around the middle of each room. Rooms that are furnished alike, in the order of the corridor, north
// then south: 0, 3 and 6; 1 and 4.
MeshWorld make_rooms(const RoomsOptions& options = {});

// Two rooms that are furnished alike, each by a frame on the floor in the middle of its door: y into the room, z up.
struct AlikeRooms {
  Eigen::Isometry3d T_W_A;
  Eigen::Isometry3d T_W_B;
};
std::vector<AlikeRooms> alike_rooms();
Eigen::AlignedBox3d rooms_inside();  // of every room, in its frame

struct HallOptions {
  std::uint64_t seed = 1;
  int texture_side = 512;
  std::vector<Eigen::Vector3d> flown_W;  // places along the flights, close together; at least one
  double clear_m = 0.7;                  // nothing comes nearer to them
};

// The floor is half a metre below the lowest place, walls and ceiling are metres away from all of them. Between them stand machines, tanks,
// racks, crates and pillars, wherever nobody flies, and lower things where somebody flies above.
MeshWorld make_hall(const HallOptions& options);

}  // namespace covey::sim
