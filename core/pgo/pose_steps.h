// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Public keyframes as they travel between the robots of a round once all know where they start: as steps from where all
// expect them. Sender and receivers add the same steps by the same arithmetic, so they hold the same poses to the last bit, and
// what rounding left out of one step is part of the next.
//
// A step is a rotation vector phi (Gibbs: R' = normalised(1, phi / 2) R) and t' - t, both in the common frame, in which
// the keyframes of one robot move alike: as one rigid body a keyframe would move with its neighbour by phi and
// t' - t + phi x (t_next - t). So the first and the last keyframe are coded, then the one in the middle by what it differs
// from the mean of the motions with both, and so on in the halves: where a trajectory bends smoothly all but the
// first few are nearly zero. Differences are whole numbers of units, coded by what numbers of the same component between
// neighbours as far apart have been in all updates so far (range_code.h); zeros cost next to nothing.

#include <array>
#include <covey/dpgo_advance_t.hpp>
#include <vector>

#include "core/geometry/se3.h"
#include "core/pgo/range_code.h"

namespace covey::pgo {

struct PoseUnits {
  double rotation = 0.0;     // rad
  double translation = 0.0;  // m
};

// Of one robot's keyframes: what all know of the code after the messages so far.
class StepCode {
 public:
  // along: the place of each keyframe on its trajectory; where they are far apart they are held for unrelated.
  explicit StepCode(std::vector<double> along);

  // Writes the steps from where the chosen keyframes are expected to where they are wanted.
  void encode(const std::vector<SE3>& expected, const std::vector<SE3>& wanted,
              const std::vector<bool>& chosen, const PoseUnits& units, dpgo_advance_t& message) const;
  // Moves the message's keyframes from where they are expected, none where its code is empty. False, and nothing changed,
  // where it does not hold steps of that many, or sends one beyond any measure.
  bool add(const dpgo_advance_t& message, const std::vector<SE3>& expected, std::vector<SE3>& poses);

 private:
  static constexpr int kLevels = 8;  // of how far apart the neighbours are
  struct Models {
    std::array<std::array<NumberModel, kLevels>, 6> numbers;
    std::array<BitModel, 2> chosen;  // by whether it was the time before
  };

  std::vector<double> along_;
  Models models_;
  std::vector<bool> chosen_;
};

}  // namespace covey::pgo
