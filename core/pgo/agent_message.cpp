// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/agent_message.h"

#include <type_traits>
#include <utility>

namespace covey::pgo {
namespace {

template <std::size_t Kind = 0>
std::optional<AgentMessage> decode_kind(std::uint64_t fingerprint, const Bytes& bytes) {
  if constexpr (Kind < std::variant_size_v<AgentMessage>) {
    std::variant_alternative_t<Kind, AgentMessage> message{};
    if (static_cast<std::uint64_t>(message.getHash()) != fingerprint)
      return decode_kind<Kind + 1>(fingerprint, bytes);
    if (decode(bytes, message)) return AgentMessage(std::move(message));
  }
  return std::nullopt;
}

}  // namespace

int sender_of(const AgentMessage& message) {
  return std::visit([](const auto& m) { return m.from; }, message);
}

const char* type_of(const AgentMessage& message) {
  return std::visit([](const auto& m) { return m.getTypeName(); }, message);
}

std::size_t bytes_of(const AgentMessage& message) {
  return std::visit([](const auto& m) { return static_cast<std::size_t>(m.getEncodedSize()); }, message);
}

std::optional<RoundMessage> round_message(const AgentMessage& message) {
  return std::visit(
      [](const auto& m) -> std::optional<RoundMessage> {
        if constexpr (std::is_constructible_v<RoundMessage, decltype(m)>) return RoundMessage(m);
        return std::nullopt;
      },
      message);
}

Bytes encode_message(const AgentMessage& message) {
  return std::visit([](const auto& m) { return encode(m); }, message);
}

std::optional<AgentMessage> decode_message(const Bytes& bytes) {
  if (bytes.size() < 8) return std::nullopt;
  std::uint64_t fingerprint = 0;
  for (int i = 0; i < 8; ++i) fingerprint = fingerprint << 8 | bytes[static_cast<std::size_t>(i)];
  return decode_kind(fingerprint, bytes);
}

}  // namespace covey::pgo
