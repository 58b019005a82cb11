// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/place/team.h"

#include <algorithm>
#include <utility>

#include "tests/bench/place/cpu_clock.h"

namespace covey::bench {

Team::Team(int robots, std::shared_ptr<const place::Vocabulary> vocabulary, const place::LcdOptions& options)
    : vocabulary_(std::move(vocabulary)) {
  for (int robot = 0; robot < robots; ++robot)
    agents_.push_back(std::make_unique<place::LcdAgent>(robot, 1, vocabulary_, options));
}

void Team::add(const View& view, place::FrameFeatures features) {
  views_[view.name] = view;
  bags_.push_back(vocabulary_->bag(features.descriptors));
  now_ = std::max(now_, view.utime);
  const CpuClock clock;
  agents_[static_cast<std::size_t>(view.name.robot)]->add(view.name, view.utime, std::move(features), now_);
  exchange_s_ += clock.seconds();
  settle(now_);
}

void Team::finish() {
  for (int second = 1; second <= 30; ++second) settle(now_ + second * kUsPerSecond);
}

void Team::settle(Utime now) {
  const CpuClock clock;
  bool moved = true;
  while (moved) {
    moved = false;
    for (auto& agent : agents_) {
      agent->tick(now);
      moved = agent->work(now) || moved;
      for (const place::LcdMessage& message : agent->take_outgoing()) {
        moved = true;
        std::visit([&](const auto& m) { deliver(m, now); }, message);
      }
      agent->take_records();
      for (const loop_t& loop : agent->take_loops()) loops_.push_back(loop);
    }
  }
  exchange_s_ += clock.seconds();
}

template <typename Message>
void Team::deliver(const Message& message, Utime now) {
  bytes_[Message::getTypeName()] += message.getEncodedSize();
  for (std::size_t robot = 0; robot < agents_.size(); ++robot) {
    const int to = static_cast<int>(robot);
    if (to != message.from && (message.to == -1 || message.to == to)) agents_[robot]->receive(message, now);
  }
}

nlohmann::json Team::account() const {
  nlohmann::json account;
  std::int64_t all = 0;
  for (const auto& [type, bytes] : bytes_) all += bytes;
  std::int64_t recognition = 0;
  for (const char* type : {lcd_bag_t::getTypeName(), lcd_inventory_t::getTypeName()}) {
    const auto bytes = bytes_.find(type);
    if (bytes != bytes_.end()) recognition += bytes->second;
  }
  account["keyframes"] = views_.size();
  account["bytes"] = bytes_;
  account["bytes_pr"] = recognition;
  account["bytes_gv"] = all - recognition;
  account["exchange_ms"] = 1e3 * exchange_s_ / std::max<double>(1.0, static_cast<double>(views_.size()));
  for (std::size_t robot = 0; robot < agents_.size(); ++robot) {
    for (const auto& [other, counts] : agents_[robot]->funnel().by_robot()) {
      nlohmann::json funnel = counts;
      funnel["robot"] = robot;
      funnel["with"] = other;
      account["funnels"].push_back(funnel);
    }
  }
  return account;
}

}  // namespace covey::bench
