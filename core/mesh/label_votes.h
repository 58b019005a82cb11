// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Bayesian fusion of the labels that a voxel is seen with. An observation z names the true class l with probability p and each of the
// other n - 1 classes with (1 - p) / (n - 1). From a uniform prior
//
//   P(l | z_1 ... z_m) = exp(delta c_l) / sum_k exp(delta c_k),    delta = log(p (n - 1) / (1 - p)),
//
// where c_l counts the observations of l: the log posterior of every class is its count, up to a constant that all share. So counts are
// all that has to be kept, and of those the few largest. An unknown label says nothing and changes nothing. (Kimera: Rosinol et al., IJRR
// 2021, section on Kimera-Semantics, keeps the log posterior of all n classes.)
//
// A fifth label takes one from all four counts instead of a place: in the log posterior that is the constant that all share, but for
// the unseen classes, whose count is 0 by definition. What more than a fifth of the observations agree on always keeps its place
// (Misra and Gries, "Finding repeated elements", 1982). A count that is full takes from the others instead.

#include <array>
#include <cstdint>

namespace covey::mesh {

constexpr std::uint8_t kUnknownLabel = 255;

struct LabelModel {
  double accuracy = 0.9;  // p: of an observed label being right
  int classes = 20;       // n
};

class LabelVotes {
 public:
  static constexpr std::size_t kKept = 4;

  void observe(std::uint8_t label);
  // The label with the largest posterior (the smaller number of two with the same); unknown where nothing was observed.
  std::uint8_t likeliest() const;
  double posterior(std::uint8_t label, const LabelModel& model) const;
  int count(std::uint8_t label) const;

 private:
  std::array<std::uint8_t, kKept> labels_ = {};
  std::array<std::uint8_t, kKept> counts_ = {};  // 0: this place is free
};

}  // namespace covey::mesh
