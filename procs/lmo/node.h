// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Local mesh optimisation, wired to the robot's bus.
//
//   reads   MESH, KEYFRAME (streams); TRAJECTORY
//   writes  MESH_OPTIMIZED in parts, 50 a second; the files of --mesh; STATUS
//
// A round that came whole starts an optimisation; so does a mesh that has changed since, once it is quiet. What comes in the
// meantime waits for the next: of several rounds only the newest is solved.
//
// STATUS: phase `idle` (all that has come is in the mesh that is out), `waiting` or `solving`; gauges
//   round, solved_round      the newest that came whole, and the one that the mesh in the files is of; 0 before the first
//   blocks, blocks_pending   known; come since the snapshot that the files are of
//   mesh_number              the last number of MESH in the files; -1 before the first
//   vertices, left_out       of the team's mesh; of segments that no round has placed
//   torn                     faces that were left out, between passes
//   nodes, cell_m, iterations, solve_ms, optimisations; parts_pending of MESH_OPTIMIZED, to be published

#include <covey/mesh_optimized_t.hpp>
#include <deque>
#include <optional>

#include "core/mesh/mesh_job.h"
#include "procs/common/process.h"
#include "procs/lmo/mesh_files.h"
#include "procs/lmo/mesh_log.h"
#include "procs/lmo/options.h"

namespace covey {

class LmoNode {
 public:
  LmoNode(Process& process, const std::filesystem::path& mesh_dir);

 private:
  // What of the messages is in the mesh: compared to what has come, it says whether there is work.
  struct Contents {
    Utime round_utime = 0;
    std::int64_t round = 0;
    std::int64_t blocks = 0;  // taken since the start
    std::int32_t mesh_number = -1;
  };

  template <typename T>
  bool take(const char* channel, const T& message);
  void on_mesh(const mesh_block_t& block);
  void on_trajectory(const trajectory_t& part);
  void restore();
  bool is_due() const;
  bool has_news() const;
  void consider();
  void begin();
  void work();
  void finish();
  void publish_next();
  void finish_log();
  void report();

  Process& process_;
  LmoOptions options_;
  mesh::RobotMesh mesh_;
  std::optional<MeshLog> log_;
  std::optional<MeshFiles> files_;
  Contents known_;
  Contents solving_;
  Contents solved_;
  Utime changed_us_ = 0;  // when the last block came, and the first since the last optimisation
  Utime first_changed_us_ = 0;
  Utime begun_us_ = 0;
  std::optional<mesh::MeshJob> job_;
  std::deque<mesh_optimized_t> outgoing_;
  int optimisations_ = 0;
};

}  // namespace covey
