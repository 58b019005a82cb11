// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/vertex_cover.h"

#include <map>

namespace covey::pgo {
namespace {

using graph::Key;

class Matching {
 public:
  explicit Matching(const std::vector<std::pair<Key, Key>>& edges) {
    for (const auto& [left, right] : edges) neighbours_[left].insert(right);
    for (const auto& [left, right] : neighbours_) {
      std::set<Key> tried;
      augment(left, tried);
    }
  }

  // The vertices on alternating paths from unmatched left ones; the cover is the left ones that are not among them and the right
  // ones that are.
  std::set<Key> cover() const {
    std::set<Key> reached_left;
    std::set<Key> reached_right;
    std::vector<Key> open;
    for (const auto& [left, right] : neighbours_) {
      if (of_left_.contains(left)) continue;
      reached_left.insert(left);
      open.push_back(left);
    }
    while (!open.empty()) {
      const Key left = open.back();
      open.pop_back();
      for (const Key right : neighbours_.at(left)) {
        if (!reached_right.insert(right).second) continue;
        const Key next = of_right_.at(right);  // an unmatched one would have been an augmenting path
        if (reached_left.insert(next).second) open.push_back(next);
      }
    }
    std::set<Key> cover = std::move(reached_right);
    for (const auto& [left, right] : neighbours_) {
      if (!reached_left.contains(left)) cover.insert(left);
    }
    return cover;
  }

 private:
  bool augment(Key left, std::set<Key>& tried) {
    for (const Key right : neighbours_.at(left)) {
      if (!tried.insert(right).second) continue;
      const auto taken = of_right_.find(right);
      if (taken != of_right_.end() && !augment(taken->second, tried)) continue;
      of_right_[right] = left;
      of_left_[left] = right;
      return true;
    }
    return false;
  }

  std::map<Key, std::set<Key>> neighbours_;
  std::map<Key, Key> of_left_;
  std::map<Key, Key> of_right_;
};

}  // namespace

std::set<Key> vertex_cover(const std::vector<std::pair<Key, Key>>& edges) { return Matching(edges).cover(); }

}  // namespace covey::pgo
