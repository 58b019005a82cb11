// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One robot's side of distributed place recognition, without clock or socket: messages and time in, messages and closures out.
// The paper's two steps (section V):
//
//  1. Each keyframe's bag of words goes to everyone, once (lcd_bag_t), or later to those who missed it (bag_exchange.h). Of two
//     robots one looks for common places, in turn by the parity of their numbers, so that the work is shared evenly and every pair
//     of keyframes is looked at once in the team. A keyframe's similarity to another is divided by that to the keyframe before it,
//     of its own robot: what can be expected there.
//  2. For the best candidates it asks for the other's points and descriptors (lcd_request_t -> lcd_frame_t: the best of them, which
//     are matched with all of its own; the others too where those were nearly enough and nothing joins the two trajectories yet,
//     lcd_more_t), verifies (verification.h), and tells the other robot what it measured (lcd_loop_t), which answers with the same
//     message: an acknowledgement. Both publish the very same numbers, since pose graphs know a shared closure by them.
//
// Closures of a robot with its own past need no messages. A closure next to an accepted one says little new and is not looked for.
//
// Whatever the network loses, doubles or disorders: a closure that one end has reaches the other, for it is repeated until it is
// acknowledged; lost features cost closures, never agreement. A robot that is out of range is neither asked nor told: both wait
// until it is heard again. Work and memory are bounded by LcdOptions. What must
// survive a restart is handed out as records, in an order in which they can be taken back.

#include <covey/lcd_bag_t.hpp>
#include <covey/lcd_frame_t.hpp>
#include <covey/lcd_inventory_t.hpp>
#include <covey/lcd_loop_t.hpp>
#include <covey/lcd_more_t.hpp>
#include <covey/lcd_request_t.hpp>
#include <covey/loop_t.hpp>
#include <deque>
#include <map>
#include <memory>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "core/place/asking.h"
#include "core/place/bag_exchange.h"
#include "core/place/database.h"
#include "core/place/funnel.h"
#include "core/place/lcd_messages.h"
#include "core/place/vocabulary.h"

namespace covey::place {

struct LcdOptions {
  double least_similarity = 0.1;  // normalised
  double least_self_similarity =
      0.02;  // to the keyframe before: below that a keyframe says nothing, and is not looked for
  double ask_similarity = 0.6;  // from here on features of other robots are asked for, the most similar first
  int candidates = 2;           // of one keyframe among those of one robot
  int least_features = 50;      // a keyframe with fewer is of no use
  Utime recent_us = 10 * kUsPerSecond;  // own keyframes of the same segment nearer in time are no closure
  int redundant = 1;  // ids from an accepted closure, at both ends, that are not looked at any more
  double verifications_per_s = 8.0;
  int waiting = 200;                        // candidates that wait to be verified; the least similar go first
  int keyframes = 5000;                     // of each robot that are remembered
  int sent_features = 150;                  // of a keyframe, to who asks for them
  int more_features = 350;                  // after them, to who asks for more: as many bytes as two others
  int nearly_matches = 12;                  // that were found in vain, from which on more are asked for
  int others_features = 100;                // keyframes of other robots of which features are kept
  Utime repeat_loop_us = 5 * kUsPerSecond;  // doubles up to twelve times that
  int most_loops = 100'000;
  AskingOptions asking;
  ExchangeOptions exchange;
  VerificationOptions verification;
};

using LcdMessage =
    std::variant<lcd_inventory_t, lcd_bag_t, lcd_request_t, lcd_more_t, lcd_frame_t, lcd_loop_t>;
using LcdRecord = std::variant<lcd_bag_t, lcd_frame_t, lcd_loop_t, loop_t>;

class LcdAgent {
 public:
  // `stream`: names this run in its loop_t; those of earlier runs, from records, keep theirs.
  LcdAgent(int robot, std::int64_t stream, std::shared_ptr<const Vocabulary> vocabulary,
           const LcdOptions& options);

  // The robot's own keyframe. Null when taken, else why not: "robot", "duplicate", "few_features", "full".
  const char* add(const KeyframeName& name, Utime utime, FrameFeatures features, Utime now);

  // Null when taken, else why not.
  const char* receive(const lcd_inventory_t& message, Utime now);
  const char* receive(const lcd_bag_t& message, Utime now);
  const char* receive(const lcd_request_t& message, Utime now);
  const char* receive(const lcd_more_t& message, Utime now);
  const char* receive(const lcd_frame_t& message, Utime now);
  const char* receive(const lcd_loop_t& message, Utime now);

  // Sends what others lack; asks and tells again what has not been answered.
  void tick(Utime now);
  // Verifies at most one candidate, some 10 ms of work, or looks for those that waited before a restart, of one keyframe; false: there is
  // nothing to be done.
  bool work(Utime now);

  // Something is to be verified, or was sent, asked or told a short while ago to a robot in range and is not answered yet.
  bool is_busy(Utime now) const;

  // Before anything else: what an earlier run of this robot's left behind, in its order. Candidates are not kept: work() finds them again.
  void restore(const LcdRecord& record);

  std::vector<LcdMessage> take_outgoing() { return std::exchange(outgoing_, {}); }
  std::vector<LcdRecord> take_records() { return std::exchange(records_, {}); }
  std::vector<loop_t> take_loops() {
    return std::exchange(new_loops_, {});
  }  // to be published; restored ones too

  const Funnel& funnel() const { return funnel_; }
  int keyframes(int robot) const;
  int others_keyframes() const;
  int waiting() const { return static_cast<int>(waiting_.size()); }
  int untold() const {
    return static_cast<int>(untold_.size());
  }  // closures that the other end has not acknowledged
  int loops() const { return static_cast<int>(loops_.size()); }
  // The next id of each own segment.
  std::map<Utime, int> own_positions() const;

 private:
  struct Place {
    KeyframeName name;
    Utime utime = 0;
  };
  struct RobotPlaces {
    PlaceDatabase words;
    std::vector<Place> places;  // by the database's number
    std::map<KeyframeName, int> entries;
  };
  struct Candidate {
    KeyframeName own;
    KeyframeName other;
    double similarity = 0.0;
    bool awaits_more = false;  // features: nearly enough are here
  };
  struct Untold {
    int to = 0;
    Utime again = 0;  // 0: not told yet
    Utime period = 0;
  };
  // Ids of accepted closures by what they join: (own segment, other robot, its segment).
  using Joint = std::tuple<Utime, int, Utime>;

  void hear(int robot, Utime now);
  void exchange_bags(Utime now);
  const char* remember(const KeyframeName& name, Utime utime, BagOfWords bag);
  double self_similarity(const KeyframeName& name) const;
  void look_for(const KeyframeName& name, int robot);
  bool look_again(Utime now);
  void add_candidate(const Candidate& candidate);
  void insert_candidate(const Candidate& candidate);
  KeyframeName own_end(const KeyframeName& a, const KeyframeName& b) const;
  KeyframeName other_end(const KeyframeName& a, const KeyframeName& b) const;
  bool is_redundant(const Candidate& candidate) const;
  const FrameFeatures* features_of(const KeyframeName& name) const;
  void keep_features_of_other(const KeyframeName& name, FrameFeatures features);
  void ask(Utime now);
  void send_questions(Utime now);
  bool can_verify(const Candidate& candidate) const;
  bool is_nearly_enough(const Candidate& candidate, const Verification& verification) const;
  void ask_for_more(Candidate candidate, Utime now);
  const char* take_more(const KeyframeName& name, const FrameFeatures& features);
  void forget_candidates(const KeyframeName& other, const char* why);
  void verify_candidate(const Candidate& candidate, Utime now);
  void count_steps(int robot, const Verification& verification);
  void take_loop(loop_t loop, Utime now);
  void note_loop(const loop_t& loop);
  void tell(Utime now);
  bool spend_verification(Utime now);

  int robot_;
  std::int64_t stream_;
  std::int32_t next_number_ = 0;
  std::shared_ptr<const Vocabulary> vocabulary_;
  LcdOptions options_;

  BagExchange exchange_;
  std::map<KeyframeName, lcd_bag_t> own_bags_;
  std::map<int, RobotPlaces> robots_;
  std::map<KeyframeName, FrameFeatures> own_features_;
  std::map<KeyframeName, FrameFeatures> others_features_;
  std::deque<KeyframeName> others_order_;
  std::vector<Candidate> waiting_;
  Asking asking_;
  std::vector<KeyframeName> restored_;  // that were not looked for again yet; the newest last
  std::vector<loop_t> loops_;
  std::map<Joint, std::vector<std::pair<int, int>>> joints_;
  std::map<std::size_t, Untold> untold_;  // by index of the loop
  double allowance_ = 1.0;
  Utime allowance_at_ = 0;

  std::vector<LcdMessage> outgoing_;
  std::vector<LcdRecord> records_;
  std::vector<loop_t> new_loops_;
  Funnel funnel_;
};

}  // namespace covey::place
