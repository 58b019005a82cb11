// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/channels.h"

#include <set>

namespace covey {

const char* radio_channel_name(const char* prefix, const char* name) {
  static std::set<std::string> names;  // nodes of a set do not move
  return names.insert(std::string(prefix) + name).first->c_str();
}

const radio::TreatmentTable& radio_table() {
  static const radio::TreatmentTable kTable = std::apply(
      []<typename... T>(const RadioChannel<T>&... channel) {
        return radio::TreatmentTable{
            {channel.name, {channel.module, channel.reliable, channel.priority, T::getHash()}}...};
      },
      kRadioChannels);
  return kTable;
}

}  // namespace covey
