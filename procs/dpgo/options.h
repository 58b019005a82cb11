// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/config.h"
#include "core/pgo/dgnc_agent.h"

namespace covey {

// Section `dpgo` of the configuration; procs/dpgo/README.md explains the keys.
pgo::AgentOptions read_agent_options(ConfigSection& section);

}  // namespace covey
