// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A team's loop finders that talk over a network that loses nothing, and what they say in bytes.

#include <covey/loop_t.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/place/lcd_agent.h"
#include "tests/bench/place/view.h"

namespace covey::bench {

class Team {
 public:
  Team(int robots, std::shared_ptr<const place::Vocabulary> vocabulary, const place::LcdOptions& options);

  void add(const View& view, place::FrameFeatures features);
  // Half a minute, in which all that waits is done.
  void finish();

  const Views& views() const { return views_; }
  const std::vector<loop_t>& loops() const { return loops_; }  // of both ends
  const std::vector<place::BagOfWords>& bags() const { return bags_; }
  // "keyframes", "bytes": by type, "bytes_pr", "bytes_gv", "exchange_ms" of CPU per keyframe, "funnels": [{"robot", "with", steps}].
  nlohmann::json account() const;

 private:
  void settle(Utime now);
  template <typename Message>
  void deliver(const Message& message, Utime now);

  std::shared_ptr<const place::Vocabulary> vocabulary_;
  std::vector<std::unique_ptr<place::LcdAgent>> agents_;
  Views views_;
  std::vector<loop_t> loops_;
  std::vector<place::BagOfWords> bags_;
  std::map<std::string, std::int64_t> bytes_;
  Utime now_ = 0;
  double exchange_s_ = 0.0;
};

}  // namespace covey::bench
