// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Robots that drive along one street of made-up landmarks, their lcd agents, and the air between them, in virtual time.

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/place/lcd_agent.h"
#include "tests/simnet/lcd_air.h"

namespace covey::place {

inline constexpr Utime kSecond = kUsPerSecond;
inline constexpr int kKeyframes = 30;
inline constexpr Utime kKeyframeUs = kSecond / 2;

std::shared_ptr<const Vocabulary> street_vocabulary();

struct Seen {
  KeyframeName name;
  Utime utime;
  SE3 T_W_B;
  FrameFeatures features;
};

// Every robot drives along the street, one after the other and a bit beside the others; it has its own odometry frame.
struct Drive {
  int keyframes = kKeyframes;  // 0.8 m apart
  double from_m = 0.0;
  int new_segment_at = -1;  // keyframe at which odometry starts anew; -1: none
};
std::vector<Seen> drive(int robot, const Drive& drive);

class Team {
 public:
  Team(int robots, LinkFaults faults, std::uint64_t seed = 1);
  Team(std::unique_ptr<Air> air, const std::vector<Drive>& drives, const LcdOptions& options);

  // As kill -9 and a respawn do; with or without what was on disk.
  void restart(int robot, bool with_state);

  // The next keyframe of each robot comes every half second.
  void run_for(Utime duration);
  void run_until_told(int robot);
  bool is_quiet() const;
  void run_until_quiet();

  Utime now() const { return now_; }
  int robots() const { return static_cast<int>(drives_.size()); }
  // What a robot has published of closures with another (or itself), by its content.
  std::map<KeyframeName, loop_t> closures(int robot, int other) const;
  SE3 truth(const loop_t& loop) const;
  const std::vector<loop_t>& published(int robot) const { return published_.at(robot); }
  const std::vector<Seen>& drive_of(int robot) const { return drives_[static_cast<std::size_t>(robot)]; }
  LcdAgent& agent(int robot) { return *agents_.at(robot); }
  Air& air() { return *air_; }

  // Copies of own bags that a robot has sent, and of another's bags that it has got.
  int bags_sent(int robot) const { return sent_.at(robot); }
  int bags_got(int robot, int from) const { return got_.at({robot, from}); }
  // Whether all that another had taken before `utime` is there.
  bool has_bags(int robot, int from, Utime before) const;
  // Copies of one that was there already.
  int bags_in_vain() const { return in_vain_; }

 private:
  void start(int robot);
  void feed(int robot);
  void collect(int robot);
  void receive(int to, const LcdMessage& message, Utime now);

  LcdOptions options_;
  std::unique_ptr<Air> air_;
  Utime now_ = 0;
  std::vector<std::vector<Seen>> drives_;
  std::map<int, std::unique_ptr<LcdAgent>> agents_;
  std::map<int, std::size_t> fed_;
  std::map<int, std::vector<LcdRecord>> records_;
  std::map<int, std::vector<loop_t>> published_;
  std::map<int, int> sent_;
  std::map<std::pair<int, int>, int> got_;
  std::map<int, std::set<KeyframeName>> bags_of_;
  int in_vain_ = 0;
};

// Both ends of each pair have the very same closures, at least so many, and they are right. Empty, or what is wrong.
std::string disagreement(const Team& team, std::size_t least);
// Numbers of a stream count from 0 without gaps, whatever was restarted.
bool has_good_streams(const Team& team);

}  // namespace covey::place
