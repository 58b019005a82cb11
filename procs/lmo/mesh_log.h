// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What an lmo must not lose with its process, under --state: lmo.lcm, an LCM log of the MESH, KEYFRAME and TRAJECTORY messages
// that it has taken. It grows; when most of it is superseded (blocks that were said again, older rounds), and at each start, it
// is written anew with what still counts. A log whose end was cut off is good up to there.

#include <cstddef>
#include <filesystem>
#include <memory>

#include "core/base/stream.h"
#include "core/mesh/robot_mesh.h"
#include "procs/common/channels.h"
#include "procs/common/log_file.h"

namespace covey {

class MeshLog {
 public:
  // Fills `mesh` with what was kept and leaves the log open for more. InputError where the folder cannot be written.
  MeshLog(std::filesystem::path folder, mesh::RobotMesh& mesh);

  // What the mesh has just taken.
  void append(const mesh_block_t& block, Utime now);
  void append(const keyframe_t& keyframe, Utime now);
  void append(const trajectory_t& part, Utime now);

  // By stream, the number after the last one kept.
  const StreamPositions& blocks() const { return blocks_; }
  const StreamPositions& keyframes() const { return keyframes_; }

 private:
  void read();
  void rewrite(Utime now);
  void write(Utime now, const char* channel, const Bytes& bytes);
  void append(Utime now, const char* channel, const Bytes& bytes);

  std::filesystem::path folder_;
  mesh::RobotMesh& mesh_;
  std::unique_ptr<LogRecorder> log_;
  std::size_t bytes_ = 0;            // in the log
  std::size_t rewritten_bytes_ = 0;  // of them when it was last written anew
  StreamPositions blocks_;
  StreamPositions keyframes_;
  bool said_failed_ = false;
};

}  // namespace covey
