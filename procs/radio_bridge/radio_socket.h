// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The door to the radio: one UDP multicast socket that never meets liblcm's receiver. It is bound to the group's address,
// so that unicast does not reach it; it takes datagrams in batches; what is longer than its buffer is cut to one byte
// more than a datagram may have, which the parser refuses. It hears itself: its own echoes are dropped by sender.

#include <cstdint>
#include <functional>
#include <string>

#include "core/radio/bytes.h"

namespace covey {

struct RadioUrl {
  std::string group = "239.255.76.68";
  std::uint16_t port = 7800;
  int ttl = -1;  // -1: not said
};

// "udpm://239.255.76.68:7800?ttl=1". Throws InputError.
RadioUrl parse_radio_url(const std::string& url);

class RadioSocket {
 public:
  // `interface_address`: of the network that the radio is on, "" for the one that the route says. Throws InputError.
  RadioSocket(const RadioUrl& url, const std::string& interface_address);
  ~RadioSocket();
  RadioSocket(const RadioSocket&) = delete;
  RadioSocket& operator=(const RadioSocket&) = delete;

  int fd() const { return fd_; }
  std::uint16_t port() const { return url_.port; }

  using Handler = std::function<void(radio::ByteView)>;
  // What is waiting, at most a few batches, so that a flood does not starve the rest of the process.
  void receive(const Handler& handler);
  // Null, or why it could not be sent.
  const char* send(radio::ByteView datagram);

  // Datagrams that the kernel dropped for want of room.
  std::int64_t kernel_drops() const { return kernel_drops_; }

 private:
  RadioUrl url_;
  int fd_ = -1;
  std::int64_t kernel_drops_ = 0;
};

}  // namespace covey
