// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/round_message.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/pgo/elected_messages.h"
#include "core/pgo/public_poses.h"

namespace covey::pgo {
namespace {

constexpr int kMostSegments = 1000;  // each costs all members time
constexpr double kSmallestMu = 1e-18;
constexpr double kFarthestM = 1e8;

template <typename T>
bool good_poses(const std::vector<T>& values, int n) {
  return static_cast<std::int64_t>(values.size()) == 7 * static_cast<std::int64_t>(n) &&
         poses_are_good(values) &&
         std::all_of(values.begin(), values.end(), [](T value) { return std::abs(value) < kFarthestM; });
}

struct ValuesAreGood {
  bool operator()(const dpgo_join_t& m) const {
    return m.n_segments > 0 && m.n_segments <= kMostSegments && good_poses(m.T_O_K, m.n_segments) &&
           (m.mu == 0.0 || (m.mu >= kSmallestMu && std::isfinite(m.mu))) &&
           std::is_sorted(m.segments.begin(), m.segments.end());
  }
  bool operator()(const dpgo_keys_t&) const { return true; }
  bool operator()(const dpgo_keyframes_t& m) const {
    return m.n > 0 && m.rotation_unit > 0.0F && m.rotation_unit < 1.0F && m.translation_unit > 0.0F &&
           m.translation_unit < 1e4F;
  }
  bool operator()(const dpgo_alignment_t& m) const { return good_poses(m.T_A_B, m.n); }
  bool operator()(const dpgo_advance_t& m) const {
    return m.max_residual_sq >= 0.0F && m.max_residual_sq < kLargestResidualSq && std::isfinite(m.cost) &&
           m.penalty >= 0.0F && std::isfinite(m.penalty) && std::isfinite(m.decrease) &&
           std::isfinite(m.gradient_sq) && m.rotation_unit <= 0 && m.translation_unit < 14 &&
           std::isfinite(m.step_sq) && std::all_of(m.products.begin(), m.products.end(), [](float value) {
             return std::isfinite(value);
           });
  }
  bool operator()(const dpgo_coarse_t& m) const {
    const auto finite = [](float value) { return std::isfinite(value); };
    return std::all_of(m.gradient.begin(), m.gradient.end(), finite) &&
           std::all_of(m.values.begin(), m.values.end(), finite);
  }
  bool operator()(const dpgo_graph_t& m) const { return pgo::values_are_good(m); }
  bool operator()(const dpgo_poses_t& m) const { return pgo::values_are_good(m); }
};

}  // namespace

int number_of(const RoundMessage& message) {
  return std::visit([](const auto& m) { return m.number; }, message);
}
int sender_of(const RoundMessage& message) {
  return std::visit([](const auto& m) { return m.from; }, message);
}
RoundName round_of(const RoundMessage& message) {
  return std::visit([](const auto& m) { return RoundName{m.round, m.anchor}; }, message);
}

bool values_are_good(const RoundMessage& message) { return std::visit(ValuesAreGood{}, message); }

}  // namespace covey::pgo
