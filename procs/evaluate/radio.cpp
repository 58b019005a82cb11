// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/eval/radio_account.h"
#include "procs/common/channels.h"
#include "procs/common/log_file.h"
#include "procs/evaluate/commands.h"

namespace covey {
namespace {

using Json = nlohmann::ordered_json;

struct RadioOptions {
  std::string log;
};

Json to_json(const RadioSum& sum) { return {{"packets", sum.packets}, {"bytes", sum.bytes}}; }

void print_account(const RadioOptions& options) {
  RadioAccount account;
  std::optional<Utime> first;
  Utime last = 0;
  LogReader log(options.log, [&](const std::string& channel, const Bytes& payload) {
    add_datagram(account, radio_table(), channel, payload);
  });
  while (const std::optional<Utime> time = log.next_time()) {
    first = first.value_or(*time);
    last = *time;
    log.deliver();
  }
  Json json = {{"seconds", first ? to_seconds(last - *first) : 0.0},
               {"total", to_json(account.total)},
               {"foreign", to_json(account.foreign)}};
  for (std::size_t m = 0; m < radio::kModules; ++m)
    json["modules"][radio::kModuleNames[m]] = to_json(account.modules[m]);
  json["robots"] = Json::array();
  for (const auto& [robot, sum] : account.senders) {
    Json entry = {{"robot", robot}};
    entry.update(to_json(sum));
    json["robots"].push_back(entry);
  }
  json["channels"] = Json::object();
  for (const auto& [channel, sum] : account.channels) json["channels"][channel] = to_json(sum);
  std::cout << json.dump(2) << "\n";
}

}  // namespace

void add_radio_command(CLI::App& app) {
  auto options = std::make_shared<RadioOptions>();
  CLI::App* command = app.add_subcommand(
      "radio", "bytes on the air by module, robot and channel; whole datagrams, each counted once");
  command->add_option("--log", options->log, "lcm-logger's log of the radio's bus")->required();
  command->callback([options] { print_account(*options); });
}

}  // namespace covey
