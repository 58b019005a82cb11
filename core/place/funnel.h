// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How far it was on the way from bags of words to closures, with each other robot, and why it ended: a robot that finds no closures with
// another says here where they got lost. Under the own number stands the own past.
//
//   received (words) > candidate > asked > answered > verified > matched > five_point > three_point > refined > accepted;
//   told: closures that the other robot found; refused/REASON

#include <cstdint>
#include <map>
#include <string>

namespace covey::place {

class Funnel {
 public:
  using Counts = std::map<std::string, std::int64_t>;

  void count(int robot, const std::string& step, std::int64_t n = 1) { counts_[robot][step] += n; }
  void refuse(int robot, const std::string& reason, std::int64_t n = 1) {
    counts_[robot]["refused/" + reason] += n;
  }

  const std::map<int, Counts>& by_robot() const { return counts_; }
  Counts total() const;

 private:
  std::map<int, Counts> counts_;
};

}  // namespace covey::place
