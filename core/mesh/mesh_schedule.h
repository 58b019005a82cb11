// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// When to say which block. A block in view changes with every image, and ever less: distances are running means. So it is said
// `period_s` after its first change, and then when it has changed as often again as before it was said, at most once in `period_s`; and at
// last when it has not changed for `idle_s`, having left the view. A block that is watched for ten seconds at 5 Hz is said five times or
// so. Time is that of the images.

#include <map>
#include <vector>

#include "core/base/time.h"
#include "core/mesh/block.h"

namespace covey::mesh {

struct ScheduleOptions {
  double period_s = 1.5;
  double idle_s = 1.0;
};

class MeshSchedule {
 public:
  explicit MeshSchedule(const ScheduleOptions& options = {}) : options_(options) {}

  void on_changed(const std::vector<BlockIndex>& blocks, Utime now);
  // In the order of their indices; they are as said then.
  std::vector<BlockIndex> take_due(Utime now);
  std::vector<BlockIndex> take_all();

  std::size_t waiting() const { return waiting_.size(); }

 private:
  struct Waiting {
    Utime since = 0;   // first change that was not said
    Utime newest = 0;  // change
    int changes = 0;
  };
  struct Said {
    Utime when = 0;
    int changes = 0;  // until then
  };

  bool is_due(const BlockIndex& index, const Waiting& waiting, Utime now) const;
  void note_said(const BlockIndex& index, const Waiting& waiting);

  ScheduleOptions options_;
  std::map<BlockIndex, Waiting> waiting_;
  std::map<BlockIndex, Said> said_;
  Utime now_ = 0;
};

}  // namespace covey::mesh
