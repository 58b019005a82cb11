// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/agreed_problem.h"

#include <algorithm>

#include "core/pgo/hash.h"
#include "core/pgo/public_poses.h"

namespace covey::pgo {

std::int64_t frame_name(const RoundName& name, int anchor, Utime segment) {
  Hash hash;
  hash.add(static_cast<std::uint64_t>(name.number));
  hash.add(static_cast<std::uint64_t>(name.anchor));
  hash.add(static_cast<std::uint64_t>(anchor));
  hash.add(static_cast<std::uint64_t>(segment));
  return static_cast<std::int64_t>(hash.value() | 1U);  // 0 means none
}

std::vector<SE3> OpenedMember::public_poses(int segment) const {
  std::vector<SE3> poses;
  for (std::size_t k = 0; k < T_S_K.size(); ++k) {
    if (segments[k] == segment) poses.push_back(T_S_K[k]);
  }
  return poses;
}

int AgreedProblem::segment_place(Utime segment) const {
  const auto found = std::find_if(graph.segments.begin(), graph.segments.end(),
                                  [segment](const Segment& s) { return s.name == segment; });
  return found == graph.segments.end() ? -1 : static_cast<int>(found - graph.segments.begin());
}

std::vector<SE3> AgreedProblem::own_start() const {
  std::vector<SE3> poses;
  for (std::size_t s = 0; s < starts.size(); ++s) {
    const SE3 T = frames.pose_of({robot(), static_cast<int>(s)}).value_or(SE3{});
    for (const SE3& T_S_K : starts[s].T_S_K) poses.push_back(T * T_S_K);
  }
  return poses;
}

std::vector<SE3> AgreedProblem::public_start(int member) const {
  const OpenedMember& opened = members.at(member);
  std::vector<SE3> poses;
  for (std::size_t k = 0; k < opened.T_S_K.size(); ++k) {
    poses.push_back(frames.pose_of({member, opened.segments[k]}).value_or(SE3{}) * opened.T_S_K[k]);
  }
  return poses;
}

int AgreedProblem::root_place() const { return members.at(anchor()).places.at({frames.root().segment, 0}); }

SE3 AgreedProblem::root_pose() const {
  return pose_at(members.at(anchor()).join.T_O_K, frames.root().segment);
}

std::int64_t AgreedProblem::world() const {
  return frame_name(name, anchor(), members.at(anchor()).join.segments[frames.root().segment]);
}

}  // namespace covey::pgo
