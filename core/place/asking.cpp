// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/asking.h"

#include <algorithm>
#include <utility>

namespace covey::place {
namespace {

constexpr double kCostOfMore = 2.0;  // keyframes

lcd_request_t request(int from, const std::vector<KeyframeName>& names, Utime now) {
  lcd_request_t request{};
  request.utime = now;
  request.from = from;
  request.to = names.front().robot;
  for (const KeyframeName& name : names) {
    request.segments.push_back(name.segment);
    request.ids.push_back(name.id);
  }
  request.n = static_cast<std::int32_t>(names.size());
  return request;
}

}  // namespace

bool Asking::ask(const KeyframeName& name, Utime now) {
  if (asked_.contains(name)) return false;
  const auto open = std::count_if(asked_.begin(), asked_.end(),
                                  [&](const auto& each) { return each.first.robot == name.robot; });
  if (open >= options_.at_once || left(name.robot) < 1.0) return false;
  left(name.robot) -= 1.0;
  asked_[name] = {now + options_.again_us, 1, 0};
  unsaid_[name.robot].push_back(name);
  return true;
}

bool Asking::ask_for_more(const KeyframeName& name, int known, Utime now) {
  if (left(name.robot) < kCostOfMore || !more_asked_.insert(name).second) return false;
  left(name.robot) -= kCostOfMore;
  asked_[name] = {now + options_.again_us, 1, known};
  questions_.emplace_back(more(name, known, now));
  return true;
}

std::vector<Asking::Question> Asking::take(Utime now) {
  for (const auto& [robot, names] : std::exchange(unsaid_, {}))
    questions_.emplace_back(request(robot_, names, now));
  return std::exchange(questions_, {});
}

std::optional<int> Asking::known(const KeyframeName& name) const {
  const auto asked = asked_.find(name);
  return asked == asked_.end() ? std::nullopt : std::optional(asked->second.known);
}

void Asking::hear(int robot, Utime now) {
  for (auto& [name, asked] : asked_) {
    if (name.robot == robot) asked = {now + options_.again_us, 1, asked.known};
  }
}

std::vector<KeyframeName> Asking::give_up(Utime now, const InRange& in_range) {
  std::vector<KeyframeName> unanswered;
  for (auto& [name, asked] : asked_) {
    if (now < asked.again || !in_range(name.robot)) continue;
    if (asked.times >= options_.times) {
      unanswered.push_back(name);
      continue;
    }
    asked.again = now + (options_.again_us << asked.times);
    ++asked.times;
    if (asked.known > 0) {
      questions_.emplace_back(more(name, asked.known, now));
    } else {
      questions_.emplace_back(request(robot_, {name}, now));
    }
  }
  for (const KeyframeName& name : unanswered) asked_.erase(name);
  return unanswered;
}

bool Asking::waits(const InRange& in_range) const {
  return std::any_of(asked_.begin(), asked_.end(),
                     [&](const auto& each) { return each.second.times <= 2 && in_range(each.first.robot); });
}

lcd_more_t Asking::more(const KeyframeName& name, int known, Utime now) const {
  lcd_more_t message{};
  message.utime = now;
  message.from = robot_;
  message.to = name.robot;
  message.segment = name.segment;
  message.id = name.id;
  message.known = known;
  return message;
}

}  // namespace covey::place
