// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/radio_account.h"

#include "core/radio/addressing.h"
#include "core/radio/link.h"
#include "core/radio/packet.h"

namespace covey {

void add_datagram(RadioAccount& account, const radio::TreatmentTable& table, const std::string& channel,
                  radio::ByteView payload) {
  const auto bytes = static_cast<std::int64_t>(radio::packet_bytes(channel, payload.size()));
  const auto add = [bytes](RadioSum& sum) {
    ++sum.packets;
    sum.bytes += bytes;
  };
  const auto addressing = radio::peek_addressing(payload);
  const auto module = radio::module_of(channel, payload, table);
  if (!addressing || !module || radio::refusal_of_ids(*addressing) != nullptr) {
    add(account.foreign);
    return;
  }
  add(account.total);
  add(account.modules[radio::index_of(*module)]);
  add(account.senders[addressing->from]);
  add(account.channels[channel]);
}

}  // namespace covey
