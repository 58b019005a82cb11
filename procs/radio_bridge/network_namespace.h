// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Moves this process into the network namespace at `path` (/proc/PID/ns/net, or a name under /run/netns). Where a user
// namespace stands beside it (/proc/PID/ns/user) that is not ours, it is entered first: it owns the network. Sockets that
// are open stay where they were opened. Throws InputError. Only for a process with one thread.

#include <string>

namespace covey {

void enter_network_namespace(const std::string& path);

}  // namespace covey
