// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Who sent how many bytes over the radio, and for which module, from what was heard on the air. A datagram counts as a
// whole, header included, once, however many robots it was for; repetitions count again, since they were sent again.

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "core/radio/bytes.h"
#include "core/radio/treatment.h"

namespace covey {

struct RadioSum {
  std::int64_t packets = 0;
  std::int64_t bytes = 0;
};

struct RadioAccount {
  RadioSum total;
  std::array<RadioSum, radio::kModules> modules;  // by radio::Module
  std::map<int, RadioSum> senders;                // by robot
  std::map<std::string, RadioSum> channels;       // by channel as it was on the air
  RadioSum foreign;                               // what no bridge sent; in no other figure
};

// One datagram as a logger of the radio's bus keeps it: channel and payload.
void add_datagram(RadioAccount& account, const radio::TreatmentTable& table, const std::string& channel,
                  radio::ByteView payload);

}  // namespace covey
