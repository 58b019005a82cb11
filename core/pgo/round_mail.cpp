// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/round_mail.h"

#include "core/base/error.h"

namespace covey::pgo {

RoundMail::RoundMail(const RoundName& name, int robot, std::vector<int> members)
    : name_(name), robot_(robot), members_(std::move(members)), part_(members_) {
  COVEY_CHECK(std::binary_search(members_.begin(), members_.end(), robot_));
}

const char* RoundMail::receive(const RoundMessage& message) {
  const int sender = sender_of(message);
  const int n = number_of(message);
  if (sender == robot_ || !std::binary_search(members_.begin(), members_.end(), sender)) return "sender";
  if (n < number_) return "duplicate";
  if (n > number_ + 1) return "number";
  if (!values_are_good(message)) return "values";
  if (!inbox_[sender].emplace(n, message).second) return "duplicate";
  return nullptr;
}

std::vector<int> RoundMail::missing() const {
  std::vector<int> robots;
  for (const int robot : part_) {
    const auto box = inbox_.find(robot);
    if (box == inbox_.end() || box->second.count(number_) == 0) robots.push_back(robot);
  }
  return robots;
}

void RoundMail::keep_sent(RoundMessage message) {
  inbox_[robot_].clear();
  inbox_[robot_].emplace(number_, message);
  sent_.emplace(number_, message);
  if (partings_.count(number_ - 2) == 0) sent_.erase(number_ - 2);
  outgoing_.push_back(std::move(message));
}

void RoundMail::forget_before_number() {
  for (auto& [robot, box] : inbox_) box.erase(box.begin(), box.lower_bound(number_));
}

// Those that are waited for no longer may yet miss the message that all had to have to get here.
void RoundMail::continue_with(std::vector<int> robots) {
  if (robots.size() < part_.size()) partings_.insert(number_);
  part_ = std::move(robots);
}

const RoundMessage* RoundMail::resend(int number) const {
  const auto found = sent_.find(number);
  return found == sent_.end() ? nullptr : &found->second;
}

}  // namespace covey::pgo
