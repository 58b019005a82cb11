// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/mesh_schedule.h"

#include <algorithm>

namespace covey::mesh {

void MeshSchedule::on_changed(const std::vector<BlockIndex>& blocks, Utime now) {
  now_ = std::max(now_, now);
  for (const BlockIndex& index : blocks) {
    Waiting& waiting = waiting_.try_emplace(index, Waiting{now, now, 0}).first->second;
    waiting.newest = now;
    ++waiting.changes;
  }
}

bool MeshSchedule::is_due(const BlockIndex& index, const Waiting& waiting, Utime now) const {
  if (now - waiting.newest >= from_seconds(options_.idle_s)) return true;
  const auto said = said_.find(index);
  if (said == said_.end()) return now - waiting.since >= from_seconds(options_.period_s);
  return waiting.changes >= said->second.changes &&
         now - said->second.when >= from_seconds(options_.period_s);
}

void MeshSchedule::note_said(const BlockIndex& index, const Waiting& waiting) {
  Said& said = said_[index];
  said.when = now_;
  said.changes += waiting.changes;
}

std::vector<BlockIndex> MeshSchedule::take_due(Utime now) {
  now_ = std::max(now_, now);
  std::vector<BlockIndex> due;
  for (auto entry = waiting_.begin(); entry != waiting_.end();) {
    if (!is_due(entry->first, entry->second, now_)) {
      ++entry;
      continue;
    }
    due.push_back(entry->first);
    note_said(entry->first, entry->second);
    entry = waiting_.erase(entry);
  }
  return due;
}

std::vector<BlockIndex> MeshSchedule::take_all() {
  std::vector<BlockIndex> all;
  all.reserve(waiting_.size());
  for (const auto& [index, waiting] : waiting_) {
    all.push_back(index);
    note_said(index, waiting);
  }
  waiting_.clear();
  return all;
}

}  // namespace covey::mesh
