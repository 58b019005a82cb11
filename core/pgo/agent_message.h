// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Whatever the dpgo of two robots say to each other, and what it is as bytes.

#include <covey/dpgo_beacon_t.hpp>
#include <covey/dpgo_neighbours_t.hpp>
#include <covey/dpgo_relay_t.hpp>
#include <covey/dpgo_request_t.hpp>
#include <covey/dpgo_round_t.hpp>
#include <optional>
#include <variant>

#include "core/base/bytes.h"
#include "core/pgo/round_message.h"

namespace covey::pgo {

using AgentMessage = std::variant<dpgo_beacon_t, dpgo_neighbours_t, dpgo_round_t, dpgo_request_t, dpgo_join_t,
                                  dpgo_keys_t, dpgo_keyframes_t, dpgo_alignment_t, dpgo_advance_t,
                                  dpgo_coarse_t, dpgo_graph_t, dpgo_poses_t, dpgo_relay_t>;

int sender_of(const AgentMessage& message);
const char* type_of(const AgentMessage& message);  // "dpgo_beacon_t"
std::size_t bytes_of(const AgentMessage& message);

// None where it is of no round.
std::optional<RoundMessage> round_message(const AgentMessage& message);

Bytes encode_message(const AgentMessage& message);
// By the fingerprint; none where the bytes are not exactly one of these messages.
std::optional<AgentMessage> decode_message(const Bytes& bytes);

}  // namespace covey::pgo
