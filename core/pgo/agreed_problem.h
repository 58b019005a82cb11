// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What the members of a round have agreed on when its opening is over (round_opening.h): who solves together, the loops that
// both ends know, which keyframes are public, and where everybody's start lies in the common frame. Each member holds its own
// graph, and of the others the public keyframes alone. Whatever solves it goes on from here (round_updates.h).
//
// The common frame is that of one start of the part's lowest robot, its anchor. W is the odometry frame of that segment: the
// segment's first keyframe, the root, is where odometry has it in W.

#include <covey/dpgo_join_t.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/pgo/robot_graph.h"
#include "core/pgo/round_message.h"
#include "core/pgo/start_frames.h"

namespace covey::pgo {

// Names the frame W of the part of the team whose anchor is given, as that round leaves it: O of that segment of the
// anchor; never 0. With the segment, since a team that was restarted as a whole counts its rounds from 1 again.
std::int64_t frame_name(const RoundName& name, int anchor, Utime segment);

// Where a segment's poses are when the round begins: in its odometry frame (solution 0), or as an earlier solution left them.
struct SegmentStart {
  std::int64_t solution = 0;
  std::vector<SE3> T_S_K;
};

struct OpenedMember {  // of the round, this robot included
  dpgo_join_t join;
  // Its public keyframes, in the order of dpgo_keyframes_t.
  std::map<std::pair<int, int>, int> places;  // of (place of the segment in the join, id)
  std::vector<int> segments;                  // places in the join
  std::vector<SE3> T_S_K;                     // as sent, in the frames of the segments' starts

  std::vector<SE3> public_poses(int segment) const;
};

struct SharedLoop {
  GraphLoop loop;
  int peer = 0;        // the robot at its other end
  int my_place = 0;    // of the own end among the own public keyframes
  int peer_place = 0;  // of the other end among the peer's
};

struct AgreedProblem {
  RoundName name;
  std::vector<int> part;                // the robots that solve together, ascending
  std::map<int, OpenedMember> members;  // of the whole round
  GraphSnapshot graph;                  // own; without the shared loops that only one end knows
  std::vector<SegmentStart> starts;     // own, by segment
  bool bent = false;                    // starts are where others' loops have moved them (coarse_graph.h)
  std::vector<SharedLoop> ends;         // the loops with others of the part
  std::vector<int> offsets;             // of each own segment's first pose among all own poses
  std::vector<int> public_index;        // of each own public keyframe among all own poses
  StartFrames frames;
  // Frames that one loop alone ties together: nothing contradicts it, so it is a known inlier.
  std::vector<std::pair<StartFrame, StartFrame>> lone_pairs;
  std::vector<std::string> warnings;

  int robot() const { return graph.robot; }
  const OpenedMember& self() const { return members.at(robot()); }

  int segment_place(Utime segment) const;  // among the own segments
  int pose_index(const KeyframeName& own) const { return offsets[segment_place(own.segment)] + own.id; }
  const KeyframeName& own_end(const GraphLoop& loop) const {
    return loop.a.robot == robot() ? loop.a : loop.b;
  }
  const KeyframeName& other_end(const GraphLoop& loop) const {
    return loop.a.robot == robot() ? loop.b : loop.a;
  }
  // Of loops where they are counted once: private ones, and those shared with a higher robot.
  bool owns(const SharedLoop& end) const { return end.peer > robot(); }

  // Starts in the common frame: of the own poses, and of a member's public keyframes as sent. In their own frames where they
  // are not connected.
  std::vector<SE3> own_start() const;
  std::vector<SE3> public_start(int member) const;
  bool placed(int own_segment) const { return frames.pose_of({robot(), own_segment}).has_value(); }

  int anchor() const { return part.front(); }
  int root_place() const;      // among the anchor's public keyframes
  SE3 root_pose() const;       // T_W_root
  std::int64_t world() const;  // name of W
};

}  // namespace covey::pgo
