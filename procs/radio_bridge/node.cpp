// SPDX-License-Identifier: BSD-3-Clause
#include "procs/radio_bridge/node.h"

#include "procs/radio_bridge/network_namespace.h"

namespace covey {
namespace {

constexpr Utime kTickUs = 10'000;
constexpr std::string_view kOut = "OUT_";

bool is_log(const std::string& url) { return url.rfind("file://", 0) == 0; }

}  // namespace

void RadioDoor::open(Process& process) {
  read_config(process.config().root().section("radio_bridge"), options);
  if (!is_log(options.radio_url)) {
    RadioUrl url = parse_radio_url(options.radio_url);
    if (url.ttl < 0) url.ttl = options.ttl;
    socket = std::make_unique<RadioSocket>(url, options.interface);
  }
  if (!options.netns.empty()) enter_network_namespace(options.netns);
}

RadioBridgeNode::RadioBridgeNode(Process& process, RadioDoor& door)
    : process_(process),
      door_(door),
      link_(process.robot(), process.now(), radio_table(), {}, door.options.model,
            [&process](const std::string& name, std::int64_t n) { process.status().count(name, n); }) {
  process_.bus().subscribe_raw("OUT_.*", [this](const std::string& channel, const Bytes& bytes) {
    link_.send(std::string_view(channel).substr(kOut.size()), bytes, process_.now());
    flush();
  });
  if (!door_.socket) {
    open_radio_log(door_.options.radio_url);
  } else if (process_.from_log()) {
    throw_input_error("--radio-url {}: with --url a log, the radio must be a log too (file://AIR.lcm)",
                      door_.options.radio_url);
  } else {
    process_.loop().add_fd(door_.socket->fd(), [this] {
      const Utime now = process_.now();
      door_.socket->receive([&](radio::ByteView datagram) { link_.receive(datagram, now); });
      flush();
    });
  }
  process_.loop().call_every(kTickUs, [this] { flush(); });
}

// A log of the air has channels and payloads: the datagrams are made again around them.
void RadioBridgeNode::open_radio_log(const std::string& url) {
  process_.open_bus(url).subscribe_raw(".*", [this](const std::string& channel, const Bytes& bytes) {
    if (!radio::fits_packet(channel, bytes.size())) return process_.status().count("dropped/radio/too_long");
    link_.receive(radio::write_packet(log_sequence_++, channel, bytes), process_.now());
    flush();
  });
}

void RadioBridgeNode::flush() {
  const radio::Link::Output output = link_.on_tick(process_.now());
  for (const auto& delivery : output.bus)
    process_.bus().publish_raw("IN_" + delivery.channel, delivery.payload);
  for (const radio::Bytes& datagram : output.air) put_on_air(datagram);
  process_.status().gauge("unfinished_messages", static_cast<double>(link_.open_messages()));
  process_.status().gauge("robots_heard", static_cast<double>(link_.peers()));
  if (door_.socket && door_.socket->kernel_drops() > 0) {
    process_.status().set_counter(fmt::format("kernel_drops/{}", door_.socket->port()),
                                  door_.socket->kernel_drops());
  }
}

void RadioBridgeNode::put_on_air(const radio::Bytes& datagram) {
  if (door_.socket) {
    if (const char* failed = door_.socket->send(datagram)) {
      process_.status().count(std::string("dropped/radio/") + failed);
    }
    return;
  }
  const radio::Packet packet = radio::parse_packet(datagram).packet;
  process_.bus().publish_raw(std::string(packet.channel),
                             Bytes(packet.payload.begin(), packet.payload.end()));
}

}  // namespace covey
