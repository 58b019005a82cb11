// SPDX-License-Identifier: BSD-3-Clause
#include "procs/radio_bridge/radio_socket.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "core/base/error.h"
#include "core/radio/packet.h"

namespace covey {
namespace {

constexpr std::size_t kBatch = 64;
constexpr int kBatchesAtOnce = 8;
constexpr int kReceiveBufferBytes = 4 * 1024 * 1024;
constexpr std::size_t kCutBytes = radio::kMaxDatagramBytes + 1;

template <typename T>
bool set_option(int fd, int level, int name, const T& value) {
  return setsockopt(fd, level, name, &value, sizeof(value)) == 0;
}

int parse_number(const std::string& url, const std::string& text, int lowest, int highest) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < lowest || value > highest) {
    throw_input_error("{}: '{}' is not a number from {} to {}", url, text, lowest, highest);
  }
  return value;
}

sockaddr_in address_of(const RadioUrl& url) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(url.port);
  inet_pton(AF_INET, url.group.c_str(), &address.sin_addr);
  return address;
}

}  // namespace

RadioUrl parse_radio_url(const std::string& url) {
  constexpr std::string_view kScheme = "udpm://";
  if (url.rfind(kScheme, 0) != 0)
    throw_input_error("{}: a radio is udpm://GROUP:PORT[?ttl=N] or file://F.lcm", url);
  const std::string rest = url.substr(kScheme.size());
  const auto question = rest.find('?');
  const std::string place = rest.substr(0, question);
  const auto colon = place.find(':');
  if (colon == std::string::npos) throw_input_error("{}: the port is missing; udpm://GROUP:PORT", url);
  RadioUrl parsed;
  parsed.group = place.substr(0, colon);
  in_addr group{};
  if (inet_pton(AF_INET, parsed.group.c_str(), &group) != 1 || !IN_MULTICAST(ntohl(group.s_addr))) {
    throw_input_error("{}: '{}' is not a multicast address (224.0.0.0 to 239.255.255.255)", url,
                      parsed.group);
  }
  parsed.port = static_cast<std::uint16_t>(parse_number(url, place.substr(colon + 1), 1, 65535));
  if (question != std::string::npos) {
    const std::string option = rest.substr(question + 1);
    constexpr std::string_view kTtl = "ttl=";
    if (option.rfind(kTtl, 0) != 0) throw_input_error("{}: unknown option '{}'; known: ttl", url, option);
    parsed.ttl = parse_number(url, option.substr(kTtl.size()), 0, 255);
  }
  return parsed;
}

RadioSocket::RadioSocket(const RadioUrl& url, const std::string& interface_address) : url_(url) {
  fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd_ < 0) throw_input_error("the radio's socket cannot be opened: {}", std::strerror(errno));
  in_addr interface {};
  if (!interface_address.empty() && inet_pton(AF_INET, interface_address.c_str(), &interface) != 1) {
    throw_input_error("the radio's interface '{}' is not an address of this host such as 10.0.0.3",
                      interface_address);
  }
  const sockaddr_in address = address_of(url_);
  const auto fail = [&](const char* what) {
    const std::string reason = std::strerror(errno);
    close(fd_);
    throw_input_error("the radio {}:{} cannot be {}: {}; bin/check_net says what is wrong", url_.group,
                      url_.port, what, reason);
  };
  // Several bridges of one host share the port; every one of them hears every datagram.
  if (!set_option(fd_, SOL_SOCKET, SO_REUSEADDR, 1)) fail("shared");
  set_option(fd_, SOL_SOCKET, SO_RCVBUF, kReceiveBufferBytes);  // as much as the system lets us have
  set_option(fd_, SOL_SOCKET, SO_RXQ_OVFL, 1);
  set_option(fd_, IPPROTO_IP, IP_MULTICAST_ALL, 0);
  if (bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) fail("bound");
  if (!set_option(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, ip_mreq{address.sin_addr, interface})) fail("joined");
  if (!set_option(fd_, IPPROTO_IP, IP_MULTICAST_IF, interface)) fail("joined");
  if (!set_option(fd_, IPPROTO_IP, IP_MULTICAST_LOOP, 1)) fail("looped back");
  if (!set_option(fd_, IPPROTO_IP, IP_MULTICAST_TTL, url_.ttl < 0 ? 0 : url_.ttl)) fail("given a ttl");
}

RadioSocket::~RadioSocket() {
  if (fd_ >= 0) close(fd_);
}

void RadioSocket::receive(const Handler& handler) {
  static thread_local std::array<std::array<std::uint8_t, kCutBytes>, kBatch> buffers;
  std::array<std::array<char, CMSG_SPACE(sizeof(std::uint32_t))>, kBatch> controls;
  std::array<iovec, kBatch> parts{};
  std::array<mmsghdr, kBatch> messages{};
  for (int batch = 0; batch < kBatchesAtOnce; ++batch) {
    for (std::size_t i = 0; i < kBatch; ++i) {
      parts[i] = {buffers[i].data(), buffers[i].size()};
      messages[i].msg_hdr = {};
      messages[i].msg_hdr.msg_iov = &parts[i];
      messages[i].msg_hdr.msg_iovlen = 1;
      messages[i].msg_hdr.msg_control = controls[i].data();
      messages[i].msg_hdr.msg_controllen = controls[i].size();
    }
    const int received = recvmmsg(fd_, messages.data(), kBatch, 0, nullptr);
    for (int i = 0; i < received; ++i) {
      mmsghdr& message = messages[static_cast<std::size_t>(i)];
      for (cmsghdr* control = CMSG_FIRSTHDR(&message.msg_hdr); control != nullptr;
           control = CMSG_NXTHDR(&message.msg_hdr, control)) {
        if (control->cmsg_level != SOL_SOCKET || control->cmsg_type != SO_RXQ_OVFL) continue;
        std::uint32_t drops = 0;
        std::memcpy(&drops, CMSG_DATA(control), sizeof(drops));
        kernel_drops_ = drops;
      }
      handler({buffers[static_cast<std::size_t>(i)].data(), message.msg_len});
    }
    if (received < static_cast<int>(kBatch)) return;
  }
}

const char* RadioSocket::send(radio::ByteView datagram) {
  const sockaddr_in address = address_of(url_);
  const auto sent = sendto(fd_, datagram.data(), datagram.size(), 0,
                           reinterpret_cast<const sockaddr*>(&address), sizeof(address));
  if (sent == static_cast<ssize_t>(datagram.size())) return nullptr;
  return errno == EAGAIN || errno == ENOBUFS ? "send_buffer_full" : "send_failed";
}

}  // namespace covey
