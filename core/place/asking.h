// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Which keyframes' features a robot asks others for, out of which budget, and what it does while they do not answer.
//
// A feature's message is dear (5.5 kB), so each robot may be asked for `per_keyframe` keyframes for each that was heard of it, and `at_once` to begin
// with; no more than `at_once` questions to it are open. What does not answer is asked again after `again_us`, which doubles, `times` times in
// all; while a robot is out of range nothing is asked, and when it is heard again its questions begin anew.
//
// Who asks for more of a keyframe, of which the best features are here, pays for two; once for each.

#include <covey/lcd_more_t.hpp>
#include <covey/lcd_request_t.hpp>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <variant>
#include <vector>

#include "core/base/time.h"
#include "core/pgo/robot_graph.h"

namespace covey::place {

using pgo::KeyframeName;

struct AskingOptions {
  double per_keyframe = 0.35;
  int at_once = 4;                    // at most kMostAskedFor
  Utime again_us = 5 * kUsPerSecond;  // doubles
  int times = 5;
};

constexpr int kMostAskedFor = 32;  // keyframes in one request

class Asking {
 public:
  using Question = std::variant<lcd_request_t, lcd_more_t>;
  using InRange = std::function<bool(int robot)>;

  explicit Asking(int robot, const AskingOptions& options = {}) : robot_(robot), options_(options) {}

  // A keyframe of a robot was heard of, which may be asked for that much more.
  void allow(int robot) { left(robot) += options_.per_keyframe; }

  // False: it is asked for already, or its robot is asked enough.
  bool ask(const KeyframeName& name, Utime now);
  // After its best `known` features; false: the budget does not reach, or it was asked for more before.
  bool ask_for_more(const KeyframeName& name, int known, Utime now);
  // What is to be sent.
  std::vector<Question> take(Utime now);

  // How many features were here when it was asked for; nothing: it is not.
  std::optional<int> known(const KeyframeName& name) const;
  // It is here, or never will be.
  void end(const KeyframeName& name) { asked_.erase(name); }
  // Its features are here no more: it may be asked for more once again.
  void forget(const KeyframeName& name) { more_asked_.erase(name); }

  // A robot came into range.
  void hear(int robot, Utime now);
  // Asks again; those that were asked often enough are asked for no more.
  std::vector<KeyframeName> give_up(Utime now, const InRange& in_range);

  // A robot in range has not answered yet. Who has not answered twice may have gone; nobody should wait for it.
  bool waits(const InRange& in_range) const;

 private:
  struct Asked {
    Utime again = 0;
    int times = 1;
    int known = 0;  // features that are here already
  };

  double& left(int robot) { return left_.try_emplace(robot, options_.at_once).first->second; }
  lcd_more_t more(const KeyframeName& name, int known, Utime now) const;

  int robot_;
  AskingOptions options_;
  std::map<KeyframeName, Asked> asked_;
  std::set<KeyframeName> more_asked_;
  std::map<int, double> left_;  // keyframes, by robot
  std::map<int, std::vector<KeyframeName>> unsaid_;
  std::vector<Question> questions_;
};

}  // namespace covey::place
