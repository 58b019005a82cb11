// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The numbered messages of a round, as one member sends and holds them. Message n + 1 is made when message n of all whose
// messages are waited for is here, so nobody is more than one message ahead: what comes is kept by sender and number, the
// last two of one's own are kept for those who ask again, and with them those after which the members fell into parts.

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/pgo/round_message.h"

namespace covey::pgo {

class RoundMail {
 public:
  RoundMail(const RoundName& name, int robot, std::vector<int> members);

  const RoundName& name() const { return name_; }
  int robot() const { return robot_; }
  const std::vector<int>& members() const { return members_; }
  const std::vector<int>& part() const { return part_; }  // whose messages are waited for; ascending
  int number() const { return number_; }                  // of the last message that was sent; -1 before

  // Null when taken, else why not: "sender", "number", "duplicate", "values".
  const char* receive(const RoundMessage& message);
  std::vector<int> missing() const;  // of the part: whose message number() is not here yet

  // A message of this round by this robot, to be filled; and its sending as the next number.
  template <typename T>
  T compose() const {
    T m{};
    m.from = robot_;
    m.to = -1;
    m.round = name_.number;
    m.anchor = name_.anchor;
    return m;
  }
  template <typename T>
  void send(T m) {
    m.number = ++number_;
    bytes_ += m.getEncodedSize();
    keep_sent(std::move(m));
  }

  // Message number() of a robot of the part. all_fit: drops those that are not what is due, of senders that do not
  // follow the protocol, so that they count as missing; false when there were any.
  template <typename T>
  const T& from(int robot) const {
    return std::get<T>(inbox_.at(robot).at(number_));
  }
  template <typename Fits>
  bool all_fit(Fits fits) {
    bool all = true;
    for (const int robot : part_) {
      auto& box = inbox_.at(robot);
      if (fits(robot, box.at(number_))) continue;
      box.erase(number_);
      all = false;
    }
    return all;
  }
  void forget_before_number();

  // Waits for these of the part alone from here on.
  void continue_with(std::vector<int> robots);

  std::int64_t bytes() const { return bytes_; }  // that were sent, as encoded, each message once
  std::vector<RoundMessage> take_outgoing() { return std::exchange(outgoing_, {}); }
  const RoundMessage* resend(
      int number) const;  // null when it is not made yet, or too old to be missing anywhere

 private:
  void keep_sent(RoundMessage message);

  RoundName name_;
  int robot_;
  std::vector<int> members_;
  std::vector<int> part_;
  int number_ = -1;
  std::map<int, std::map<int, RoundMessage>> inbox_;  // by sender, by number
  std::map<int, RoundMessage> sent_;                  // the last two, and those at partings
  std::set<int> partings_;                            // numbers after which this part waits for fewer
  std::vector<RoundMessage> outgoing_;
  std::int64_t bytes_ = 0;
};

}  // namespace covey::pgo
